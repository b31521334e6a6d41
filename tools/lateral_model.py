"""A linear model of the lateral motion, identified on the simulation, and its replay with what the model leaves over.

python tools/lateral_model.py

Helicopters are driven along the track with lateral commands that yield, centre and shake at random; sensors are
exact. From one control interval to the next, twelve observed terms follow by least squares from those before, the last
three lateral commands, and the speed along the track times yaw and steer angle. What is known is not fitted: where the
claw is changes nothing but itself, and the deck does not know of the helicopter. Four models cover the begin of the
track, the way, its end, and standing at the goal. The tool writes them to `agents/data/lateral_model.yaml` with what
they explain.

`Replay` drives a policy on the model with the recorded deck and the recorded residuals as disturbances, which is some
fifty times faster than the simulation and close enough to it to search gains on: `tools/law_search.py`.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from ssmash_gym.agents.laws import Trapezoid

from ssmash_gym.assets import asset_path
from ssmash_gym.document import write_yaml
from ssmash_gym.envs import load_scenario, load_task
from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.envs.observations import TERMS
from ssmash_gym.envs.task import TaskConfig
from ssmash_gym.files import write_text
from ssmash_gym.training.seeds import TUNING, block

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

STATE: Final = (
    "probe_fy", "yaw", "yaw_rate", "claw_vy", "roll", "roll_rate", "auxiliary_steer_sin", "deck_fy", "deck_wx",
    "deck_roll", "deck_wz", "claw_y",
)  # fmt: skip
DECK: Final = ("deck_fy", "deck_wx", "deck_roll", "deck_wz")
INPUTS: Final = ("command", "command_before", "command_before_that", "speed_yaw", "speed_steer")
PLACES_M: Final = (0.9, 6.0, 7.99)  # claw x at which the next model begins
OVERLAP_M: Final = 0.1
STANDING_M_S: Final = 0.03
RIDGE: Final = 1e-2
SUBSTEP_S: Final = 0.005
MODEL_SEEDS: Final = 3  # number of the block
AT: Final = {name: k for k, name in enumerate(STATE)}
SCALES: Final = np.array([TERMS[name].scale for name in STATE])
NOISE: Final = np.array([TERMS[name].noise for name in STATE]) / SCALES


@dataclass(frozen=True)
class Recording:
    """Excited episodes, in observed units; intervals first, then helicopters.

    Attributes:
        state: Terms at each instant, (T + 1, n, 12); zero after the end.
        command: Lateral commands of each interval, (T, n); speed_m_s, place_m: along the track, (T, n).
        running: Whether the episode has got to the instant, (T + 1, n).
    """

    state: Array
    command: Array
    speed_m_s: Array
    place_m: Array
    running: Flags


@dataclass(frozen=True)
class Model:
    """One linear model for each part of the track.

    Attributes:
        matrices: (4, 12, 17): next terms from terms and `INPUTS`.
        explained: (4, 12): share of the variance that one interval ahead is explained.
    """

    matrices: Array
    explained: Array


class Shaker(Trapezoid):
    """By the book at a speed of each row's own, with lateral commands that yield, centre and shake."""

    terms = ("claw_y", "probe_fy")

    def __init__(self, task: TaskConfig, count: int, seed: int) -> None:
        super().__init__(task)
        self.rng = np.random.default_rng(seed)
        self.top_m_s = self.rng.uniform(0.15, 0.25, count)
        self.k_y = self.rng.choice([1e-6, 2e-6, 3e-6, 5e-6], count)
        self.k_c = self.rng.choice([0.05, 0.15, 0.3], count)
        self.shake_m_s = self.rng.choice([0.0, 0.01, 0.02, 0.03], count)
        self._shaken = np.zeros(count)

    def travelled(self, time_s: Array) -> Array:
        """As the trapezoid, with the row's speed."""
        stretch = self.top_m_s / 0.2
        return super().travelled(np.asarray(time_s) * stretch)

    def across(self, observations: NDArray[np.float32], before: Array, after: Array) -> Array:
        """Way across the track in this interval [m], (n,)."""
        self._shaken = 0.8 * self._shaken + 0.6 * self.rng.standard_normal(self._shaken.size)
        speed = -self.k_y * self.readout(observations, "probe_fy") - self.k_c * self.readout(observations, "claw_y")
        return np.asarray((speed + self.shake_m_s * self._shaken) * self.task.control_interval_s)


