"""The fixed step against adaptive reference integration: its order, and the peaks it gives at the default step.

A small version of `ssmash_gym.analysis.integrator_study`, on the first second or two of its cases. A step is judged
by peak loads, never by the absence of a blow-up. DOP853 is explicit and slow where the joint friction is stiff, LSODA
switches to an implicit method there; the two check each other.
"""

from __future__ import annotations

from dataclasses import replace

import pytest

from ssmash_gym.analysis.integrator_study import (
    CASES,
    Case,
    fixed_step,
    observed_order,
    peak_errors,
    prepared,
    reference_peaks,
    reference_run,
)

STEP_S = 0.002  # the default
PEAKS = {
    "drop": {"stroke_m", "tire_vertical_m"},
    "roll": {"probe_N", "stroke_m", "tire_vertical_m", "tire_lateral_m"},
    "traverse": {"probe_N", "stroke_m", "tire_vertical_m", "tire_lateral_m"},
    "skid": {"probe_N", "stroke_m", "tire_vertical_m"},
}
SECONDS = {"drop": 0.8, "roll": 1.6, "traverse": 1.5, "skid": 1.2, "heave": 1.5}


def case(name: str) -> Case:
    """The study's case, cut short."""
    (found,) = (c for c in CASES if c.name == name)
    return replace(found, seconds=SECONDS[name])


@pytest.mark.parametrize("name", ["roll", "traverse", "heave"])
def test_order_on_smooth_motions(name: str) -> None:
    """Against DOP853 at rtol 1e-10: every halving of the step divides the error by about four."""
    steps = (0.002, 0.001, 0.0005, 0.00025)
    reference = reference_run(case(name), "generic_tricycle", "DOP853", rtol=1e-10)
    order, errors = observed_order(case(name), "generic_tricycle", steps, reference)
    assert 1.8 < order < 2.3
    assert errors[0] < 2e-3 and errors == sorted(errors, reverse=True)


@pytest.mark.parametrize(
    ("helicopter", "name"),
    [("generic_tricycle", name) for name in PEAKS] + [("seahawk_like", "drop"), ("seahawk_like", "traverse")],
)
def test_peaks_at_the_default_step(helicopter: str, name: str) -> None:
    """Within 0.5 % of a reference that two solvers agree on within 0.05 %."""
    expected = reference_peaks(reference_run(case(name), helicopter, "DOP853", rtol=1e-8))
    check = reference_peaks(reference_run(case(name), helicopter, "LSODA", rtol=1e-7))
    cross, errors = peak_errors(check, expected), peak_errors(peaks(helicopter, name, None), expected)
    assert set(errors) == set(cross) == PEAKS[name]
    assert max(cross.values()) < 5e-4
    assert max(errors.values()) < 5e-3


@pytest.mark.parametrize("name", list(PEAKS))
def test_peaks_with_very_stiff_friction(name: str) -> None:
    """beta = 1000 s/m: joint rates to -32 000 1/s, sixty times what an explicit step of 2 ms bears."""
    expected = reference_peaks(reference_run(case(name), "generic_tricycle", "LSODA", beta=1000.0, rtol=1e-7))
    errors = peak_errors(peaks("generic_tricycle", name, 1000.0), expected)
    assert set(errors) == PEAKS[name]
    assert max(errors.values()) < 5e-3


def peaks(helicopter: str, name: str, beta: float | None) -> dict[str, float]:
    """By the engine, at the default step."""
    return fixed_step(prepared(case(name), helicopter, STEP_S, beta), case(name))[1]
