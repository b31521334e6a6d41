"""The agents that come with the project: baselines, the training set-up, trained agents.

Their home is the folder `agents/` of the checkout; an installed wheel carries it among its assets. This package is
a window onto that folder, so there is one import name everywhere: ``ssmash_gym.agents.<module>``.
"""

from __future__ import annotations

from ssmash_gym.assets import asset_path

__path__ = [str(asset_path("agents"))]
