"""A scaled run is the full-scale run, scaled: dynamic similarity, and what constants of the kernel take from it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ssmash_gym.cases import Case, History, case_from, load_case, quantity, run_case
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.systems import at_full_scale, scaled_case
from ssmash_gym.systems.additive import BOTH, CLAW, DECK, Parts, parts_of, parts_table, shares
from ssmash_gym.systems.models import BEYOND

QUANTITIES = ("probe_in_plane_kN", "right_load_kN", "nose_load_kN", "roll_deg", "pitch_deg", "yaw_deg", "x_m", "z_N_m")


def differences(model: History, full: History) -> dict[str, float]:
    """Largest differences over the range of each quantity, of a model told at full scale."""
    np.testing.assert_allclose(model.time_s, full.time_s, rtol=1e-12)
    found = {}
    for name in QUANTITIES:
        a, b = quantity(name).of(model), quantity(name).of(full)
        found[name] = float(np.max(np.abs(a - b)) / np.ptp(b))
    return found


def test_at_half_size_the_run_is_the_same_within_a_ten_thousandth(
    rolling_traverse: Case, runs: dict[str, History]
) -> None:
    model = at_full_scale(run_case(scaled_case(rolling_traverse, 0.5)), rolling_traverse, 0.5)
    found = differences(model, runs["ssmash"])
    assert found.pop("probe_in_plane_kN") < 5e-5
    assert max(found.values()) < 2e-5


def test_at_a_tenth_constants_of_the_kernel_show(rolling_traverse: Case, runs: dict[str, History]) -> None:
    """Tires grip less and less below 10 N, which a tenth's tail tires carry: 3 % of the probe load, 0.5 % elsewhere."""
    model = at_full_scale(runs["feldman_scale"], rolling_traverse, 0.1)
    found = differences(model, runs["ssmash"])
    assert found.pop("probe_in_plane_kN") < 0.03
    assert max(found.values()) < 5e-3
    assert max(found.values()) > 1e-6  # it is another run, not the same numbers


def test_the_model_is_as_small_as_it_says(rolling_traverse: Case, runs: dict[str, History]) -> None:
    small, full = runs["feldman_scale"], runs["ssmash"]
    assert small.case.vehicle.total_mass_kg == pytest.approx(1e-3 * full.case.vehicle.total_mass_kg)
    assert small.time_s[-1] == pytest.approx(np.sqrt(0.1) * 60.0)
    assert small["right_vertical_load"][0] == pytest.approx(1e-3 * full["right_vertical_load"][0], rel=1e-6)
    assert np.ptp(small["claw_x"]) == pytest.approx(0.4, rel=1e-6)
    assert np.ptp(small["deck_roll"]) == pytest.approx(np.ptp(full["deck_roll"]), rel=1e-3)


@pytest.mark.parametrize("scale", [0.2, 4.0])
def test_a_drop_with_sink_speed_onto_swing_arms_is_similar_at_any_size(scale: float) -> None:
    start = {"type": "drop", "cg_height_m": 2.3, "roll_deg": 2.0, "sink_mps": 0.5}
    solution = {"end_s": 1.5, "output_step_s": 0.01, "substep_s": 0.001}
    case = case_from({"name": "drop", "helicopter": "seahawk_like", "start": start, "solution": solution})
    full, model = run_case(case), at_full_scale(run_case(scaled_case(case, scale)), case, scale)
    for name in ("right_load_kN", "nose_load_kN", "roll_deg", "z_N_m"):
        a, b = quantity(name).of(model), quantity(name).of(full)
        assert np.max(np.abs(a - b)) < 0.01 * np.ptp(b), name
    rows = slice(7, 12)  # joint speeds of the swing arms scale as rates
    spread = np.ptp(full.states[rows], axis=1)
    assert np.all(np.max(np.abs(model.states[rows] - full.states[rows]), axis=1) <= 0.03 * spread + 1e-9)


