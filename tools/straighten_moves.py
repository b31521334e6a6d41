"""Prints what single moves of the claw do to a crooked helicopter on a level deck at rest.

python tools/straighten_moves.py
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.envs import load_task
from ssmash_gym.envs.batch_env import TraverseBatch

Array = NDArray[np.float64]
Velocity = Callable[[float, float, float], tuple[float, float]]  # of claw x, y [m] and yaw [rad]: along, across [m/s]
SETTLE: Final = 20  # control intervals at rest after a move
TASK: Final = load_task(
    {  # room for every move, and no goal that would end it
        "base": "straighten",
        "claw": {"x_min_m": -4.0, "x_max_m": 8.0, "y_travel_m": 3.0},
        "goal": {"yaw_tolerance_deg": 1e-6},
        "corridor": {"half_width_m": 20.0, "door_half_width_m": 20.0},
    }
)


def until(coordinate: int, end: float, velocity: Velocity) -> Velocity:
    """A move that ends where the claw's x (0) or y (1) has come to `end` [m]."""

    def move(x: float, y: float, yaw: float) -> tuple[float, float]:
        there = (x, y)[coordinate]
        return velocity(x, y, yaw) if abs(there) < abs(end) else (0.0, 0.0)

    return move


def axial(speed: float) -> Velocity:
    """Along the helicopter's own axis."""
    return lambda x, y, yaw: (speed * float(np.cos(yaw)), speed * float(np.sin(yaw)))


MOVES: Final[dict[str, tuple[float, Velocity]]] = {  # yaw at the start [deg] and the move
    "pull 4 m forward at 0.1 m/s": (30.0, until(0, 4.0, lambda x, y, yaw: (0.1, 0.0))),
    "pull 4 m forward at 0.2 m/s": (30.0, until(0, 4.0, lambda x, y, yaw: (0.2, 0.0))),
    "the same from 10 deg": (10.0, until(0, 4.0, lambda x, y, yaw: (0.2, 0.0))),
    "push 1 m aft at 0.1 m/s, from 10 deg": (10.0, until(0, 1.0, lambda x, y, yaw: (-0.1, 0.0))),
    "0.6 m to port at 0.05 m/s": (30.0, until(1, 0.6, lambda x, y, yaw: (0.0, -0.05))),
    "0.6 m to starboard at 0.05 m/s": (30.0, until(1, 0.6, lambda x, y, yaw: (0.0, 0.05))),
    "1 m forward along its own axis at 0.2 m/s": (30.0, until(0, 1.0, axial(0.2))),
    "1 m aft along its own axis at 0.2 m/s": (30.0, until(0, 1.0, axial(-0.2))),
}


def main() -> None:
    moves = list(MOVES.values())
    batch = TraverseBatch(len(moves), task=TASK, scenario={"base": "calm", "start": {"yaw_deg": 0.0, "lateral_m": 0.0}})
    plain = batch.scenario.sample(np.random.default_rng(0))
    batch.reset(seeds=list(range(len(moves))), draws=[replace(plain, start_yaw_deg=yaw) for yaw, _ in moves])
    speeds = np.array([TASK.claw.speed_along_m_s, TASK.claw.speed_across_m_s])
    for _ in range(TASK.horizon_steps - SETTLE):
        told = batch.telemetry
        places = zip(told["claw_x"], told["claw_y"], told["yaw"], strict=True)
        wanted = [move(*map(float, place)) for (_, move), place in zip(moves, places, strict=True)]
        running = np.flatnonzero(~batch.book.over)
        batch.step((np.array(wanted) / speeds)[running], running)
    told = batch.telemetry
    print("| move | yaw before, deg | after | castor after, deg | peak probe load, kN |\n|---|---|---|---|---|")
    for k, (name, (yaw, _)) in enumerate(MOVES.items()):
        after, castor = (float(np.rad2deg(told[channel][k])) for channel in ("yaw", "auxiliary_steer"))
        print(f"| {name} | {yaw:.0f} | {after:.1f} | {castor:.0f} | {1e-3 * batch.book.peak_probe_N[k]:.1f} |")


if __name__ == "__main__":
    main()
