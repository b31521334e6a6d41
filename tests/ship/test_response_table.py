"""Response tables: conventions, interpolation, mirror, files written and read, and what is refused."""

from __future__ import annotations

import itertools
import math
import warnings
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from pydantic import ValidationError

from ssmash_gym.errors import ConfigurationError, ConfigurationWarning
from ssmash_gym.ship.motion import GRAVITY
from ssmash_gym.ship.response import Response
from ssmash_gym.ship.response_file import ResponseGrid
from ssmash_gym.ship.response_table import ResponseFile, ResponseTable, write_response_table
from ssmash_gym.ship.sea import KNOT, Spectrum, Spreading, encounter
from ssmash_gym.ship.seaway import draw_seaway
from ssmash_gym.ship.seaway_motion import SeawayMotion
from ssmash_gym.ship.ships import load_ship

SPEEDS = (0.0, 10.0, 20.0)
HEADINGS = tuple(range(0, 360, 30))
OMEGAS = (0.3, 0.5, 0.7, 0.9, 1.1)


class WaveRider:
    """A ship that goes with the surface, less and less so in shorter waves; it grows lazier with speed."""

    def respond(self, omega, heading, amplitude, speed_mps, *, roll_damping_factor=1.0, gm_factor=1.0):
        k, calm = omega**2 / GRAVITY, np.exp(-((omega / 0.9) ** 2)) * (1.0 - 0.02 * speed_mps)
        ahead, abeam = np.cos(heading), np.sin(heading)
        H = np.stack(
            [1j * ahead, 1j * abeam, -1.0 + 0.0j * k, 1j * k * abeam, -1j * k * ahead, 0.3j * k * ahead * abeam],
            axis=1,
        )
        return Response(encounter(omega, heading, speed_mps), H * calm[:, np.newaxis], math.nan, True)


RIDER = SimpleNamespace(response=WaveRider())


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_response_table(tmp_path_factory.mktemp("rider") / "rider.csv", RIDER, SPEEDS, HEADINGS, OMEGAS)


@pytest.fixture(scope="module")
def table(path: Path) -> ResponseTable:
    return ResponseTable.read(path)


def nodes(speed_kn: float) -> tuple[np.ndarray, np.ndarray]:
    heading, omega = np.meshgrid(np.radians(HEADINGS), OMEGAS, indexing="ij")
    return omega.ravel(), heading.ravel()


# --- interpolation -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("speed", SPEEDS)
def test_a_written_table_gives_the_ship_back_at_its_nodes(table: ResponseTable, speed: float) -> None:
    omega, heading = nodes(speed)
    found = table.respond(omega, heading, np.ones_like(omega), speed * KNOT)
    exact = RIDER.response.respond(omega, heading, None, speed * KNOT)
    np.testing.assert_allclose(found.transfer, exact.transfer, atol=3e-8)
    np.testing.assert_allclose(found.omega_e, exact.omega_e, rtol=1e-12)
    assert math.isnan(found.roll_damping) and found.converged


def test_between_nodes_it_is_cubic_in_heading_and_frequency_and_linear_in_speed(table: ResponseTable) -> None:
    rng = np.random.default_rng(3)
    omega, heading = rng.uniform(0.3, 1.1, 400), rng.uniform(-7.0, 14.0, 400)
    for speed in (0.0, 4.0, 13.0):
        found = table.respond(omega, heading, np.ones(400), speed * KNOT).transfer
        exact = RIDER.response.respond(omega, heading, None, speed * KNOT).transfer
        size = np.max(np.abs(exact), axis=0)
        assert np.max(np.abs(found - exact) / size) < 0.03  # straight lines would miss sin(2 x) by 14 %
    half = [table.respond(omega, heading, np.ones(400), u * KNOT).transfer for u in (10.0, 15.0, 20.0)]
    np.testing.assert_allclose(half[1], 0.5 * (half[0] + half[2]), atol=1e-12)


def test_responses_out_of_phase_at_two_speeds_do_not_cancel() -> None:
    shape = (2, 8, 3, 6)
    phase = np.zeros(shape)
    phase[1] = 3.0
    amplitude = np.ones(shape)
    amplitude[1] = 3.0
    grid = ResponseGrid(
        "x", np.array([0.0, 10.0]), np.arange(0.0, 360.0, 45.0), np.array([0.4, 0.6, 0.8]), amplitude, phase
    )
    beam = (np.array([0.6]), np.array([np.pi / 2]), np.ones(1))
    for speed, size in ((0.0, 1.0), (2.5, 1.5), (5.0, 2.0), (10.0, 3.0)):
        found = ResponseTable(grid).respond(*beam, speed * KNOT).transfer
        np.testing.assert_allclose(np.abs(found), size, rtol=1e-12)
    assert 0.0 < np.angle(ResponseTable(grid).respond(*beam, 2.0 * KNOT).transfer[0, 0]) < 3.0


