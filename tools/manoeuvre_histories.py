"""Searches the shape numbers of the claw histories of manoeuvres 2A and 2C; prints them and what they give.

The records of the trials are unpublished. What is known of them is a few sentences and the printed axes of section
3.2.2. The few points of a history (and the yaw at the start) are searched so that the response stays within those axes,
uses most of them, and does what the sentences say. The files in configs/manoeuvres hold results of it, rounded.

python tools/manoeuvre_histories.py 2C --generations 12 --candidates 160 --seed 1
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.cases import Case, load_case
from ssmash_gym.cases.claw import ClawPoints, claw_nodes, longest_node_s
from ssmash_gym.cases.description import case_document, case_from
from ssmash_gym.cases.start import Settled
from ssmash_gym.dynamics.layout import State
from ssmash_gym.simulation.batch import Batch
from ssmash_gym.simulation.claw import ClawLimits
from ssmash_gym.simulation.parameters import Modes
from ssmash_gym.simulation.timing import Timing

Array = NDArray[np.float64]
ROW_S = 0.1  # between the rows that a history is judged by
PARENTS = 24
CHANNELS = {
    "yaw": ("yaw", 180.0 / np.pi),
    "steer": ("auxiliary_steer", 180.0 / np.pi),
    "fx": ("probe_fx", 1e-3),
    "fy": ("probe_fy", 1e-3),
    "right": ("right_tire_lateral_deflection", 1e3),
    "left": ("left_tire_lateral_deflection", 1e3),
    "right_load": ("right_vertical_load", 1e-3),
    "left_load": ("left_vertical_load", 1e-3),
    "yaw_rate": ("yaw_rate", 180.0 / np.pi),
}
Curves = Mapping[str, Array]  # (rows, candidates), in degrees, kN, mm


@dataclass(frozen=True)
class Want:
    """A number of the response and the range it should lie in; a miss counts by `scale`."""

    name: str
    number: Callable[[Curves, Array], Array]
    low: float
    high: float
    scale: float

    def miss(self, curves: Curves, time: Array) -> Array:
        """How far each candidate is off, (candidates,)."""
        value = self.number(curves, time)
        return np.asarray((np.maximum(self.low - value, 0.0) + np.maximum(value - self.high, 0.0)) / self.scale)


@dataclass(frozen=True)
class Search:
    """What is searched for one manoeuvre.

    Attributes:
        names: Of the shape numbers; low, high: their ranges.
        points: From the shape numbers to the points of the claw (time, x, y) and the yaw at the start [deg].
        wants: By the friction law under which they are wanted.
    """

    names: tuple[str, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]
    points: Callable[[Array], tuple[Sequence[float], Sequence[float], Sequence[float], float]]
    wants: Mapping[str, tuple[Want, ...]]


def most(*names: str) -> Callable[[Curves, Array], Array]:
    """Greatest value of any of the curves."""
    return lambda curves, time: np.max([curves[name].max(axis=0) for name in names], axis=0)


def least(*names: str) -> Callable[[Curves, Array], Array]:
    """Least value of any of the curves."""
    return lambda curves, time: np.min([curves[name].min(axis=0) for name in names], axis=0)


def at(name: str, seconds: float) -> Callable[[Curves, Array], Array]:
    """A curve at a time."""
    return lambda curves, time: curves[name][np.searchsorted(time, seconds - 1e-9)]


def mean_deflection(seconds: float) -> Callable[[Curves, Array], Array]:
    """Mean lateral deflection of the main tires at a time."""
    return lambda curves, time: 0.5 * (at("right", seconds)(curves, time) + at("left", seconds)(curves, time))


def points_2A(p: Array) -> tuple[Sequence[float], Sequence[float], Sequence[float], float]:
    far_y, back_x, back_y = p
    return (0, 4, 20, 23, 36, 40), (0, 0.02, 0.65, 0.65, back_x, back_x), (0, 0, far_y, far_y, back_y, back_y), 9.0


def points_2C(p: Array) -> tuple[Sequence[float], Sequence[float], Sequence[float], float]:
    yaw, x_20, x_2, x_3, x_4, y_0, y_20, y_2, y_3, y_4, t_2, span = p
    time = (0.0, 9.0, 20.0, t_2, t_2 + span, 70.0, 80.0)
    return time, (0.0, 0.0, x_20, x_2, x_3, x_4, x_4), (y_0, y_0, y_20, y_2, y_3, y_4, y_4), yaw


SEARCHES = {
    "2A": Search(
        ("far_y", "back_x", "back_y"),
        (0.0, 0.0, -0.05),
        (0.06, 0.2, 0.03),
        points_2A,
        {
            "limit_surface": (
                Want("least Fy", least("fy"), -24.0, -20.0, 1.0),
                Want("greatest Fy", most("fy"), 4.0, 9.5, 1.0),
                Want("lateral deflection", most("right", "left"), 15.0, 25.0, 2.0),
                Want("its reverse", least("right", "left"), -8.0, 0.0, 2.0),
                Want("vertical load", most("right_load", "left_load"), 32.0, 34.5, 1.0),
            )
        },
    ),
    "2C": Search(
        ("yaw", "x_20", "x_2", "x_3", "x_4", "y_0", "y_20", "y_2", "y_3", "y_4", "t_2", "span"),
        (10.2, 0.50, 0.20, -0.18, -0.18, 0.0, 0.05, -0.18, -0.18, -0.18, 28.0, 3.0),
        (13.0, 0.58, 0.58, 0.40, 0.30, 0.35, 0.45, 0.10, 0.25, 0.25, 33.0, 25.0),
        points_2C,
        {
            "limit_surface": (
                Want("greatest yaw", most("yaw"), 25.5, 27.5, 2.0),
                Want("least yaw", least("yaw"), 10.1, 13.0, 1.0),
                Want("steer at the end", at("steer", 80.0), -180.0, -165.0, 6.0),
                Want("greatest steer", most("steer"), -1.0, 2.0, 3.0),
                Want("least Fy", least("fy"), -37.0, -24.0, 4.0),
                Want("greatest Fy", most("fy"), 12.0, 27.0, 4.0),
                Want("least Fx", least("fx"), -17.0, -3.0, 3.0),
                Want("greatest Fx", most("fx"), 2.0, 12.0, 6.0),
                Want("lateral deflection", most("right", "left"), 21.0, 38.0, 4.0),
                Want("its reverse", least("right", "left"), -18.0, -8.0, 3.0),
                Want("least vertical load", least("right_load", "left_load"), 21.0, 26.0, 2.0),
                Want("greatest vertical load", most("right_load", "left_load"), 34.0, 39.0, 2.0),
                Want("time of greatest yaw rate", lambda c, t: t[np.argmax(c["yaw_rate"], axis=0)], 20.0, 32.0, 1.0),
            ),
            "independent": (
                Want("least Fy", least("fy"), -39.0, -24.0, 6.0),
                Want("greatest Fy", most("fy"), 5.0, 29.0, 6.0),
                Want("least Fx", least("fx"), -19.5, 0.0, 4.0),
                Want("lateral deflection", most("right", "left"), 24.0, 39.5, 5.0),
                Want("its reverse", least("right", "left"), -19.5, 0.0, 5.0),
                Want("steer at the end", at("steer", 80.0), -182.0, -150.0, 20.0),
                Want("deflection at 29 s", mean_deflection(29.0), 14.0, 40.0, 4.0),
                Want("deflection at 38 s", mean_deflection(38.0), -15.0, 5.0, 4.0),
            ),
        },
    ),
}


def case_of(case: Case, search: Search, p: Array) -> Case:
    """The case with the shape numbers `p` and its noise."""
    time, x, y, yaw = search.points(p)
    document = case_document(case)
    plain = {"time_s": [float(v) for v in time], "x_m": [float(v) for v in x], "y_m": [float(v) for v in y]}
    kept = {key: document["claw"][key] for key in ("z_m", "noise")}
    claw = {"type": "points", "relative_to": "ship", **plain, **kept}
    start = {**document["start"], "x_m": float(x[0]), "y_m": float(y[0]), "yaw_deg": float(yaw)}
    return case_from({**document, "claw": claw, "start": start, "provenance": []})


def respond(cases: Sequence[Case], friction: str) -> tuple[Array, dict[str, Array]]:
    """Run cases of one vehicle side by side: times (rows,) and curves (rows, cases)."""
    first = cases[0]
    claws = [one.claw for one in cases if isinstance(one.claw, ClawPoints)]
    timing = Timing(first.solution.substep_s, ROW_S, longest_node_s(claws[0]))
    modes = Modes(**{**first.model.model_dump(), "friction": friction})
    batch = Batch(first.vehicle, len(cases), timing=timing, modes=modes, claw=ClawLimits(height_m=-claws[0].z_m))
    starts = [one.start for one in cases if isinstance(one.start, Settled)]
    batch.place(*np.array([(start.x_m, start.y_m, np.radians(start.yaw_deg)) for start in starts]).T)
    half = np.radians([0.5 * start.steer_deg for start in starts])
    batch.state[State.Q16], batch.state[State.Q16 + 3] = np.cos(half), np.sin(half)
    batch.settle()
    here = batch.state[State.CLAW_X : State.CLAW_Y + 1].T
    end, spacing = first.solution.end_s, batch.timing.node_spacing_s
    nodes = [claw_nodes(claw, at, 0.0, end, spacing, first.seed) for claw, at in zip(claws, here, strict=True)]
    batch.prescribe_claw(nodes)
    read = batch.evaluate()
    curves = {name: [scale * read[channel]] for name, (channel, scale) in CHANNELS.items()}
    count = round(end / ROW_S)
    for _ in range(count):
        read = batch.advance()
        for name, (channel, scale) in CHANNELS.items():
            curves[name].append(scale * read[channel])
    table = {name: np.array(values) for name, values in curves.items()}
    table["steer"] = np.degrees(np.unwrap(np.radians(table["steer"]), axis=0))
    return ROW_S * np.arange(count + 1), {k: np.where(batch.diverged, 1e6, v) for k, v in table.items()}


def misses(search: Search, cases: Sequence[Case]) -> dict[str, Array]:
    """Every want's miss, (cases,)."""
    found = {}
    for friction, wants in search.wants.items():
        time, curves = respond(cases, friction)
        found.update({f"{friction}: {want.name}": want.miss(curves, time) for want in wants})
    return found