def record(delay_s: float, episodes: int, threads: int = 1) -> Recording:
    """Drive excited episodes of sea state 5 with exact sensors."""
    task = load_task({"substep_s": SUBSTEP_S, "claw": {"delay_s": delay_s}})
    exact = {"sensors": {"noise": 0.0, "delay_s": 0.0}, "claw": {"ripple_along_m": 0.0, "ripple_across_m": 0.0}}
    scenario = load_scenario({"base": "ss5", **exact})
    core = TraverseBatch(episodes, task=task, scenario=scenario, threads=threads)
    observations = core.reset(seeds=block(MODEL_SEEDS, TUNING, episodes))
    places = [core.observer.names.index(name) for name in STATE]
    policy = Shaker(task, episodes, 0)
    policy.reset(episodes)
    steps = task.horizon_steps
    found = Recording(
        np.zeros((steps + 1, episodes, len(STATE))), *(np.zeros((steps, episodes)) for _ in range(3)),
        np.zeros((steps + 1, episodes), dtype=np.bool_),
    )  # fmt: skip
    running, place = np.arange(episodes), np.zeros(episodes)
    found.state[0], found.running[0] = observations[:, places], True
    for k in range(steps):
        if not running.size:
            break
        actions = policy.act(observations)
        speed = actions[:, 0].astype(np.float64) * task.claw.speed_along_m_s
        found.command[k], found.speed_m_s[k], found.place_m[k] = actions[:, 1], speed, place
        place = place + speed * task.control_interval_s
        result = core.step(actions[running], running)
        observations[running] = result.observation
        found.state[k + 1, running] = observations[running][:, places]
        found.running[k + 1, running] = True
        running = running[~(result.terminated | result.truncated)]
    return found


def part_of(place_m: Array) -> NDArray[np.int64]:
    """Which model holds at a place."""
    return np.searchsorted(PLACES_M, place_m, side="right")


def regressors(state: Array, commands: tuple[Array, Array, Array], speed_m_s: Array) -> Array:
    """What the next terms follow from, (n, 17)."""
    fast = 5.0 * speed_m_s
    more = np.stack([*commands, fast * state[:, AT["yaw"]], fast * state[:, AT["auxiliary_steer_sin"]]], axis=1)
    return np.concatenate([state, more], axis=1)


def identify(recording: Recording) -> Model:
    """Fit the models by least squares."""
    rows, targets, places, speeds = [], [], [], []
    none = np.zeros(recording.command.shape[1])
    for k in range(len(recording.command)):
        on = recording.running[k + 1]
        before = [recording.command[k - lag] if k >= lag else none for lag in (0, 1, 2)]
        made = regressors(recording.state[k], (before[0], before[1], before[2]), recording.speed_m_s[k])
        rows.append(made[on])
        targets.append(recording.state[k + 1][on])
        places.append(recording.place_m[k][on])
        speeds.append(recording.speed_m_s[k][on])
    a, y, place, speed = (np.concatenate(parts) for parts in (rows, targets, places, speeds))
    edges = (0.0, *PLACES_M, np.inf)
    found = []
    for part, (first, last) in enumerate(pairwise(edges)):
        standing = part == len(PLACES_M)
        near = (place >= first - OVERLAP_M) & (place < last + OVERLAP_M) & ((speed < STANDING_M_S) == standing)
        near |= (place < OVERLAP_M) & (part == 0)
        found.append(_fitted(a[near], y[near]))
    return Model(np.array([matrix for matrix, _ in found]), np.array([share for _, share in found]))