def test_headings_go_round(table: ResponseTable) -> None:
    omega = np.full(7, 0.6)
    heading = np.radians([-10.0, 350.0, 710.0, -370.0, 359.9999999, 0.0, 1e-7])
    found = table.respond(omega, heading, omega, 0.0).transfer
    np.testing.assert_allclose(found[1:4], np.tile(found[0], (3, 1)), atol=1e-12)
    np.testing.assert_allclose(found[4], found[5], atol=1e-8)
    np.testing.assert_allclose(found[6], found[5], atol=1e-8)


def test_beyond_the_frequencies_it_is_held_below_and_fades_above(table: ResponseTable) -> None:
    omega = np.array([0.05, 0.3, 1.1, 2.2])
    found = table.respond(omega, np.full(4, 1.0), np.zeros(4), 0.0).transfer
    np.testing.assert_allclose(found[0], found[1], rtol=1e-12)
    np.testing.assert_allclose(found[3], found[2] / 16.0, rtol=1e-12)


def test_a_sea_outside_the_frequencies_is_warned_of(table: ResponseTable) -> None:
    omega, amplitude = np.array([0.7, 1.5]), np.array([1.0, 0.5])
    with pytest.warns(ConfigurationWarning, match=r"more than 10% .* 0\.3 to 1\.1 rad/s"):
        table.respond(omega, np.zeros(2), amplitude, 0.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        table.respond(omega, np.zeros(2), np.array([1.0, 0.2]), 0.0)


# --- conventions ---------------------------------------------------------------------------------------------------


def in_convention(grid: ResponseGrid, axes: str, phase: str, heading: str) -> ResponseGrid:
    """The same ship in a file of another convention, from the definitions: a sign turns a phase by half a circle."""
    file_heading = {
        "towards_starboard": grid.heading_deg,
        "towards_port": (360.0 - grid.heading_deg) % 360.0,
        "from_starboard": (grid.heading_deg + 180.0) % 360.0,
        "from_port": (540.0 - grid.heading_deg) % 360.0,
    }[heading]
    order = np.argsort(file_heading)
    half = np.pi * np.array([0, 1, 1, 0, 1, 1]) if axes == "z_up_port" else np.zeros(6)
    turned = (grid.phase + half) * (1.0 if phase == "lead" else -1.0)
    return ResponseGrid("x", grid.speed_kn, file_heading[order], grid.omega, grid.amplitude[:, order], turned[:, order])


@pytest.mark.parametrize(
    ("axes", "phase", "heading"),
    list(
        itertools.product(
            ("z_down_starboard", "z_up_port"),
            ("lead", "lag"),
            ("towards_starboard", "towards_port", "from_starboard", "from_port"),
        )
    ),
)
def test_every_convention_of_a_file_gives_the_same_ship(axes: str, phase: str, heading: str) -> None:
    rng = np.random.default_rng(5)
    shape = (2, 12, 5, 6)
    grid = ResponseGrid(
        "x",
        np.array([0.0, 20.0]),
        np.array(HEADINGS, dtype=float),
        np.array(OMEGAS),
        rng.uniform(0.0, 1.0, shape),
        rng.uniform(-4.0, 4.0, shape),
    )
    plain = ResponseTable(grid)
    other = ResponseTable(in_convention(grid, axes, phase, heading), convention=axes, phase=phase, heading=heading)
    np.testing.assert_array_equal(other.heading_deg, plain.heading_deg)
    np.testing.assert_allclose(other.transfer, plain.transfer, atol=1e-12)


def surface(tmp_path: Path, row: str, **convention: str) -> np.ndarray:
    """Transfer (6,) at 0.5 rad/s of a file whose every row but the grid columns reads `row`, at the wanted heading."""
    lines = ["speed_kn,heading_deg,omega_rad_s,heave_m_per_m,heave_phase_deg,roll_rad_per_m,roll_phase_deg,"]
    lines[0] += "pitch_rad_per_m,pitch_phase_deg"
    lines += [f"0,{heading},{omega},{row}" for heading in range(0, 360, 45) for omega in (0.4, 0.5, 0.6)]
    (tmp_path / "surface.csv").write_text("\n".join(lines))
    table = ResponseTable.read(tmp_path / "surface.csv", **convention)
    return table.respond(np.array([0.5]), np.array([0.0]), np.ones(1), 0.0).transfer[0]


@pytest.mark.parametrize(
    ("convention", "heave", "roll", "pitch"),
    [
        # A quarter period before the crest the side (or the bow) that the wave comes from is up.
        ({}, 180.0, -90.0, 90.0),
        ({"phase": "lag"}, 180.0, 90.0, -90.0),
        ({"convention": "z_up_port"}, 0.0, -90.0, -90.0),
    ],
)
def test_a_float_on_long_waves(tmp_path: Path, convention: dict[str, str], heave: float, roll: float, pitch: float):
    """Heave with the surface; roll for a wave from starboard; pitch for a wave from ahead, in the guide's signs."""
    k = 0.5**2 / GRAVITY
    found = surface(tmp_path, f"1,{heave},{k},{roll},{k},{pitch}", **convention)
    # Elevation cos(wt + k y) from starboard, cos(wt + k x) from ahead: roll = -d/dy, pitch = +d/dx, down = -elevation.
    assert found[2] == pytest.approx(-1.0)
    assert found[3] == pytest.approx(-1j * k)
    assert found[4] == pytest.approx(1j * k)


@pytest.mark.parametrize(("omega", "sign"), [(0.5, 1.0), (1.4, -1.0)])
def test_a_lead_is_a_lead_in_time_whoever_overtakes(omega: float, sign: float) -> None:
    """Following waves, 20 kn: the motion's greatest value comes a quarter of an encounter period before the crest."""
    shape = (1, 8, 3, 6)
    grid = ResponseGrid(
        "x",
        np.array([20.0]),
        np.arange(0.0, 360.0, 45.0),
        np.array([0.5, 1.0, 1.4]),
        np.ones(shape),
        np.full(shape, np.pi / 2),
    )
    found = ResponseTable(grid).respond(np.array([omega]), np.zeros(1), np.ones(1), 20.0 * KNOT)
    assert np.sign(found.omega_e[0]) == sign
    quarter = 0.5 * np.pi / abs(found.omega_e[0])
    t = np.array([-quarter, 0.0, quarter])
    motion = (found.transfer[0, 3] * np.exp(1j * found.omega_e[0] * t)).real
    np.testing.assert_allclose(motion, [1.0, 0.0, -1.0], atol=1e-12)


def test_one_side_is_mirrored_where_the_ship_is_symmetric(path: Path, tmp_path: Path, table: ResponseTable) -> None:
    for side in (HEADINGS[:7], (*HEADINGS[6:], 360)):
        half = write_response_table(tmp_path / "half.csv", RIDER, SPEEDS, side, OMEGAS)
        mirrored = ResponseTable.read(half, symmetric=True)
        np.testing.assert_array_equal(mirrored.heading_deg, table.heading_deg)
        np.testing.assert_allclose(mirrored.transfer, table.transfer, atol=3e-8)
    with pytest.raises(ConfigurationError, match=r"gap of 180 degrees .* 45 at most; symmetric: true fills one side"):
        ResponseTable.read(half)
    with pytest.raises(ConfigurationError, match="headings on both sides of the ship, allowed are headings on one"):
        ResponseTable.read(path, symmetric=True)


def test_the_section_of_a_ships_file(tmp_path: Path, table: ResponseTable) -> None:
    (tmp_path / "data").mkdir()
    half = write_response_table(tmp_path / "data" / "half.npz", RIDER, SPEEDS, HEADINGS[:7], OMEGAS)
    section = ResponseFile.model_validate({"table": "data/half.npz", "symmetric": True}, context={"folder": tmp_path})
    np.testing.assert_allclose(section.read().transfer, table.transfer, atol=1e-7)
    lagging = ResponseFile.model_validate({"table": half, "symmetric": True, "phase": "lag"}).read()
    np.testing.assert_allclose(lagging.transfer[0], np.conj(table.transfer[0]), atol=1e-7)
    for wrong in ({"phase": "behind"}, {"heading": "north"}, {"convention": "z_up"}, {"frame": "z_up"}):
        with pytest.raises(ValidationError):
            ResponseFile.model_validate({"table": half} | wrong)
    with pytest.raises(ConfigurationError, match="phase is 'behind', allowed are lead, lag"):
        ResponseTable.read(half, phase="behind", symmetric=True)  # type: ignore[arg-type]


# --- what it cannot do ---------------------------------------------------------------------------------------------


def test_speeds_and_factors_that_a_table_cannot_answer_are_refused(table: ResponseTable, tmp_path: Path) -> None:
    one = (np.array([0.5]), np.array([0.0]), np.ones(1))
    still = write_response_table(tmp_path / "still.csv", RIDER, (0.0,), HEADINGS, OMEGAS)
    with pytest.raises(ConfigurationError, match=r"speed is 21 kn, allowed is 0 to 20 kn, what the table covers"):
        table.respond(*one, 21.0 * KNOT)
    with pytest.raises(ConfigurationError, match=r"speed is 5 kn, allowed is 0 kn"):
        ResponseTable.read(still).respond(*one, 5.0 * KNOT)
    for factor in ("roll_damping_factor", "gm_factor"):
        with pytest.raises(ConfigurationError, match=f"{factor} is 1.2, allowed is 1: a table cannot"):
            table.respond(*one, 0.0, **{factor: 1.2})


# --- written tables ---


def test_arrays_are_the_same_table(tmp_path: Path, table: ResponseTable) -> None:
    file = write_response_table(tmp_path / "rider.npz", RIDER, SPEEDS, HEADINGS, OMEGAS)
    np.testing.assert_allclose(ResponseTable.read(file).transfer, table.transfer, atol=3e-8)
    assert set(np.load(file).files) >= {"speed_kn", "heading_deg", "omega_rad_s", "roll_deg_per_m", "roll_phase_deg"}


def test_what_cannot_be_written_is_refused_and_leaves_nothing(tmp_path: Path, table: ResponseTable) -> None:
    ship = SimpleNamespace(response=table)
    for axes, words in [
        (((0.0,), (0, 45), (0.6, 0.4)), "omega_rad_s is .* allowed are rising"),
        (((), (0, 45), (0.4, 0.6)), "speed_kn is .* allowed are rising"),
        (((0.0,), (0, 400), (0.4, 0.6)), "heading_deg is .* -180 to 360"),
        (((0.0, 30.0), (0, 45), (0.4, 0.6)), "speed is 30 kn, allowed is 0 to 20 kn"),
    ]:
        with pytest.raises(ConfigurationError, match=words):
            write_response_table(tmp_path / "out.csv", ship, *axes)
    (tmp_path / "file").touch()
    with pytest.raises(ConfigurationError, match="cannot be written"):
        write_response_table(tmp_path / "file" / "out.csv", ship, (0.0,), (0, 45), (0.4, 0.6))
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


# --- a hull as a table ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("heading_deg", [60.0, 120.0])
def test_a_hull_written_as_a_table_moves_alike(tmp_path: Path, heading_deg: float) -> None:
    """SS5, 10 kn: the same waves on the hull and on its table of every 5 degrees and 0.02 rad/s about the roll."""
    ship = load_ship("frigate")
    rng = np.random.default_rng(2)
    exact = draw_seaway(ship, Spectrum(3.3, 9.7), Spreading("cos2"), math.radians(heading_deg), 10.0 * KNOT, rng)
    waves = exact.waves
    omegas = np.concatenate([np.linspace(0.30, 0.90, 31), np.linspace(0.95, 2.05, 23)])
    file = write_response_table(tmp_path / "hull.npz", ship, (10.0,), range(0, 181, 5), omegas, waves=waves)
    table = ResponseTable.read(file, symmetric=True)
    response = table.respond(waves.omega, waves.heading, waves.amplitude, 10.0 * KNOT)
    found = SeawayMotion(waves, response, ship.deck_point_m)
    for one, other in zip(found.sample(0.0, 0.25, 480), exact.sample(0.0, 0.25, 480), strict=True):
        error = np.sqrt(np.mean((one - other) ** 2, axis=0)) / np.sqrt(np.mean(other**2, axis=0))
        assert np.max(error) < 0.03
    assert found.deck.roll_deg == pytest.approx(exact.deck.roll_deg, rel=0.01)
    assert found.deck.lateral_specific_force_g == pytest.approx(exact.deck.lateral_specific_force_g, rel=0.01)
