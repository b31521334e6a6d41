"""A case is described, refused, changed and run; every solver sees the same physics."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ssmash_gym.cases import Case, case_document, case_from, load_case, quantity, run_case
from ssmash_gym.cases.claw import ClawPoints, Noise, claw_nodes, read_claw_file
from ssmash_gym.document import read_yaml, write_yaml
from ssmash_gym.dynamics.layout import State
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.simulation.recording import read_recording

STANDING = {"stations.*.rolling": "locked", "stations.*.steering": "locked"}
SHORT = {"end_s": 0.5, "output_step_s": 0.1}


def made(**sections: Any) -> Case:
    return case_from({"name": "test", "helicopter": "generic_tricycle", "solution": SHORT, **sections})


DROP: dict[str, Any] = {
    "changes": {**STANDING, "probe.active": False},
    "start": {"type": "drop", "cg_height_m": 2.7},
    "solution": {"end_s": 1.0, "output_step_s": 0.1},
}


def test_a_drop_falls_freely_until_it_touches() -> None:
    history = run_case(made(**DROP))
    in_the_air = history["auxiliary_vertical_load"] == 0.0
    t = history.time_s[in_the_air]
    assert t.size >= 2
    np.testing.assert_allclose(quantity("z_m").of(history)[in_the_air], -2.7 + 0.5 * 9.81 * t**2, atol=2e-4)
    assert history["right_vertical_load"][-1] > 0.0 and history.diverged is None


@pytest.mark.parametrize("solver", ["adams", "gear", "automatic", "dop853"])
def test_solvers_of_other_families_agree_with_the_engine(solver: str) -> None:
    case = made(**DROP)
    engine = run_case(case)
    other = run_case(case.changed({"solution.solver": solver}))
    assert other.evaluations > 0
    assert other.largest("right_vertical_load") == pytest.approx(engine.largest("right_vertical_load"), rel=5e-3)
    assert other["pitch"][-1] == pytest.approx(engine["pitch"][-1], abs=1e-4)
    np.testing.assert_allclose(other.time_s, engine.time_s)


def test_extremes_hold_what_lies_between_the_rows() -> None:
    fine = run_case(made(**DROP).changed({"solution.output_step_s": 0.002}))
    coarse = run_case(made(**DROP).changed({"solution.output_step_s": 0.25}))
    every = fine["right_vertical_load"]
    for k in range(1, coarse.time_s.size):
        part = every[125 * (k - 1) : 125 * k + 1]
        assert coarse.peak_max("right_vertical_load")[k] == part.max()
        assert coarse.peak_min("right_vertical_load")[k] == part.min()


def test_same_case_same_bits() -> None:
    case = made(deck={"type": "irregular", "roll": {"rms_deg": 2.0, "period_s": 9.0}}, seed=3)
    first, second = run_case(case), run_case(case_from(case_document(case)))
    assert np.array_equal(first.states, second.states)
    other = run_case(case.changed({"seed": 4}))
    assert not np.array_equal(first.states, other.states)


def test_held_speeds_stay_zero() -> None:
    deck = {"type": "sinusoid", "dof": "roll", "amplitude_deg": 4.0, "period_s": 4.0}
    held = ["u10", "u7", "u13", "u18"]
    history = run_case(made(deck=deck, held=held))
    for name in held:
        assert not np.any(history.states[State[name.upper()]])
    assert np.any(history.states[State.U15] != 0.0)


def test_rest_on_a_tilted_deck_takes_no_time() -> None:
    solution = {"end_s": 0.0, "equilibrium": True}
    history = run_case(made(changes=STANDING, deck={"type": "fixed", "roll_deg": 5.0}, solution=solution))
    assert history.time_s.shape == (1,)
    weight = 9.81e-3 * history.case.vehicle.total_mass_kg
    assert quantity("sum_load_kN").of(history)[0] < weight
    both = 5.0 + quantity("roll_deg").of(history)[0]  # rolls add but for the small pitch between them
    assert quantity("roll_N_deg").of(history)[0] == pytest.approx(both, abs=1e-3)
    assert both > 6.0


def test_start_in_given_numbers_is_the_start_it_was_taken_from() -> None:
    first = run_case(made(changes=STANDING, start={"type": "settled", "yaw_deg": 4.0}))
    y = first.states[:, 0]
    start = {
        "type": "state",
        "position_m": y[State.Q8 : State.Q10 + 1].tolist(),
        "orientation": y[State.Q11 : State.Q14 + 1].tolist(),
        "strut_m": [y[State.Q15], y[State.Q20], y[State.Q25]],
        "strut_orientations": [y[row : row + 4].tolist() for row in (State.Q16, State.Q21, State.Q26)],
    }
    again = run_case(made(changes=STANDING, start=start))
    np.testing.assert_allclose(again.states[:52, 0], first.states[:52, 0], atol=1e-12)
    assert again["probe_in_plane"][0] == pytest.approx(0.0, abs=1e-3)


def test_the_claw_goes_through_its_points_and_stands_at_both_ends() -> None:
    claw = {"type": "points", "time_s": [0.1, 0.3, 0.4], "x_m": [0.0, 0.02, 0.01], "y_m": [0.0, 0.0, 0.01]}
    history = run_case(made(start={"type": "settled", "x_m": 1.0}, claw=claw))
    np.testing.assert_allclose(history["claw_x"][[0, 1, 5]], [1.0, 1.0, 1.01], atol=1e-3)
    assert history["claw_vx"][5] == pytest.approx(0.0, abs=1e-6)
    assert history["claw_y"][5] == pytest.approx(0.01, abs=1e-3)


def test_claw_noise_has_its_size_and_its_own_derivatives() -> None:
    claw = ClawPoints(time_s=(0.0, 400.0), x_m=(0.0, 0.0), y_m=(0.0, 0.0), noise=Noise(rms_m=0.002))
    nodes = claw_nodes(claw, np.zeros(2), 0.0, 400.0, 0.02, seed=1)
    assert np.std(nodes[50:, 0]) == pytest.approx(0.002, rel=0.1)
    slope = np.gradient(nodes[:, 0], 0.02)
    np.testing.assert_allclose(nodes[1:-1, 3], slope[1:-1], atol=0.01 * np.std(slope) + 1e-6)
    assert nodes[0, 0] == 0.0
    assert not np.array_equal(nodes, claw_nodes(claw, np.zeros(2), 0.0, 400.0, 0.02, seed=2))


def test_a_turned_probe_turns_what_is_measured_and_nothing_else() -> None:
    claw = {"type": "points", "time_s": [0.0, 0.4], "x_m": [0.0, 0.02], "y_m": [0.0, 0.0]}
    plain = run_case(made(changes=STANDING, claw=claw))
    turned = run_case(made(changes=STANDING, claw=claw, probe_turn={"angle_deg": 90.0}))
    assert np.array_equal(plain.states, turned.states)
    np.testing.assert_allclose(quantity("probe_y_kN").of(turned), -quantity("probe_x_kN").of(plain), atol=1e-12)


def test_files_and_documents_come_back_as_they_were(tmp_path: Path) -> None:
    case = made(
        start={"type": "settled", "yaw_deg": {"value": 9.0, "origin": "derived", "note": "section 3.2.2"}},
        changes={"mass_kg": {"value": 9000.0, "origin": "assumed"}},
    )
    file = tmp_path / "case.yaml"
    file.write_text(write_yaml(case_document(case)), encoding="utf-8")
    assert load_case(file) == case
    assert read_yaml(file.read_text(encoding="utf-8"), "file")["start"]["yaw_deg"]["origin"] == "derived"
    assert case.vehicle.marks["mass_kg"].origin == "assumed"


def test_a_recording_says_what_made_it(tmp_path: Path) -> None:
    history = run_case(made())
    history.write(tmp_path / "case.parquet")
    table, about = read_recording(tmp_path / "case.parquet")
    assert case_from(about["configuration"]["case"]) == history.case
    np.testing.assert_array_equal(table["pitch"].to_numpy(), history["pitch"])


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"solution.end_s": -1.0}, "end_s"),
        ({"solution.output_step_s": 0.003}, "output_step_s"),
        ({"solution.solver": "euler"}, "solver"),
        ({"start.type": "jump"}, "jump"),
        ({"held": ["u3"]}, "u3"),
        ({"changes": {"wheels": 4}}, "wheels"),
        ({"colour": "grey"}, "colour"),
        ({"start.tilt_deg": 1.0}, "tilt_deg"),
        ({"claw": {"type": "points", "time_s": [0, 1], "x_m": [0], "y_m": [0, 0]}}, "x_m"),
        ({"claw": {"type": "points", "time_s": [1, 0], "x_m": [0, 0], "y_m": [0, 0]}}, "time_s"),
        ({"helicopter": "autogyro"}, "autogyro"),
        ({"patch": {"x_m": [2, 1], "y_m": [0, 1], "friction_factor": 0.5}}, "x_m"),
        ({"start.x_m": float("nan")}, "x_m"),
        ({"helicopter": {"value": "generic_tricycle", "origin": "assumed"}}, "helicopter"),
        ({"provenance": 3}, "provenance"),
        ({"changes": None}, "changes"),
        ({"solution.end_s": 1e308}, "end_s"),
        ({"solution.substep_s": 1e-320}, "substep_s"),
        ({"held": ["u9", "u9"]}, "held"),
        ({"claw": {"type": "points", "time_s": [0, 1], "x_m": [0, 1e308], "y_m": [0, 0]}}, "x_m"),
    ],
)
def test_mistakes_cost_one_sentence(changes: dict[str, Any], said: str) -> None:
    with pytest.raises(ConfigurationError, match=said) as caught:
        made().changed(changes)
    assert "\n" not in str(caught.value)


def test_a_record_shorter_than_the_run_is_refused(tmp_path: Path) -> None:
    rows = np.zeros((20, 16))
    rows[:, 0] = 0.1 * np.arange(20)
    np.savetxt(tmp_path / "deck.txt", rows)
    case = made(deck={"type": "file", "path": str(tmp_path / "deck.txt")}, solution={"end_s": 5.0})
    with pytest.raises(ConfigurationError, match=r"end_s = 5 is refused"):
        run_case(case)
    assert run_case(case.changed({"solution": SHORT})).time_s[-1] == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("0 0 0 0\n1 0 0\n", "line 2: 3 columns"),
        ("0 0 0 0\n1 0 x 0\n", "line 2, column 3"),
        ("0 0 0 0\n0 0 0 0\n", "line 2, column 1"),
        ("# nothing\n", "0 rows"),
        ("0 0 0 0\n1 nan 0 0\n", "line 2, column 2"),
    ],
)
def test_claw_files_are_refused_by_line_and_column(tmp_path: Path, text: str, said: str) -> None:
    file = tmp_path / "rsd_pos.inp"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(ConfigurationError, match=said):
        read_claw_file(file)


CLAMPED = {"type": "points", "time_s": [0.1, 1.0], "x_m": [0.0, 0.25], "y_m": [0.0, 0.0]}


@pytest.mark.parametrize("interpolation", ["monotone", "spline"])
def test_the_claw_neither_moves_before_its_points_nor_overshoots_them(interpolation: str) -> None:
    solution = {"end_s": 1.4, "output_step_s": 0.01}
    history = run_case(made(claw={**CLAMPED, "interpolation": interpolation}, changes=STANDING, solution=solution))
    assert history.peak_min("claw_x").min() > -1e-5 and history.peak_max("claw_x").max() < 0.25 + 1e-5
    assert history["probe_in_plane"][history.time_s < 0.09].max() < 50.0
    assert history["claw_vx"][-1] == pytest.approx(0.0, abs=1e-9)


def test_deck_and_claw_keep_their_clock_when_a_run_starts_late() -> None:
    late = {"start_s": 0.4, "end_s": 0.8, "output_step_s": 0.1}
    deck = {"type": "sinusoid", "dof": "roll", "amplitude_deg": 4.0, "period_s": 3.0}
    history = run_case(made(deck=deck, claw={**CLAMPED, "relative_to": "ship"}, changes=STANDING, solution=late))
    np.testing.assert_allclose(history.time_s, [0.4, 0.5, 0.6, 0.7, 0.8])
    np.testing.assert_allclose(
        np.rad2deg(history["deck_roll"]), 4.0 * np.sin(2.0 * np.pi * history.time_s / 3.0), atol=1e-5
    )
    whole = run_case(made(claw=CLAMPED, changes=STANDING, solution={"end_s": 0.8, "output_step_s": 0.1}))
    np.testing.assert_allclose(history["claw_x"], whole["claw_x"][4:], atol=1e-6)


def test_every_key_of_a_start_has_its_effect() -> None:
    state = run_case(made(start={"type": "drop", "cg_height_m": 3.0, "sink_mps": 1.5, "roll_deg": 2.0})).states[:, 0]
    assert state[State.U9] == 1.5  # down
    history = run_case(made(start={"type": "settled", "steer_deg": 10.0}))
    assert np.rad2deg(history["auxiliary_steer"][0]) == pytest.approx(
        10.0, abs=0.1
    )  # the free wheel finds its own rest nearby
    rake = [float(np.cos(0.05)), 0.0, float(np.sin(0.05)), 0.0]
    raked = {"changes": {"stations.auxiliary.orientation": rake}}
    plain = run_case(made(**raked, start={"type": "settled"}))
    steered = run_case(made(**raked, start={"type": "settled", "steer_deg": 1e-6}))
    assert steered["auxiliary_vertical_load"][0] == pytest.approx(plain["auxiliary_vertical_load"][0], rel=1e-6)


def test_ramp_patch_and_claw_height_reach_the_batch() -> None:
    deck = {"type": "sinusoid", "dof": "roll", "amplitude_deg": 4.0, "period_s": 3.0}
    slow, sudden = (run_case(made(deck=deck, ramp_s=ramp, changes=STANDING)) for ramp in (5.0, 0.0))
    assert abs(slow["deck_roll"][-1]) < 0.1 * abs(sudden["deck_roll"][-1])
    patch = {"x_m": [-9.0, 9.0], "y_m": [-9.0, 9.0], "friction_factor": 0.1}
    claw = {"type": "points", "time_s": [0.0, 0.4], "x_m": [0.0, 0.1], "y_m": [0.0, 0.0]}
    firm, slippery = (run_case(made(claw=claw, changes=STANDING, patch=p)) for p in (None, patch))
    assert slippery.largest("probe_in_plane") < 0.7 * firm.largest("probe_in_plane")
    reach = run_case(made(claw={"type": "still", "z_m": -0.2}))["probe_reach"][0]
    assert reach != run_case(made())["probe_reach"][0]


def test_solvers_do_not_step_over_what_the_claw_does() -> None:
    claw = {"type": "points", "time_s": [0, 2, 2.2, 2.4, 3], "x_m": [0, 0, 0.02, 0, 0], "y_m": [0] * 5}
    case = made(changes=STANDING, claw=claw, solution={"end_s": 3.0, "output_step_s": 0.1})
    engine = run_case(case).largest("probe_in_plane")
    assert run_case(case.changed({"solution.solver": "gear"})).largest("probe_in_plane") == pytest.approx(
        engine, rel=5e-3
    )


def test_what_is_no_rest_is_refused() -> None:
    slope = {"type": "fixed", "pitch_deg": 5.0}
    free = {"probe.active": False}
    with pytest.raises(ConfigurationError, match="there is no rest"):
        run_case(made(deck=slope, changes=free))
    resting = {"end_s": 0.0, "equilibrium": True}
    with pytest.raises(ConfigurationError, match="there is no rest"):
        run_case(made(deck=slope, changes=free, start={"type": "settled", "surface": "level"}, solution=resting))
    locked = made(deck=slope, changes={**STANDING, **free}, start={"type": "settled", "surface": "level"})
    pitch = run_case(locked.changed({"solution": resting}))["pitch"][0]
    assert pitch != pytest.approx(run_case(locked)["pitch"][0], abs=1e-4)  # at rest on the slope; on the level at first


def test_a_run_that_diverges_ends_before_it_does() -> None:
    buried = made(start={"type": "drop", "cg_height_m": -8.0}, solution={"end_s": 1.0, "output_step_s": 0.5})
    history = run_case(buried)
    assert history.diverged is not None and "at 0.0" in history.diverged
    assert history.time_s.tolist() == [0.0]


def test_a_case_shares_nothing_with_the_document_it_was_made_of(tmp_path: Path) -> None:
    document: dict[str, Any] = {"name": "t", "helicopter": "generic_tricycle", "solution": dict(SHORT)}
    document["changes"] = {"mass_kg": np.float64(9000.0), "probe.mount_m": (0.0, 0.0, 1.2)}
    case = case_from(document)
    document["changes"]["mass_kg"] = 1.0
    assert case.changes["mass_kg"] == 9000.0 and case_from(case_document(case)) == case
    latin = tmp_path / "latin.yaml"
    latin.write_bytes("name: Léveillé\n".encode("latin-1"))
    with pytest.raises(ConfigurationError, match="UTF-8"):
        load_case(latin)


def test_a_claw_file_is_followed(tmp_path: Path) -> None:
    t = np.linspace(0.0, 1.0, 21)
    np.savetxt(tmp_path / "rsd_pos.inp", np.stack([t, 1e-2 * np.sin(3.0 * t), 0.0 * t, 0.0 * t], axis=1))
    history = run_case(made(claw={"type": "file", "path": str(tmp_path / "rsd_pos.inp")}))
    np.testing.assert_allclose(history["claw_x"], 1e-2 * np.sin(3.0 * history.time_s), atol=2e-6)
    np.testing.assert_allclose(history["claw_vx"], 3e-2 * np.cos(3.0 * history.time_s), atol=2e-4)