def test_a_state_in_numbers_scales_joint_by_joint() -> None:
    start = {
        "type": "state", "position_m": [1.0, 0.0, -2.5], "orientation": [1.0, 0.0, 0.0, 0.0],
        "strut_m": [0.9, 0.44, 0.44], "strut_orientations": [[1.0, 0.0, 0.0, 0.0]] * 3,
        "velocity_mps": [1.0, 0.0, 0.0], "angular_velocity_radps": [0.0, 0.0, 0.3],
        "strut_rates": [0.1, 0.2, 0.2], "steer_rates_radps": [0.5, 0.0, 0.0],
    }  # fmt: skip
    case = case_from({"name": "given", "helicopter": "seahawk_like", "start": start, "solution": {"end_s": 1.0}})
    model = scaled_case(case, 0.25).start
    assert model.type == "state"
    assert model.position_m == pytest.approx((0.25, 0.0, -0.625))
    assert model.velocity_mps == pytest.approx((0.5, 0.0, 0.0))
    assert model.strut_rates == pytest.approx((0.05, 0.4, 0.4))  # a slide [m/s], two arms [rad/s]
    assert model.steer_rates_radps == pytest.approx((1.0, 0.0, 0.0))
    assert model.strut_orientations == case.start.strut_orientations


def test_a_claw_file_becomes_scaled_points(tmp_path: Path) -> None:
    file = tmp_path / "claw.inp"
    file.write_text("0 0 0 -0.1\n1 0.1 0 -0.1\n2 0.3 0 -0.1\n3 0.3 0 -0.1\n", encoding="utf-8")
    case = case_from(
        {"name": "file", "helicopter": "seahawk_like", "claw": {"type": "file", "path": str(file)},
         "solution": {"end_s": 3.0}}
    )  # fmt: skip
    claw = scaled_case(case, 0.25).claw
    assert claw.type == "points" and claw.relative_to == "ship" and claw.interpolation == "spline"
    given = slice(BEYOND, -BEYOND)  # the run lies within the record, whose spline goes on beyond
    assert claw.time_s[given] == pytest.approx((0.0, 0.5, 1.0, 1.5))
    assert claw.x_m[given] == pytest.approx((0.0, 0.025, 0.075, 0.075))
    assert claw.z_m == pytest.approx(-0.025)


def test_every_manoeuvre_is_scaled_or_refused_in_one_sentence() -> None:
    for name in ("1a", "1b", "1c"):
        assert scaled_case(load_case(name), 0.1).vehicle.total_mass_kg < 11.0
    with pytest.raises(ConfigurationError, match=r"^case 1D cannot be run at another scale: .*\.$"):
        scaled_case(load_case("1d"), 0.1)


# --- deck motion and traverse add up ---------------------------------------------------------------------------


@pytest.mark.parametrize("scale", [1.0, 0.1])
def test_deck_motion_and_traverse_add_up_in_the_probe_load(scale: float, parts: dict[float, Parts]) -> None:
    """Feldman: more than either alone and near the sum; the RMS between the root of squares and the sum."""
    found = parts[scale]
    for figures, least, most in ((found.peak_kN, 0.85, 1.15), (found.rms_kN, 0.7, 1.0)):
        assert figures[BOTH] > 1.2 * max(figures[DECK], figures[CLAW])
        plain, square = shares(figures)
        assert least < plain < most
        assert square > 1.0


def test_the_model_finds_the_same_shares(parts: dict[float, Parts]) -> None:
    for kind in ("peak_kN", "rms_kN"):
        full, model = (shares(getattr(parts[scale], kind))[0] for scale in (1.0, 0.1))
        assert model == pytest.approx(full, abs=0.02)
    table = parts_table({"full": parts[1.0], "tenth": parts[0.1]})
    assert table.count("\n") == 6
    assert f"{shares(parts[1.0].peak_kN)[0]:.2f}" in table


def test_a_manoeuvre_without_both_has_no_parts() -> None:
    with pytest.raises(ConfigurationError, match="its deck and its claw must both move"):
        parts_of(load_case("1c"))