def search_points(case: Case, search: Search, generations: int, count: int, seed: int) -> tuple[float, Array]:
    """The best shape numbers of a random search that goes on from the better ones."""
    rng = np.random.default_rng(seed)
    low, high = np.array(search.low), np.array(search.high)
    pool = rng.uniform(low, high, (count, low.size))
    best: list[tuple[float, Array]] = []
    for generation in range(generations):
        total = np.sum(list(misses(search, [case_of(case, search, p) for p in pool]).values()), axis=0)
        best = sorted([*best, *zip(total.tolist(), pool, strict=True)], key=lambda pair: pair[0])[:PARENTS]
        print(f"generation {generation}: {best[0][0]:.3f}", flush=True)
        parents = np.array([p for _, p in best])
        share = rng.random((count, 1))
        mixed = parents[rng.integers(len(parents), size=count)] * share
        mixed += parents[rng.integers(len(parents), size=count)] * (1.0 - share)
        step = rng.choice([0.02, 0.06, 0.15], (count, 1)) * (high - low)
        pool = np.clip(mixed + rng.normal(size=mixed.shape) * step, low, high)
    return best[0]


def show(found: Mapping[str, Array]) -> None:
    """Print the misses of one case."""
    for name, miss in found.items():
        print(f"  {name}: {miss[0]:.3f}")
    print(f"  in all: {sum(miss[0] for miss in found.values()):.3f}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("manoeuvre", choices=sorted(SEARCHES))
    parser.add_argument("--generations", type=int, default=12)
    parser.add_argument("--candidates", type=int, default=160)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    case, search = load_case(given.manoeuvre), SEARCHES[given.manoeuvre]
    print("misses of the file as it is:")
    show(misses(search, [case]))
    _, p = search_points(case, search, given.generations, given.candidates, given.seed)
    for name, value in zip(search.names, p, strict=True):
        print(f"  {name} {value:.3f}")
    time, x, y, yaw = search.points(p)
    print(
        f"yaw_deg {yaw:.2f}", *(f"{key} {np.round(v, 3).tolist()}" for key, v in zip("txy", (time, x, y), strict=True))
    )
    show(misses(search, [case_of(case, search, p)]))


if __name__ == "__main__":
    main()