def _fitted(a: Array, y: Array) -> tuple[Array, Array]:
    """Matrix (12, 17) of one part, and what it explains."""
    count = len(STATE)
    matrix = np.zeros((count, count + len(INPUTS)))
    claw = [AT["claw_vy"], count, count + 1, count + 2]
    helicopter = [k for k in range(count + len(INPUTS)) if k != AT["claw_y"]]
    for row, name in enumerate(STATE):
        if name == "claw_y":
            continue
        use = [AT[deck] for deck in DECK] if name in DECK else claw if name == "claw_vy" else helicopter
        b = a[:, use]
        matrix[row, use] = np.linalg.solve(b.T @ b + RIDGE * np.eye(len(use)), b.T @ y[:, row])
    matrix[AT["claw_y"]] = 0.05 * matrix[AT["claw_vy"]]  # 0.1 s of the mean of both speeds; the scales are alike
    matrix[AT["claw_y"], AT["claw_vy"]] += 0.05
    matrix[AT["claw_y"], AT["claw_y"]] = 1.0
    left = y - a @ matrix.T
    return matrix, 1.0 - left.var(axis=0) / np.maximum(y.var(axis=0), 1e-12)


class Replay:
    """Policies on the model, with the deck and the residuals of a recording.

    Args:
        recording: What is replayed.
        model: What answers to the policies.
        delay_s: Of the drive, for the task that policies are made for.
    """

    def __init__(self, recording: Recording, model: Model, delay_s: float) -> None:
        names = ["claw_x", "to_go", "last_command_y", *STATE]
        self.task = load_task({"observation": names, "claw": {"delay_s": delay_s}})
        self.names = names
        self.model, self.recording = model, recording
        self.residual = np.zeros_like(recording.state)
        none = np.zeros(recording.command.shape[1])
        for k in range(len(recording.command)):
            before = [recording.command[k - lag] if k >= lag else none for lag in (0, 1, 2)]
            made = regressors(recording.state[k], (before[0], before[1], before[2]), recording.speed_m_s[k])
            left = recording.state[k + 1] - self._next(made, recording.place_m[k])
            self.residual[k + 1] = np.where(recording.running[k + 1][:, None], left, 0.0)
        rng = np.random.default_rng(0)
        self.noise = rng.standard_normal(recording.state.shape) * NOISE * rng.uniform(0.5, 1.5, none.size)[:, None]
        self.lag = rng.uniform(0.0, 1.0, none.size)[:, None]  # of the sensors, in control intervals

    def _next(self, made: Array, place_m: Array) -> Array:
        found = np.empty((len(made), len(STATE)))
        part = part_of(place_m)
        for k in range(len(self.model.matrices)):
            here = part == k
            if here.any():
                found[here] = made[here] @ self.model.matrices[k].T
        return found

    def run(self, policy: Trapezoid, copies: int) -> list[dict[str, float]]:
        """Figures of a policy whose row i n + k drives the recording's helicopter k with the gains of copy i."""
        task, recording = self.task, self.recording
        dt, goal = task.control_interval_s, task.goal
        column = np.tile(np.arange(recording.command.shape[1]), copies)
        lag, deck = self.lag[column], [AT[name] for name in DECK]
        scale = {name: TERMS[name].scale for name in self.names}
        state = recording.state[0][column]
        before, last, older = state, *np.zeros((2, column.size))
        place, held = np.zeros(column.size), np.zeros(column.size)
        peak_N, end_s = np.zeros(column.size), np.full(column.size, task.horizon_s)
        policy.reset(column.size)
        for k in range(task.horizon_steps - 1):
            seen = lag * before + (1.0 - lag) * state + self.noise[k][column]
            known = [place / scale["claw_x"], (task.track.goal_x_m - place) / scale["to_go"], last]
            action = policy.act(np.concatenate([np.stack(known, axis=1), seen], axis=1).astype(np.float32))
            speed = action[:, 0].astype(np.float64) * task.claw.speed_along_m_s
            made = regressors(state, (action[:, 1].astype(np.float64), last, older), speed)
            ahead = self._next(made, place) + self.residual[k + 1][column]
            on = recording.running[k + 1][column]
            ahead[:, deck] = np.where(on[:, None], recording.state[k + 1][column][:, deck], ahead[:, deck])
            reach = task.claw.y_travel_m / scale["claw_y"]
            ahead[:, AT["claw_y"]] = np.clip(ahead[:, AT["claw_y"]], -reach, reach)
            before, state = state, ahead
            last, older = action[:, 1].astype(np.float64), last
            place = place + speed * dt
            moving = end_s == task.horizon_s
            if k + 1 > task.grace_steps:
                load_N = np.abs(state[:, AT["probe_fy"]]) * scale["probe_fy"]
                peak_N = np.where(moving, np.maximum(peak_N, load_N), peak_N)
            inside = place > task.track.goal_x_m - goal.x_tolerance_m
            inside &= np.abs(state[:, AT["yaw"]]) * scale["yaw"] < np.deg2rad(goal.yaw_tolerance_deg)
            inside &= np.abs(state[:, AT["claw_y"]]) * scale["claw_y"] < goal.y_tolerance_m
            held = np.where(inside, held + 1, 0)
            end_s = np.where(moving & (held * dt >= goal.hold_s), (k + 1) * dt, end_s)
            if not (end_s == task.horizon_s).any():
                break
        each = zip(np.split(peak_N, copies), np.split(end_s, copies), strict=True)
        return [_figures(1e-3 * peak, end, task) for peak, end in each]


