"""What the thesis suspects behind its misfits in 2A to 2C: the trend of each, and that it changes nothing else."""

from __future__ import annotations

import functools

import numpy as np
import pytest

from ssmash_gym.analysis.validation.manoeuvres import manoeuvre_named, suspects_of
from ssmash_gym.analysis.validation.measures import curve
from ssmash_gym.analysis.validation.planar_measures import fluctuation, trend
from ssmash_gym.analysis.validation.suspects import STEER_PLAY, SUSPECTS
from ssmash_gym.cases import History, load_case, run_case

PAIRS = [(name, variant.name) for name, variants in SUSPECTS.items() for variant in variants]


@functools.cache
def own(name: str) -> History:
    return run_case(load_case(name))


@functools.cache
def suspect(name: str, variant: str) -> History:
    changes = {one.name: one.changes for one in suspects_of(name)}
    return run_case(load_case(name).changed(changes[variant]))


@pytest.mark.parametrize(("name", "variant"), PAIRS)
def test_a_suspect_is_described_drawn_and_measured(name: str, variant: str) -> None:
    found = {one.name: one for one in suspects_of(name)}[variant]
    numbers = {figure.number for figure in manoeuvre_named(name).figures}
    assert set(found.figures) <= numbers and found.figures
    assert "Section 3.2.2" in found.words and '"' in found.words  # where, and the thesis' own words
    assert found.statements and all(statement.needs == (variant,) for statement in found.statements)


def with_play(degrees: float) -> History:
    play = {**STEER_PLAY.changes["changes"]["stations.auxiliary.steer_play"], "play_rad": float(np.radians(degrees))}
    return run_case(load_case("2A").changed({"changes": {"stations.auxiliary.steer_play": play}}))


def test_free_play_lets_the_tail_wheel_go_with_the_side_force_and_yaw_with_it() -> None:
    none, two, one = own("2A"), suspect("2A", "steer_play"), with_play(1.0)
    pulled, back = 20.0, 36.0
    steer = [np.interp([pulled, back], h.time_s, curve(h, "steer_deg")) for h in (one, two)]
    assert steer[0] == pytest.approx([-1.0, 1.0], abs=0.3)  # against the stop, and on the way back against the other
    assert steer[1][0] == pytest.approx(-2.0, abs=0.3) and steer[1][1] > -1.0
    yaw = [float(np.interp(pulled, h.time_s, trend(h, "yaw_deg"))) for h in (none, one, two)]
    assert yaw[0] < yaw[1] < yaw[2]
    assert yaw[2] - yaw[0] == pytest.approx(2.0 * (yaw[1] - yaw[0]), rel=0.3)


def test_fluctuation_of_the_x_force_is_in_proportion_to_the_noise_of_the_claw() -> None:
    half = run_case(load_case("2A").changed({"claw.noise.rms_m": 0.001}))
    noisy, less, quiet = (fluctuation(h, "probe_x_kN") for h in (own("2A"), half, suspect("2A", "quiet_claw")))
    assert noisy == pytest.approx(2.0 * less, rel=0.15)
    assert quiet < 0.1 * noisy


@pytest.mark.parametrize("name", ["2B", "2C"])
def test_a_turned_probe_changes_only_what_is_measured(name: str) -> None:
    true, turned = own(name), suspect(name, "probe_turn")
    assert np.array_equal(true.states, turned.states) and np.array_equal(true.outputs, turned.outputs)
    sizes = [np.hypot(curve(h, "probe_x_kN"), curve(h, "probe_y_kN")) for h in (true, turned)]
    assert sizes[0] == pytest.approx(sizes[1], abs=1e-9)
    turn = turned.case.probe_turn
    assert turn is not None
    angles = [np.unwrap(np.arctan2(curve(h, "probe_y_kN"), curve(h, "probe_x_kN"))) for h in (true, turned)]
    apart = np.angle(np.exp(1j * (angles[0] - angles[1])))[true.time_s > max(turn.to_s, 10.0)]
    assert np.degrees(apart) == pytest.approx(turn.angle_deg, abs=1e-6)


def test_the_measured_x_force_of_a_turned_probe_declines_and_becomes_negative() -> None:
    times = (30.0, 45.0, 60.0, 75.0, 88.0)
    measured = np.interp(times, own("2B").time_s, trend(suspect("2B", "probe_turn"), "probe_x_kN"))
    true = np.interp(times, own("2B").time_s, trend(own("2B"), "probe_x_kN"))
    assert np.all(true > 0.3)
    assert measured[0] == pytest.approx(true[0], abs=0.1) and measured[-1] < -0.5
    assert np.all(np.diff(measured[:4]) < 0.0)


def test_a_patch_lets_the_tire_that_is_on_it_relax_and_more_so_the_more_slippery_it_is() -> None:
    base = own("2B")
    on = (base.time_s >= 58.0) & (base.time_s <= 70.0)
    mild = run_case(load_case("2B").changed(
        {"patch": {"x_m": [3.29, 3.8], "y_m": [1.6, 2.5], "friction_factor": 0.4, "edge_m": 0.02}}
    ))  # fmt: skip
    fell = []
    for history in (base, mild, suspect("2B", "patch")):
        right, left = (np.mean(trend(history, f"{side}_tire_deflection_mm")[on]) for side in ("right", "left"))
        fell.append((right, left))
    assert fell[0][0] > fell[1][0] > fell[2][0]
    assert fell[0][0] - fell[2][0] > 1.0
    assert abs(fell[0][1] - fell[2][1]) < 0.5 * (fell[0][0] - fell[2][0])
    before = base.time_s < 50.0
    assert np.array_equal(base.states[:, before], suspect("2B", "patch").states[:, before])
