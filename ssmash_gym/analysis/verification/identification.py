"""Least squares: the helicopter's numbers from the rests of the verification table, and what they are worth.

The trials are run with the project's own model: every set of numbers is a validated description, and what is fitted is
what a file would say. What a fit without one trial says about that trial is a prediction.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, cast

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from ssmash_gym.analysis.verification.parameters import FREE, Parameter, helicopter_changes, trial_inputs
from ssmash_gym.analysis.verification.table import REFERENCE, PrintedRow, VerificationTable
from ssmash_gym.analysis.verification.trials import read_values, rests
from ssmash_gym.vehicle import Helicopter, document_of, with_changes

Array = NDArray[np.float64]
Values = Mapping[str, float]
STEP: Final = 1.0e-4  # of a parameter's scale, for the derivatives
TOLERANCE: Final = 1.0e-7
SEARCHES = 100  # greatest number of evaluations


@dataclass(frozen=True)
class Fit:
    """A least-squares fit to some of the table's rests.

    Attributes:
        values: All numbers by name, the held ones included.
        parameters: The free ones.
        deviations: Standard deviations of the free ones for the stated ones of the rows, by name.
        correlation: Between the free ones, in their order.
        rows: Trial and row of each residual.
        residuals: Simulated minus printed, over the standard deviation.
        evaluations: Of the residuals by the search.
        at_bounds: Free numbers that ended on a bound.
    """

    values: dict[str, float]
    parameters: tuple[Parameter, ...]
    deviations: dict[str, float]
    correlation: Array
    rows: tuple[tuple[str, PrintedRow], ...]
    residuals: Array
    evaluations: int
    at_bounds: tuple[str, ...]

    @property
    def chi2(self) -> float:
        """Sum of the squared residuals."""
        return float(self.residuals @ self.residuals)


@dataclass(frozen=True)
class Prediction:
    """One printed value beside what a fit without its trial says.

    Attributes:
        trial: The trial.
        row: The printed value.
        predicted: What the fit says.
        deviation: Its standard deviation.
        chi2: Of the fit.
    """

    trial: str
    row: PrintedRow
    predicted: float
    deviation: float
    chi2: float

    @property
    def error(self) -> float:
        """Predicted minus printed (corrected, where it is misprinted)."""
        return self.predicted - (self.row.printed if self.row.aim is None else self.row.aim)


class Problem:
    """The rests of the table as a function of the identified numbers.

    Args:
        table: The table.
        template: Helicopter that gives what is not identified.
    """

    def __init__(self, table: VerificationTable, template: Helicopter) -> None:
        self.table = table
        self.template = template.model_copy(update={"provenance": ()})  # marks cost time and change nothing
        self.rows = tuple(
            (key, row) for key, trial in table.trials.items() for row in trial.file.rows if row.sigma is not None
        )
        document = document_of(self.template)
        self.cases = {key: table.trials[key].case(self.template, document) for key in dict(self.rows)}

    def simulated(self, many: Sequence[Values], trials: Sequence[str] | None = None) -> dict[tuple[str, str], Array]:
        """Every quantity of the rests' rows for each set of values, by trial and quantity."""
        wanted = {key for key, _ in self.rows} if trials is None else set(trials)
        keys = [key for key in self.cases if key in wanted | {REFERENCE}]
        fleets: list[list[Helicopter]] = [[] for _ in keys]
        for values in many:
            helicopter = with_changes(self.template, helicopter_changes(self.template, values))
            inputs = trial_inputs(values)
            for fleet, key in zip(fleets, keys, strict=True):
                changes = {**self.table.trials[key].changes(helicopter), **inputs.get(key, {})}
                fleet.append(with_changes(helicopter, changes))
        histories = dict(zip(keys, rests([self.cases[key] for key in keys], fleets), strict=True))
        found: dict[tuple[str, str], Array] = {}
        for key, history in histories.items():
            names = [row.quantity for row in self.table.trials[key].file.rows]
            read = read_values(history, names, histories[REFERENCE])
            found |= {(key, name): values for name, values in read.items()}
        return found

    def residuals(self, many: Sequence[Values], rows: Sequence[tuple[str, PrintedRow]]) -> Array:
        """Residuals of the rows for each set of values, (sets, rows)."""
        found = self.simulated(many, [key for key, _ in rows])
        return np.stack(
            [(found[key, row.quantity] - row.printed) / row.sigma for key, row in rows if row.sigma], axis=1
        )

    def fit(
        self,
        start: Values,
        held: Mapping[str, float] | None = None,
        without: str | None = None,
        progress: Callable[[float], None] | None = None,
    ) -> Fit:
        """Search the free numbers.

        Args:
            start: All numbers at the start.
            held: Free numbers that are held, at these values.
            without: A trial that is left out.
            progress: Called with the sum of squares after every evaluation.
        """
        held = dict(held or {})
        free = tuple(p for p in FREE if p.name not in held)
        rows = tuple((key, row) for key, row in self.rows if key != without)
        scale = np.array([p.scale for p in free])
        low, high = (np.array([getattr(p, end) for p in free]) / scale for end in ("low", "high"))
        base = {**start, **held}

        def values(x: Array) -> dict[str, float]:
            return {**base, **{p.name: float(v) for p, v in zip(free, x * scale, strict=True)}}

        def residuals(x: Array) -> Array:
            found = np.asarray(self.residuals([values(x)], rows)[0])
            if progress is not None:
                progress(float(found @ found))
            return found

        def jacobian(x: Array) -> Array:
            steps = np.where(x + STEP > high, -STEP, STEP)
            many = [values(x), *(values(x + step * unit) for step, unit in zip(steps, np.eye(x.size), strict=True))]
            found = self.residuals(many, rows)
            return np.asarray((found[1:] - found[0]).T / steps)

        begin = np.clip(np.array([base[p.name] for p in free]) / scale, low, high)
        solved = least_squares(
            residuals, begin, jacobian, bounds=(low, high), method="trf", x_scale="jac", ftol=TOLERANCE, xtol=TOLERANCE,
            gtol=TOLERANCE, max_nfev=SEARCHES,
        )  # fmt: skip
        slopes = cast(Array, solved.jac)
        covariance = np.linalg.inv(slopes.T @ slopes)
        sd = np.sqrt(np.diag(covariance))
        return Fit(
            values(solved.x), free, {p.name: float(s) for p, s in zip(free, sd * scale, strict=True)},
            covariance / np.outer(sd, sd), rows, np.asarray(solved.fun), int(solved.nfev),
            tuple(p.name for p, on in zip(free, solved.active_mask, strict=True) if on),
        )  # fmt: skip

    def predictions(self, trial: str, fit: Fit) -> tuple[Prediction, ...]:
        """What a fit says about the rows of a trial that it did not see; sums are known without it."""
        sets = [fit.values]
        for p in fit.parameters:
            sets.append({**fit.values, p.name: fit.values[p.name] + STEP * p.scale})
        found = self.simulated(sets, [trial])
        sd = np.array([fit.deviations[p.name] for p in fit.parameters])
        covariance = fit.correlation * np.outer(sd, sd)
        steps = STEP * np.array([p.scale for p in fit.parameters])
        made = []
        for row in self.table.trials[trial].file.rows:
            values = found[trial, row.quantity]
            slope = (values[1:] - values[0]) / steps
            if row.aim is not None and row.quantity != "sum_load_kN":
                deviation = float(np.sqrt(slope @ covariance @ slope))
                made.append(Prediction(trial, row, float(values[0]), deviation, fit.chi2))
        return tuple(made)
