"""Shipboard securing and manoeuvring of helicopters: dynamics, environment, training.

Importing the package registers its Gymnasium environments, and neither imports nor compiles anything heavy.
"""

from __future__ import annotations

from ssmash_gym.registration import register_environments

__version__ = "0.1.0"

register_environments()
