"""Scenes moved about, for the tests of the picture."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ssmash_gym.envs.rendering import Scene


def far(scene: Scene, where: np.ndarray) -> Scene:
    wheels = scene.wheels
    shift = {name: getattr(wheels, name) + where for name in ("r_ST_S", "r_SO_S", "r_SW_S")}
    return replace(
        scene,
        r_SH_S=scene.r_SH_S + where,
        r_SA_S=scene.r_SA_S + where,
        r_SB_S=scene.r_SB_S + where,
        wheels=replace(wheels, **shift),
    )