def _figures(peak_kN: Array, end_s: Array, task: TaskConfig) -> dict[str, float]:
    done = end_s < task.horizon_s
    largest = np.sort(peak_kN)[-max(1, len(peak_kN) // 10) :]
    return {
        "success": float(np.mean(done)),
        "peak_p95_kN": float(np.percentile(peak_kN, 95.0)),
        "peak_top_tenth_kN": float(np.mean(largest)),
        "median_time_s": float(np.median(end_s[done])) if done.any() else task.horizon_s,
    }


def document(model: Model, delay_s: float, episodes: int) -> dict[str, Any]:
    """The model as the file holds it."""
    parts = ("begin", "way", "end", "standing")
    return {
        "provenance": {
            "made_by": "python tools/lateral_model.py",
            "seeds": f"training.seeds.block({MODEL_SEEDS}, TUNING, {episodes}), sea state 5",
            "delay_s": delay_s,
            "meaning": "terms an interval of 0.1 s later, in observed units, from terms and inputs before",
            "inputs": "lateral commands (of the interval, the one before, the one before that); 5 times the speed "
            "along the track [m/s] times yaw, and times the sine of the steer angle",
        },
        "columns": [*STATE, *INPUTS],
        "models": {
            name: {
                "explained": {term: round(float(share), 4) for term, share in zip(STATE, shares, strict=True)},
                "rows": {term: [float(f"{v:.5g}") for v in row] for term, row in zip(STATE, matrix, strict=True)},
            }
            for name, matrix, shares in zip(parts, model.matrices, model.explained, strict=True)
        },
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--delay", type=float, default=0.1, help="of the drive [s]")
    parser.add_argument("--episodes", type=int, default=96)
    parser.add_argument("--threads", type=int, default=1)
    options = parser.parse_args()
    model = identify(record(options.delay, options.episodes, options.threads))
    path = asset_path("agents", "data") / "lateral_model.yaml"
    write_text(path, write_yaml(document(model, options.delay, options.episodes)))
    for name, shares in zip(("begin", "way", "end", "standing"), model.explained, strict=True):
        told = ", ".join(f"{term} {share:.3f}" for term, share in zip(STATE, shares, strict=True))
        print(f"{name}: explained one interval ahead: {told}")


if __name__ == "__main__":
    main()
