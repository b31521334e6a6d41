"""What comes in is checked: nothing that is wrong is used, and nothing that is wrong stops the monitor."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ssmash_gym.monitor.intake import Intake
from ssmash_gym.monitor.settings import SPACING_S
from ssmash_gym.ship import parse_motion
from ssmash_gym.ship.kinematics import axis_rotation
from tests.monitor.decks import changed, lines, motion, quick

ROLL, VZ = 1, 6


def filled(count: int = 50) -> Intake:
    intake = Intake(quick())
    for line in lines()[: 2 + count]:  # a comment and the names come first
        intake.take(line)
    return intake


def test_comments_and_names_are_passed_over_and_rows_are_used() -> None:
    intake = filled(50)
    assert intake.malformed == 0
    assert intake.accepted == 50
    assert intake.newest_s == pytest.approx(49 * 0.2)
    assert intake.past_s(intake.newest_s) == pytest.approx(49 * 0.2)


@pytest.mark.parametrize(
    ("spoilt", "words"),
    [
        (lambda line: changed(line, ROLL, "nan"), "no finite number"),
        (lambda line: changed(line, ROLL, "inf"), "no finite number"),
        (lambda line: changed(line, ROLL, "roll"), "no finite number"),
        (lambda line: changed(line, 15, ""), "15 columns"),
        (lambda line: changed(line, ROLL, "75"), "no ship can have"),
        (lambda line: changed(line, VZ, "-40"), "no ship can have"),
        (lambda line: changed(line, ROLL, "45"), "jumps"),
        (lambda line: changed(line, 0, "nan"), "without a time"),
        (lambda line: changed(line, 0, "9.8"), "time stands still"),
        (lambda line: line[: len(line) // 2], "columns"),
        (lambda line: "time_s,roll_deg", "columns"),
        (lambda line: "\x00\xff{}", "columns"),
    ],
)
def test_a_bad_row_is_counted_and_left_out(spoilt: Callable[[str], str], words: str) -> None:
    intake = filled(50)
    assert not intake.take(spoilt(lines()[52]))
    assert intake.malformed == 1
    assert words in intake.latest_fault
    assert intake.epoch == 0
    assert intake.take(lines()[53]), "a hole of one sample is bridged"
    assert intake.latest_fault == ""


def test_a_gap_and_a_clock_that_runs_backwards_make_the_past_be_forgotten() -> None:
    intake = filled(50)
    assert intake.take(lines()[2 + 50 + 10])
    assert intake.epoch == 1
    assert "no usable sample from 9.8 to 12 s" in intake.why
    assert intake.past_s(intake.newest_s) == 0.0
    assert intake.take(lines()[2 + 30])
    assert intake.epoch == 2
    assert "time ran backwards" in intake.why


def test_rows_that_are_all_bad_count_as_a_gap() -> None:
    intake = filled(50)
    for line in lines()[52:60]:
        intake.take(changed(line, ROLL, "nan"))
        intake.lapse()
    assert intake.epoch == 1
    assert "no usable sample after 9.8 s" in intake.why
    assert "nan" in intake.why


def test_a_stuck_channel_is_no_past_however_long_it_lasts() -> None:
    intake = filled(20)
    rows = lines()[22:122]
    for line in rows:
        intake.take(changed(line, ROLL, "0.5"))
    assert "roll repeats the same number" in intake.why
    assert intake.past_s(intake.newest_s) == 0.0
    assert intake.take(lines()[122])
    assert intake.take(lines()[123])
    assert intake.past_s(intake.newest_s) > 0.0


def test_a_deck_that_does_not_move_at_all_is_stuck_from_the_beginning() -> None:
    intake = Intake(quick())
    for k in range(100):
        intake.take(" ".join([f"{0.1 * k:.1f}", *["0"] * 15]))
    assert intake.past_s(intake.newest_s) == 0.0
    assert "roll and pitch and yaw" in intake.why


@settings(deadline=None)
@given(st.lists(st.one_of(st.text(max_size=60), st.lists(st.floats(), max_size=20).map(str)), max_size=20))
def test_no_text_stops_it(texts: list[str]) -> None:
    intake = Intake(quick())
    for text in texts:
        intake.take(text)
        intake.lapse()
    assert intake.accepted >= 0
    assert math.isnan(intake.newest_s) or math.isfinite(intake.newest_s)


def test_samples_are_the_motion_in_its_mean_frame_whatever_the_course_and_speed() -> None:
    deck = motion(rough=True)
    times = np.arange(0.0, 20.01, 0.1)
    signal = deck.signal(times)
    course = np.deg2rad(170.0)
    velocity = signal.rate[:, :3] @ axis_rotation(2, np.array(course)).T + np.array([3.0, -6.0, 0.0])
    intake = Intake(quick())
    for t, v, a in zip(times, velocity, np.rad2deg(signal.position[:, 3:]), strict=True):
        yaw = (a[2] + 170.0 + 180.0) % 360.0 - 180.0  # passes 180 deg now and then
        intake.take(" ".join(f"{x:.12g}" for x in (t, a[0], a[1], yaw, *v, *[0.0] * 9)))
    assert intake.malformed == 0
    found = intake.samples(20.0)
    even = deck.signal(np.arange(0.0, 20.01, SPACING_S))
    true = np.concatenate([even.rate[:, :3], even.position[:, 3:]], axis=1)
    np.testing.assert_allclose(found[:, 2:5], (true - true.mean(axis=0) * [1, 1, 1, 0, 0, 1])[:, 2:5], atol=1e-9)
    # The mean heading of the past is not quite the course: the two level velocities turn with it.
    np.testing.assert_allclose(found[:, [0, 1]], (true - true.mean(axis=0))[:, [0, 1]], atol=0.02)
    np.testing.assert_allclose(found[:, 5], true[:, 5] - true[:, 5].mean(), atol=1e-9)


def test_samples_between_rows_are_interpolated() -> None:
    deck = parse_motion({"type": "sinusoid", "dof": "roll", "amplitude_deg": 5.0, "period_s": 8.0}).realise()
    intake = Intake(quick(stuck_s=60.0))
    rng = np.random.default_rng(0)
    times = np.cumsum(rng.uniform(0.05, 0.2, 200))
    for t, roll in zip(times, np.rad2deg(deck.signal(times).position[:, 3]), strict=True):
        intake.take(" ".join(map(repr, [float(t), float(roll), *[0.0] * 14])))
    found = intake.samples(20.0)[:, 3]
    grid = 20.0 - SPACING_S * np.arange(len(found))[::-1]
    np.testing.assert_allclose(found, deck.signal(grid).position[:, 3], atol=1e-4)
