"""The whole identification: rests, what follows from the trials in time, predictions, and other assumptions tried."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from ssmash_gym.analysis.verification.description import identified, identified_inputs
from ssmash_gym.analysis.verification.identification import Fit, Prediction, Problem
from ssmash_gym.analysis.verification.parameters import HEAD_WIND, ROLLING, Parameter, guesses
from ssmash_gym.analysis.verification.table import VerificationTable
from ssmash_gym.analysis.verification.trials import run_table
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.vehicle import Helicopter, with_changes

Array = NDArray[np.float64]
Tell = Callable[[str], None]
LEFT_OUT: Final[Mapping[str, Mapping[str, float]]] = {
    "2": {},
    "3": {"cg_shift_m": 0.5},  # its only evidence is left out with the trial: a round number takes its place
    "4": {},
    "13": {},
    "14": {},
    "15": {},
}
SHARE: Final = 1e-3  # of an unknown, for the derivatives of a trial in time
MISS: Final = 0.05  # of a tolerance by which such a trial may miss
_SPRINGS: Final = ("stations.right.spring", "stations.left.spring")


@dataclass(frozen=True)
class Variant:
    """Another assumption, tried."""

    label: str
    changes: Mapping[str, Any]


@dataclass(frozen=True)
class Identification:
    """What `ssmash identify` finds.

    Attributes:
        fit: The fit, and all values.
        helicopter: The helicopter that it makes, marks and all.
        inputs: Inputs of trials that the thesis does not print, with their marks.
        predictions: Of trials left out.
        variants: Fits under other assumptions, by their label.
    """

    fit: Fit
    helicopter: Helicopter
    inputs: dict[str, dict[str, Any]]
    predictions: tuple[Prediction, ...]
    variants: tuple[tuple[str, Fit], ...]


def variants(template: Helicopter) -> tuple[Variant, ...]:
    """Other assumptions about what the table does not determine."""
    nose, main = template.stations.auxiliary, template.stations.right

    def gamma(value: float, *springs: str) -> dict[str, Any]:
        return {f"{spring}.gas_exponent": value for spring in springs}

    def tires(factor: float) -> dict[str, Any]:
        return {
            f"stations.{name}.tires.*.{key}": factor * getattr(station.tires[0], key)
            for name, station in (("auxiliary", nose), ("right", main), ("left", main))
            for key in ("diameter_m", "width_m")
        }

    def spacing(half: float) -> dict[str, Any]:
        return {f"stations.*.tires.{k}.position_m": [0.0, side * half, 0.0] for k, side in ((0, 1.0), (1, -1.0))}

    return (
        Variant("nose gas exponent 1.1", gamma(1.1, "stations.auxiliary.spring")),
        Variant("nose gas exponent 1.4", gamma(1.4, "stations.auxiliary.spring")),
        Variant("main gas exponent 1.1", gamma(1.1, *_SPRINGS)),
        Variant("main gas exponent 1.4", gamma(1.4, *_SPRINGS)),
        Variant("main carriages of 100 kg", {"stations.right.mass_kg": 100.0, "stations.left.mass_kg": 100.0}),
        Variant("main carriages of 250 kg", {"stations.right.mass_kg": 250.0, "stations.left.mass_kg": 250.0}),
        Variant("main tires 50 mm lower at full droop", {
            f"stations.{side}.mount_m.2": main.mount_m[2] + 0.05 for side in ("right", "left")}),
        Variant("tires 10 % larger", tires(1.1)),
        Variant("tires 10 % smaller", tires(0.9)),
        Variant("twin tires 0.24 m apart instead of 0.30 m", spacing(0.12)),
    )  # fmt: skip


def refit(
    table: VerificationTable,
    template: Helicopter,
    start: Mapping[str, float] | None = None,
    *,
    leave_out: bool = True,
    vary: bool = False,
    tell: Tell | None = None,
) -> Identification:
    """Identify a helicopter.

    Args:
        table: The table.
        template: Helicopter that gives what is not identified.
        start: Where the search starts; round guesses by default.
        leave_out: Whether to predict the trials of `LEFT_OUT`, each from a fit without it.
        vary: Whether to try the other assumptions of `variants`.
        tell: Called with what is done next.

    Raises:
        ConfigurationError: A set of numbers on the way has no rest, or the trials in time cannot be met.
    """
    tell = tell or (lambda _: None)
    begin = {**guesses(), **(start or {})}
    problem = Problem(table, template)
    tell("fitting the rests")
    fit = problem.fit(begin, progress=lambda chi2: tell(f"fitting the rests: chi2 {chi2:.6g}"))
    tell("rolling resistance (case 5)")
    values = solve(table, template, fit.values, (ROLLING,), "5", ("x_m",))
    tell("wind of case 11")
    values = solve(table, template, values, HEAD_WIND, "11", ("pitch_deg", "x_m"))
    fit.values.update(values)
    predictions: list[Prediction] = []
    for trial, held in LEFT_OUT.items() if leave_out else ():
        tell(f"without case {trial}")
        predictions += problem.predictions(trial, problem.fit(fit.values, held, without=trial))
    tried = []
    for variant in variants(template) if vary else ():
        tell(variant.label)
        other = Problem(table, with_changes(template, variant.changes))
        tried.append((variant.label, other.fit(fit.values)))
    helicopter = identified(template, fit.values, fit.deviations)
    inputs = identified_inputs(fit.values, fit.deviations)
    return Identification(fit, helicopter, inputs, tuple(predictions), tuple(tried))


def solve(
    table: VerificationTable,
    template: Helicopter,
    values: Mapping[str, float],
    unknown: tuple[Parameter, ...],
    trial: str,
    quantities: tuple[str, ...],
) -> dict[str, float]:
    """Values with which a trial in time gives as many printed values as there are unknowns.

    Raises:
        ConfigurationError: There are none.
    """
    rows = {row.quantity: row for row in table.trials[trial].file.rows}
    scale = np.array([p.scale for p in unknown])
    bare = template.model_copy(update={"provenance": ()})

    def with_unknowns(x: Array) -> dict[str, float]:
        return {**values, **{p.name: float(v) for p, v in zip(unknown, x * scale, strict=True)}}

    def misses(x: Array) -> Array:
        there = with_unknowns(x)
        helicopter = identified(bare, there, None)
        found = run_table(table.with_inputs(identified_inputs(there, None)), helicopter, [trial])
        return np.array([found.of(trial, name).difference / rows[name].tolerance for name in quantities])

    low, high = (np.array([getattr(p, end) for p in unknown]) / scale for end in ("low", "high"))
    begin = np.clip(np.array([values[p.name] for p in unknown]) / scale, low, high)
    solved = least_squares(misses, begin, bounds=(low, high), diff_step=[SHARE] * len(unknown), xtol=1e-7, ftol=1e-7)
    if (np.abs(solved.fun) > MISS).any():
        names = " and ".join(p.name for p in unknown)
        raise ConfigurationError(f"case {trial}: no {names} within the bounds gives the printed values.")
    return with_unknowns(solved.x)
