"""The wind over the deck: the wind of a sea, directions, and the record beside a motion file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.ship.wind import (
    KNOT,
    SEA_WINDS,
    Gust,
    blows_towards,
    from_waves,
    read_wind,
    true_wind_of_height,
    wind_over_deck,
    write_wind,
)

# --- the wind of a sea -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("hs", "knots"), [(0.88, 13.5), (1.88, 19.0), (3.25, 24.5), (5.0, 37.5)])
def test_the_wind_of_a_sea_state_is_the_tables(hs: float, knots: float) -> None:
    assert true_wind_of_height(hs, height_m=19.5) == pytest.approx(knots * KNOT, rel=1e-12)
    assert true_wind_of_height(hs) == pytest.approx(0.909 * knots * KNOT, rel=1e-3)  # at 10 m


def test_it_rises_with_the_sea_from_nothing() -> None:
    heights = np.linspace(0.0, 8.0, 400)
    speeds = [true_wind_of_height(hs) for hs in heights]
    assert speeds[0] == 0.0 and np.all(np.diff(speeds) > 0.0)
    assert len(SEA_WINDS) == 9


def test_it_is_near_the_fully_developed_sea() -> None:
    """Pierson & Moskowitz 1964, Hs = 0.21 U^2 / g at 19.5 m: within a fifth from sea state 3 to 5."""
    for hs in (0.88, 1.88, 3.25):
        assert true_wind_of_height(hs, 19.5) == pytest.approx(np.sqrt(9.81 * hs / 0.21), rel=0.2)


def test_heights_beyond_the_table_are_refused() -> None:
    for hs in (-0.1, 11.6):
        with pytest.raises(ConfigurationError, match=rf"hs_m is {hs:g}, allowed is 0 to 11\.5 m"):
            true_wind_of_height(hs)
    with pytest.raises(ConfigurationError, match="hs_m is nan, allowed are finite numbers"):
        true_wind_of_height(float("nan"))
    with pytest.raises(ConfigurationError, match="height_m is 0"):
        true_wind_of_height(1.0, 0.0)


# --- directions ------------------------------------------------------------------------------------------------------


def test_wind_over_the_deck() -> None:
    np.testing.assert_allclose(wind_over_deck(10.0, 0.0, 5.0), (-15.0, 0.0, 0.0), atol=1e-12)
    np.testing.assert_allclose(wind_over_deck(10.0, 90.0, 0.0), (0.0, -10.0, 0.0), atol=1e-12)
    np.testing.assert_allclose(wind_over_deck(10.0, 180.0, 10.0), 0.0, atol=1e-12)  # running before the wind
    assert not np.signbit(wind_over_deck(0.0, 0.0, 0.0)).any()


def test_a_wind_blows_away_from_where_it_comes_from() -> None:
    for angle in (0.0, 30.0, 135.0, 270.0):
        np.testing.assert_allclose(wind_over_deck(7.0, angle, 0.0), 7.0 * blows_towards(angle), atol=1e-12)
        assert np.linalg.norm(blows_towards(angle)) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("heading", "offset", "expected"),
    [(180, 0, 0), (90, 0, 270), (270, 0, 90), (0, 0, 180), (180, -30, 330), (0, 200, 20)],
)
def test_a_wind_along_the_waves_comes_from_where_they_come_from(heading: float, offset: float, expected: float) -> None:
    assert from_waves(heading, offset) == pytest.approx(expected)


def test_wind_and_waves_travel_alike() -> None:
    """Waves that travel towards starboard come with a wind that blows towards starboard."""
    assert wind_over_deck(8.0, from_waves(90.0), 0.0) == pytest.approx([0.0, 8.0, 0.0], abs=1e-12)
    assert wind_over_deck(8.0, from_waves(0.0), 0.0) == pytest.approx([8.0, 0.0, 0.0], abs=1e-12)


# --- records ---------------------------------------------------------------------------------------------------------

MEAN = wind_over_deck(12.0, 60.0, 5.0)
GUST = Gust.draw(12.0, 0.15, np.random.default_rng(1))


@pytest.mark.parametrize("kind", ["steady", "sines", "table"])
def test_a_record_comes_back(tmp_path: Path, kind: str) -> None:
    gusts = {"steady": None, "sines": GUST, "table": GUST.bake(20.0)}[kind]
    file = write_wind(tmp_path / "a" / "wind.csv", MEAN, gusts, 60.0, 0.1, 20.0)
    record = read_wind(file)
    assert record.name == str(file) and record.start_s == 0.0 and record.step_s == pytest.approx(0.1)
    assert record.wind.shape == (201, 3)
    speed = np.zeros(201) if gusts is None else GUST.at(0.1 * np.arange(201))[:, 0]
    np.testing.assert_allclose(record.wind, MEAN + speed[:, None] * blows_towards(60.0), atol=1e-3)
    along = record.wind @ blows_towards(60.0)
    assert np.std(along) == pytest.approx(np.std(speed), abs=1e-3)
    assert (np.std(speed) > 1.0) == (kind != "steady")


def test_a_record_that_cannot_be_written_leaves_nothing(tmp_path: Path) -> None:
    file = tmp_path / "wind.csv"
    file.write_text("before")
    for wind, gusts, dt, message in (
        ((1.0, 2.0), None, 0.1, "wind is .*, allowed are three finite numbers"),
        ((1.0, 2.0, np.inf), None, 0.1, "allowed are three finite numbers"),
        (MEAN, None, 0.0, "dt is 0"),
        (MEAN, GUST.bake(5.0), 0.1, r"time 5\.1 s is outside the table, 0 to 5 s"),
    ):
        with pytest.raises(ConfigurationError, match=message):
            write_wind(file, wind, gusts, 60.0, dt, 6.0)
    assert file.read_text() == "before" and list(tmp_path.iterdir()) == [file]
    with pytest.raises(ConfigurationError, match="cannot be written"):
        write_wind(file / "below" / "wind.csv", MEAN, None, 0.0, 0.1, 1.0)


HEADER = "time_s,wind_x_mps,wind_y_mps,wind_z_mps"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", f"line 1: expected the columns {HEADER}"),
        ("time,x,y,z\n0,1,2,3\n", f"line 1: expected the columns {HEADER}"),
        (f"{HEADER}\n0,1,2,3\n", "holds 1 rows of numbers, allowed are 2 or more"),
        (f"{HEADER}\n0,1,2,3\n\n0.1,1,2\n", "line 4: expected 4 finite numbers separated by commas, found '0.1,1,2'"),
        (f"{HEADER}\n0,1,2,3\n0.1,1,x,3\n", "line 3: expected 4 finite numbers"),
        (f"{HEADER}\n0,1,2,3\n0.1,1,nan,3\n", "line 3: expected 4 finite numbers"),
        (f"{HEADER}\n0,1,2,3\n0.1,1,2,3\n0.2,1,2,3\n0.4,1,2,3\n", "line 5: time 0.4 s comes 0.2 s after"),
        (f"{HEADER}\n0,1,2,3\n0,1,2,3\n", "line 3: time 0 s comes 0 s after"),
        (
            f"{HEADER}\n0,1,2,3\n0.1,1,2,3\n-0.1,1,2,3\n-0.2,1,2,3\n-0.3,1,2,3\n",
            "line 4: time -0.1 s comes -0.2 s after",
        ),
    ],
)
def test_a_bad_record_is_refused_by_line(tmp_path: Path, text: str, message: str) -> None:
    file = tmp_path / "wind.csv"
    file.write_text(text)
    with pytest.raises(ConfigurationError) as caught:
        read_wind(file)
    assert message in str(caught.value) and str(file) in str(caught.value)


def test_a_record_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match="cannot be read"):
        read_wind(tmp_path / "none.csv")
