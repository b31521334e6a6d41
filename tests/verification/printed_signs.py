"""What the two sign errors of the print in chapter 2 would do: ``python -m tests.verification.printed_signs``.

Prints the figures of docs/theory/rigid_body.md: relative change of the accelerations of the reference cases, the same
near rest, and how far the energy of an unforced motion drifts.
"""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

from tests.verification import kane_kinematics as kin
from tests.verification import kane_literal as kane

CASES = json.loads((Path(__file__).parent / "data" / "rigid_body_cases.json").read_text())["cases"]
NEAR_REST_DEG, NEAR_REST_SHARE = 3.0, 0.1
SECONDS, STEP_S = 1.0, 0.005
right_transformation = kin.transformation


def printed_transformation(p: kin.Array) -> kin.Array:
    """(2.5) as printed: plus signs in the entries (2, 3) and (3, 1)."""
    e0, e1, e2, e3 = p
    T = right_transformation(p)
    T[1, 2] = 2.0 * (e2 * e3 + e0 * e1)
    T[2, 0] = 2.0 * (e1 * e3 + e0 * e2)
    return T


@contextmanager
def printed_2_5() -> Iterator[None]:
    """The literal equations with (2.5) as printed."""
    with mock.patch.object(kin, "transformation", printed_transformation):
        yield


def near_rest(case: dict[str, Any]) -> dict[str, Any]:
    """The case with attitudes of some degrees and a tenth of its speeds, everything else as it is."""
    calm = copy.deepcopy(case)
    ship, state = calm["ship"], calm["state"]
    for where in (ship, state, *state["stations"]):
        for key in ("p_S", "p_H", "p_O"):
            if key in where:
                p = np.array(where[key])
                axis = p[1:] / np.linalg.norm(p[1:])
                where[key] = kin.euler_parameters(axis, np.deg2rad(NEAR_REST_DEG)).tolist()
        for key in ("w_S", "v_H", "w_H", "u"):
            if key in where:
                where[key] = (NEAR_REST_SHARE * np.array(where[key])).tolist()
    return calm


def change(case: dict[str, Any], *, of_2_5: bool) -> float:
    """Relative change of the accelerations of a case, in percent, by one of the two errors."""
    right = kane.accelerations(case)
    if of_2_5:
        with printed_2_5():
            wrong = kane.accelerations(case)
    else:
        wrong = kane.accelerations(case, printed_signs=True)
    return float(100.0 * np.linalg.norm(wrong - right) / np.linalg.norm(right))


def free(case: dict[str, Any]) -> dict[str, Any]:
    """The case without loads, its slides slow, on a ship that stands still."""
    loose = copy.deepcopy(case)
    loose["ship"] |= {"p_S": [1.0, 0.0, 0.0, 0.0], "w_S": [0.0] * 3, "wdot_S": [0.0] * 3, "a_S": [0.0] * 3}
    for wrench in (loose["loads"]["H"], *loose["loads"]["W"]):
        wrench["force"], wrench["moment"] = [0.0] * 3, [0.0] * 3
    for station in loose["state"]["stations"]:
        station["u"] = [0.1 * u for u in station["u"]]
    return loose


def at(case: dict[str, Any], y: kin.Array) -> dict[str, Any]:
    """The case at a state of 34 numbers, in the order of STATE.OUT."""
    stations = []
    for i, station in enumerate(case["state"]["stations"]):
        row = 19 + 5 * i
        place = [*station["r_W"][:2], y[row]]
        stations.append({"u": y[6 + 2 * i : 8 + 2 * i], "r_W": place, "p_O": y[row + 1 : row + 5]})
    state = {"v_H": y[0:3], "w_H": y[3:6], "r_H": y[12:15], "p_H": y[15:19], "stations": stations}
    return {**case, "state": state}


def rates(case: dict[str, Any], y: kin.Array, *, signs: bool) -> kin.Array:
    """Rates of the 34 numbers by the literal equations; `signs`: (2.68), (2.70), (2.72) as printed."""
    now = at(case, y)
    parts = [kane.accelerations(now, printed_signs=signs), y[0:3], kin.parameter_rates(y[15:19], y[3:6])]
    for s, p in zip(kin.Chain.of(now).stations, (y[20:24], y[25:29], y[30:34]), strict=True):
        parts += [s.v_W[2:], kin.parameter_rates(p, s.w_O)]
    return np.concatenate(parts)


def energy(case: dict[str, Any], y: kin.Array) -> float:
    """Kinetic energy by the right equations."""
    A, _ = kane.assemble(kane.bodies(at(case, y)))
    return float(-0.5 * y[:12] @ A[6:, 6:] @ y[:12])


def drift(case: dict[str, Any], *, of_2_5: bool, signs: bool) -> float:
    """Relative change of the energy of the unforced motion, in percent, over `SECONDS` by Runge-Kutta steps."""
    loose = free(case)
    y = np.array(loose["state_vector"])
    y[6:12] = np.concatenate([s["u"] for s in loose["state"]["stations"]])
    start = energy(loose, y)
    with printed_2_5() if of_2_5 else nullcontext():
        for _ in range(round(SECONDS / STEP_S)):
            a = rates(loose, y, signs=signs)
            b = rates(loose, y + 0.5 * STEP_S * a, signs=signs)
            c = rates(loose, y + 0.5 * STEP_S * b, signs=signs)
            d = rates(loose, y + STEP_S * c, signs=signs)
            y = y + STEP_S / 6.0 * (a + 2.0 * b + 2.0 * c + d)
    return float(100.0 * abs(energy(loose, y) / start - 1.0))


def main() -> None:
    print("percent; median and largest over the reference cases, of energy over the prismatic ones")
    prismatic = [c for c in CASES if c["kind"] == "prismatic"]
    for name, of_2_5, signs in (("(2.5)", True, False), ("(2.68), (2.70), (2.72)", False, True)):
        tables = {
            "accelerations": [change(c, of_2_5=of_2_5) for c in CASES],
            "accelerations near rest": [change(near_rest(c), of_2_5=of_2_5) for c in CASES],
            f"energy after {SECONDS:g} s": [drift(c, of_2_5=of_2_5, signs=signs) for c in prismatic],
        }
        for what, values in tables.items():
            print(f"{name:24s} {what:24s} {np.median(values):10.2g} {np.max(values):10.2g}")
    control = [drift(c, of_2_5=False, signs=False) for c in prismatic]
    print(f"{'as corrected':24s} {'energy after 1 s':24s} {np.median(control):10.2g} {np.max(control):10.2g}")


if __name__ == "__main__":
    main()
