"""How good the fixed step is: convergence order and peak errors against adaptive reference integration.

``python -m ssmash_gym.analysis.integrator_study`` prints the table that docs/theory/integrator.md quotes. Five
motions: a drop onto the deck, a rolling deck, a traverse on a rolling deck, a skid with the main wheels braked, and a
heaving deck.
Each is integrated by the fixed-step engine and by SciPy's DOP853 (cross-checked by LSODA) on the same right-hand
side; a step is judged by the peak loads it gives, never by the absence of a blow-up.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.dynamics.channels import STATION_OUT, STATION_OUT_ROWS, Out, StaOut
from ssmash_gym.dynamics.layout import ODE_ROWS, SPEEDS, STATION_ROWS, STATIONS, Par, Sta, State
from ssmash_gym.dynamics.reference import Method, Problem, Reference, integrate
from ssmash_gym.ship import Fixed, Sinusoid
from ssmash_gym.simulation.batch import Batch, Timing
from ssmash_gym.vehicle import load_helicopter

Array = NDArray[np.float64]
INTERVAL_S = 0.1


@dataclass(frozen=True)
class Case:
    """One motion: its duration, deck, how the helicopter starts, and the normalised claw command over time."""

    name: str
    seconds: float
    deck: Fixed | Sinusoid
    prepare: Callable[[Batch], None]
    command: Callable[[float], tuple[float, float]] = lambda _: (0.0, 0.0)


def _drop(batch: Batch) -> None:
    batch.parameters[Par.PROBE_ACTIVE] = 0.0
    _brake(batch, range(STATIONS))
    batch.state[State.Q10] = -2.7


def _secured(batch: Batch) -> None:
    batch.place(0.0, 0.0, 0.0)


def _crabbed(batch: Batch) -> None:
    batch.place(0.0, 0.05, np.deg2rad(4.0))


def _braked(batch: Batch) -> None:
    batch.place(0.0, 0.0, 0.0)
    _brake(batch, (1, 2))


def _brake(batch: Batch, stations: Sequence[int] | range) -> None:
    for i in stations:
        batch.parameters[Par.STATION + i * STATION_ROWS + Sta.ROLL_LOCK] = 1.0


CASES = (
    Case("drop", 2.0, Fixed(), _drop),
    Case("roll", 5.0, Sinusoid(dof="roll", amplitude_deg=5.0, period_s=8.0), _secured),
    Case(
        "traverse", 6.0, Sinusoid(dof="roll", amplitude_deg=4.0, period_s=10.0), _crabbed,
        # Speeds that the drive reaches at a whole number of substeps, so that the claw moves alike for every step.
        lambda t: (0.6 if t < 4.0 else 0.0, 0.15 if 0.5 < t < 1.5 else 0.0),
    ),
    Case(
        "skid", 4.0, Sinusoid(dof="pitch", amplitude_deg=2.0, period_s=6.0), _braked,
        lambda t: (0.3 if t < 3.0 else 0.0, 0.0),
    ),
    Case("heave", 5.0, Sinusoid(dof="heave", amplitude_m=0.5, period_s=5.0), _secured),
)  # fmt: skip


def prepared(case: Case, helicopter: str, step_s: float, beta: float | None = None) -> Batch:
    """A batch of one at the start of the case. `beta` replaces the decay constant of the oleo friction [s/m]."""
    batch = Batch(load_helicopter(helicopter), 1, timing=Timing(step_s, INTERVAL_S))
    if beta is not None:
        for i in range(STATIONS):
            batch.parameters[Par.STATION + i * STATION_ROWS + Sta.BETA] = beta
    case.prepare(batch)
    batch.state[:SPEEDS] = 0.0
    batch.set_motion([case.deck.bake(case.seconds + 1.0, batch.timing.node_spacing_s, ramp_s=1.0)])
    return batch


def commands(case: Case) -> Array:
    """Claw command of every control interval, (intervals, 2)."""
    return np.array([case.command(k * INTERVAL_S) for k in range(round(case.seconds / INTERVAL_S))])


def fixed_step(batch: Batch, case: Case) -> tuple[Array, dict[str, float]]:
    """Final integrated rows and the peaks over all substeps, by the engine."""
    highs = np.full(batch.telemetry.outputs.shape[0], -np.inf)
    lows = np.full_like(highs, np.inf)
    for command in commands(case):
        telemetry = batch.advance(command[None])
        highs, lows = np.maximum(highs, telemetry.highs[:, 0]), np.minimum(lows, telemetry.lows[:, 0])
    return batch.state[:ODE_ROWS, 0].copy(), peaks(highs, lows)


def problem(batch: Batch, case: Case) -> Problem:
    """The same start as a problem for the reference solvers."""
    timing = batch.timing
    return Problem(
        batch.state[:, 0].copy(), batch.parameters[:, 0].copy(), batch.mode, batch.nodes[0].copy(),
        np.zeros((2, 9)), commands(case), timing.substep_s, timing.substeps, timing.substeps_per_node,
    )  # fmt: skip


def peaks(highs: Array, lows: Array) -> dict[str, float]:
    """The quantities a step size is judged by: probe load [N], strokes [m], tire deflections [m]."""

    def station(row: StaOut, table: Array) -> Array:
        return table[[STATION_OUT + i * STATION_OUT_ROWS + int(row) for i in range(STATIONS)]]

    lateral = np.maximum(np.abs(station(StaOut.TIRE_LATERAL_DEFLECTION, highs)),
                         np.abs(station(StaOut.TIRE_LATERAL_DEFLECTION, lows)))  # fmt: skip
    return {
        "probe_N": float(highs[Out.PROBE_IN_PLANE]),
        "stroke_m": float(np.max(station(StaOut.COMPRESSION, highs))),
        "tire_vertical_m": float(np.max(station(StaOut.TIRE_VERTICAL_DEFLECTION, highs))),
        "tire_lateral_m": float(np.max(lateral)),
    }


def reference_peaks(reference: Reference) -> dict[str, float]:
    """The same from a reference history sampled at its substeps."""
    return peaks(np.max(reference.outputs, axis=1), np.min(reference.outputs, axis=1))


def peak_errors(got: dict[str, float], expected: dict[str, float]) -> dict[str, float]:
    """Relative errors; quantities that stay at zero in this case (no probe, no side force) are left out."""
    floor = {"probe_N": 50.0, "stroke_m": 1e-3, "tire_vertical_m": 1e-3, "tire_lateral_m": 1e-4}
    return {k: abs(got[k] - v) / v for k, v in expected.items() if v > floor[k]}


def reference_run(
    case: Case, helicopter: str, method: Method, beta: float | None = None, rtol: float = 1e-9
) -> Reference:
    """Reference history sampled every 2 ms."""
    return integrate(problem(prepared(case, helicopter, 0.002, beta), case), method, rtol=rtol, atol=1e-3 * rtol)


def observed_order(
    case: Case, helicopter: str, steps: Sequence[float], reference: Reference
) -> tuple[float, list[float]]:
    """Least-squares slope of log error against log step, and the errors (scaled norm of the final state)."""
    final = reference.states[:ODE_ROWS, -1]
    scale = 1e-3 + np.max(np.abs(reference.states[:ODE_ROWS]), axis=1)
    errors = []
    for step in steps:
        state, _ = fixed_step(prepared(case, helicopter, step), case)
        errors.append(float(np.linalg.norm((state - final) / scale)))
    return float(np.polyfit(np.log(steps), np.log(errors), 1)[0]), errors


def main() -> None:
    """Print the study."""
    from rich.console import Console
    from rich.table import Table

    table = Table("helicopter", "case", "beta", "order", "cross-check", "peak errors at 2 ms [%]")
    for helicopter in ("generic_tricycle", "seahawk_like"):
        for case in CASES:
            for beta in (None, 1000.0):
                reference = reference_run(case, helicopter, "DOP853", beta)
                other = reference_peaks(reference_run(case, helicopter, "LSODA", beta, 1e-8))
                expected = reference_peaks(reference)
                cross = max(peak_errors(other, expected).values())
                _, got = fixed_step(prepared(case, helicopter, 0.002, beta), case)
                order = (
                    "" if beta else f"{observed_order(case, helicopter, (0.001, 0.0005, 0.00025), reference)[0]:.2f}"
                )
                errors = ", ".join(f"{k} {100 * e:.3f}" for k, e in peak_errors(got, expected).items())
                table.add_row(helicopter, case.name, f"{beta or 100.0:g}", order, f"{cross:.1e}", errors)
    Console(width=160).print(table)


if __name__ == "__main__":
    main()
