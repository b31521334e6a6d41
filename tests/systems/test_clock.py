"""Cases that start later than zero, and claws that start off the probe: what every system makes of them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from ssmash_gym.cases import Case, case_from, prepared, run_case
from ssmash_gym.dynamics.layout import State
from ssmash_gym.systems import apply, at_full_scale, load_system, scaled_case
from ssmash_gym.systems.additive import BOTH, CLAW, DECK, parts_of
from ssmash_gym.systems.overlay import stilled

Array = NDArray[np.float64]
START_S = 2.0
PATH = {"type": "points", "time_s": [1.0, 2.0, 3.0, 4.0], "x_m": [0.1, 0.2, 0.4, 0.5], "y_m": [0.0, -0.1, -0.1, 0.0]}
ROLL = {"type": "sinusoid", "dof": "roll", "amplitude_deg": 4.0, "period_s": 7.0, "phase_deg": 20.0}
RECORD = "".join(f"{t:g} {0.02 * t * t:g} {0.1 * np.sin(t):g} -0.05\n" for t in np.arange(0.0, 6.0, 0.25))


def late(**changes: Any) -> Case:
    """Deck and claw move; the run begins at two seconds of their clock."""
    solution = {"start_s": START_S, "end_s": 2.4, "output_step_s": 0.02, **changes.pop("solution", {})}
    document = {"name": "late", "helicopter": "seahawk_like", "deck": ROLL, "claw": PATH, "solution": solution}
    return case_from({**document, **changes})


def recorded(folder: Path) -> dict[str, str]:
    file = folder / "claw.inp"
    file.write_text(RECORD, encoding="utf-8")
    return {"type": "file", "path": str(file)}


def claw_at_start(case: Case) -> Array:
    """Place of the claw at the start of the run, S axes, and the height of its plane [m]."""
    batch = prepared(case)
    x, y = (batch.telemetry[f"claw_{axis}"][0] for axis in "xy")
    return np.array([x, y, batch.claw.height_m])


# --- a claw that is held still ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({}, (0.2, -0.1)),
        ({"start": {"type": "settled", "x_m": 3.0, "y_m": 0.5}}, (3.2, 0.4)),
        ({"start": {"type": "drop", "cg_height_m": 2.6, "x_m": 3.0}}, None),
        ({"claw": {**PATH, "relative_to": "ship"}}, (0.2, -0.1)),
        ({"claw": {**PATH, "noise": {"rms_m": 0.01}}}, (0.2, -0.1)),
        ({"solution": {"start_s": 0.0}}, (0.1, 0.0)),
        ({"solution": {"start_s": 5.0, "end_s": 5.4}}, (0.5, 0.0)),
    ],
)
def test_a_claw_held_still_stays_where_it_is_when_the_run_starts(
    changes: dict[str, Any], expected: tuple[float, float] | None
) -> None:
    case = late(**changes)
    still = case.changed({"claw": stilled(case)})
    found = claw_at_start(still)
    np.testing.assert_allclose(found, claw_at_start(case), rtol=0.0, atol=1e-9)
    if expected is not None:
        np.testing.assert_allclose(found[:2], expected, rtol=0.0, atol=1e-9)
    assert still.claw.type == "still"


def test_a_claw_of_a_file_held_still_stays_where_it_is_when_the_run_starts(tmp_path: Path) -> None:
    case = late(claw=recorded(tmp_path))
    np.testing.assert_allclose(claw_at_start(case.changed({"claw": stilled(case)})), claw_at_start(case), atol=1e-9)
    np.testing.assert_allclose(claw_at_start(case), [0.08, 0.1 * np.sin(2.0), 0.05], atol=1e-5)


def test_a_claw_that_starts_at_the_probe_stays_at_the_probe_of_the_system() -> None:
    claw = stilled(late(claw={**PATH, "time_s": [2.0, 3.0, 4.0, 5.0], "x_m": [0, 1, 1, 1], "y_m": [0, 0, 0, 0]}))
    assert claw == {"type": "still", "z_m": 0.0}


# --- the clock of deck and claw --------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["ssmash", "heliman_like", "feldman_scale"])
def test_deck_and_claw_start_where_the_clock_says(name: str) -> None:
    """What they do from two seconds on is what they do in a run from zero after two seconds; scaled or not."""
    system, case = load_system(name), late()
    history = run_case(apply(system, case))
    if system.scale != 1.0:
        history = at_full_scale(history, case, system.scale)
    assert history.time_s[0] == pytest.approx(START_S) and history.time_s[-1] == pytest.approx(2.4)
    roll = np.radians(4.0) * np.sin(2.0 * np.pi * history.time_s / 7.0 + np.radians(20.0))
    np.testing.assert_allclose(history["deck_roll"], 0.0 if name == "heliman_like" else roll, atol=1e-6)
    assert history["claw_x"][0] == pytest.approx(0.2, abs=1e-9)
    later = run_case(late(deck={"type": "fixed"}, solution={"start_s": 0.0}))
    np.testing.assert_allclose(history["claw_x"], later["claw_x"][100:], atol=1e-6)


def test_the_loads_of_the_parts_count_from_the_end_of_the_ramp_on_that_clock() -> None:
    case = late(ramp_s=0.2)
    parts = parts_of(case)
    assert parts.from_s == pytest.approx(START_S + 0.2)
    for name in (BOTH, DECK, CLAW):
        history = parts.histories[name]
        rows = history.time_s > 2.2 - 1e-6
        assert 0 < np.count_nonzero(rows) < rows.size
        assert parts.peak_kN[name] == pytest.approx(1e-3 * np.max(history.peak_max("probe_in_plane")[rows]))
    assert np.ptp(parts.histories[DECK]["claw_x"]) == 0.0
    assert parts.histories[DECK]["claw_x"][0] == pytest.approx(parts.histories[BOTH]["claw_x"][0], abs=1e-9)


# --- nodes -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("given", "node_s"), [({}, 0.02), ({"longest_node_s": 0.05}, 0.05)])
@pytest.mark.parametrize("scale", [0.1, 0.25])
def test_the_nodes_of_a_model_lie_at_the_corresponding_times(
    given: dict[str, float], node_s: float, scale: float
) -> None:
    case = late(solution=given, claw={**PATH, "noise": {"rms_m": 0.002, "high_hz": 1.5, "rise_s": 0.5}})
    full, model = prepared(case), prepared(scaled_case(case, scale))
    assert full.timing.node_spacing_s == pytest.approx(node_s)
    assert model.timing.node_spacing_s == pytest.approx(node_s * np.sqrt(scale))
    powers = np.repeat([1.0, 0.5, 0.0], 3)
    np.testing.assert_allclose(model.claw_nodes[0] * scale**-powers, full.claw_nodes[0], atol=1e-9)
    np.testing.assert_allclose(model.nodes[0][:, 3:6], full.nodes[0][:, 3:6], atol=1e-12)


def test_a_model_larger_than_its_original_has_no_coarser_nodes_than_there_are() -> None:
    case = late(claw={"type": "still"})
    assert scaled_case(case, 4.0).solution.longest_node_s == 0.25


def test_an_irregular_deck_of_short_period_can_be_scaled() -> None:
    case = late(deck={"type": "irregular", "roll": {"rms_deg": 2.0, "period_s": 9.0}}, claw={"type": "still"})
    full, model = prepared(case), prepared(scaled_case(case, 0.1))
    np.testing.assert_allclose(model.nodes[0][:, 3], full.nodes[0][:, 3], atol=1e-9)


@pytest.mark.parametrize(
    "solution", [{}, {"start_s": 0.0, "end_s": 0.4}, {"start_s": 5.4, "end_s": 6.4}], ids=["within", "first", "beyond"]
)
def test_a_claw_file_scales_whether_the_run_lies_within_it_or_not(tmp_path: Path, solution: dict[str, float]) -> None:
    """The points of the model give the spline of the file: places within a micrometre, rates within 0.1 mm/s."""
    case = late(claw=recorded(tmp_path), solution=solution)
    full, model = (prepared(c).claw_nodes[0] for c in (case, scaled_case(case, 0.25)))
    times = case.solution.start_s + 0.02 * np.arange(full.shape[0])
    ran = times < case.solution.end_s + 1e-9
    np.testing.assert_allclose(model[ran, :3] / 0.25, full[ran, :3], atol=1e-6)
    np.testing.assert_allclose(model[ran, 3:6] / 0.5, full[ran, 3:6], atol=1e-4)
    assert np.any(np.abs(full[0, 3:5]) > 0.01)
    assert prepared(case).state[State.CLAW_X, 0] == pytest.approx(0.0)
