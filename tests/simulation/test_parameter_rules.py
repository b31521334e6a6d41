"""What is derived from a description: spring constants, pressures, locks, modes, the state at full droop."""

from __future__ import annotations

import numpy as np
import pytest

from ssmash_gym.dynamics.layout import (
    PARAMETER_ROWS,
    STATE_ROWS,
    STATION_ROWS,
    TIRE_PAR,
    ClawDrive,
    Contact,
    Friction,
    Mode,
    Par,
    ProbeLaw,
    Sta,
    State,
    StationKind,
    Tir,
    TireModel,
)
from ssmash_gym.dynamics.oleo import spring_curve
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.simulation.parameters import Modes, droop_state, mode_vector, parameter_column
from ssmash_gym.vehicle import Helicopter, load_helicopter, with_changes
from ssmash_gym.vehicle.geometry import lowest_points, strut_length


@pytest.fixture(scope="module")
def tricycle() -> Helicopter:
    return load_helicopter("generic_tricycle")


@pytest.fixture(scope="module")
def seahawk() -> Helicopter:
    return load_helicopter("seahawk_like")


# --- derived rows --------------------------------------------------------------------------------------------


def test_the_spring_is_smooth_across_all_its_regions(tricycle: Helicopter, seahawk: Helicopter) -> None:
    for helicopter in (tricycle, seahawk):
        column = parameter_column(helicopter)
        for i, station in enumerate(helicopter.station_tuple):
            rows = column[Par.STATION + i * STATION_ROWS :][:STATION_ROWS]
            values = {member.name.lower(): float(rows[member]) for member in Sta}
            oleo = station.spring
            assert oleo.type == "gas_oleo"
            e = 1e-6
            for x in (0.0, oleo.x0_m, oleo.x1_m, oleo.x2_m):
                low, mid, high = spring_curve(values, np.array([x - e, x, x + e]))
                before, after = (mid - low) / e, (high - mid) / e
                assert before == pytest.approx(after, rel=5e-3)
            x = np.linspace(0.0, station.end_stop.stroke_m, 5001)
            assert np.all(np.diff(spring_curve(values, x)) > 0.0)
            at_x1 = spring_curve(values, np.array([oleo.x1_m]))[0]
            assert at_x1 == pytest.approx(oleo.gas_force(oleo.x1_m)[0], rel=1e-9)


def test_absolute_pressures_and_lengths(tricycle: Helicopter, seahawk: Helicopter) -> None:
    column = parameter_column(tricycle)
    assert column[TIRE_PAR + Tir.P_ABS] == tricycle.stations.auxiliary.tires[0].pressure_Pa + 101325.0
    column = parameter_column(seahawk)
    right = Par.STATION + STATION_ROWS
    r_P1, r_P2 = column[right + Sta.P1 : right + Sta.P1 + 3], column[right + Sta.P2 : right + Sta.P2 + 3]
    r_O = column[right + Sta.MOUNT : right + Sta.MOUNT + 3]
    assert column[right + Sta.LENGTH] == pytest.approx(np.linalg.norm(r_O + r_P2 - r_P1), rel=1e-14)
    assert column[right + Sta.LENGTH] == strut_length(seahawk.stations.right)


def test_a_cg_offset_moves_every_point_of_the_body(seahawk: Helicopter) -> None:
    offset = np.array([0.4, -0.05, 0.1])
    before, after = parameter_column(seahawk), parameter_column(with_changes(seahawk, {"cg_offset_m": offset}))
    points = [Par.CP, Par.PROBE_MOUNT]
    points += [Par.STATION + i * STATION_ROWS + Sta.MOUNT for i in range(3)]
    points += [Par.STATION + i * STATION_ROWS + Sta.P1 for i in (1, 2)]
    moved = np.zeros(PARAMETER_ROWS, dtype=bool)
    for row in points:
        assert after[row : row + 3] == pytest.approx(before[row : row + 3] - offset, abs=1e-15)
        moved[row : row + 3] = True
    assert np.array_equal(before[~moved], after[~moved])


def test_locks(tricycle: Helicopter, seahawk: Helicopter) -> None:
    column = parameter_column(tricycle)
    assert list(column[Par.LOCK : Par.LOCK + 12]) == [0] * 9 + [1, 0, 1]  # u16 and u18: the mains do not steer
    locked = parameter_column(with_changes(tricycle, {"stations.*.steering": "locked", "stations.*.rolling": "locked"}))
    assert list(locked[Par.LOCK : Par.LOCK + 12]) == [0] * 7 + [1, 0, 1, 0, 1]
    assert [locked[Par.STATION + i * STATION_ROWS + Sta.ROLL_LOCK] for i in range(3)] == [1, 1, 1]
    assert list(parameter_column(seahawk)[Par.LOCK + State.U13 : Par.LOCK + 12]) == [0, 0, 0, 1, 0, 1]


def test_a_lock_with_free_play_is_no_lock_but_a_stop(tricycle: Helicopter) -> None:
    play = {"play_rad": 0.02, "stop_stiffness_Nmprad": 1.0e5, "stop_damping_Nmspr": 300.0}
    half = 0.1  # of the angle at which the wheel is locked
    changed = with_changes(
        tricycle,
        {"stations.right.steer_play": play, "stations.right.orientation": [np.cos(half), 0.0, 0.0, np.sin(half)]},
    )
    column = parameter_column(changed)
    assert list(column[Par.LOCK : Par.LOCK + 12]) == [0] * 11 + [1]
    assert list(mode_vector(changed)[Mode.PLAY : Mode.PLAY + 3]) == [0, 1, 0]
    assert not mode_vector(tricycle)[Mode.PLAY : Mode.PLAY + 3].any()
    rows = column[Par.STATION + STATION_ROWS :][:STATION_ROWS]
    assert list(rows[[Sta.STEER_PLAY, Sta.STEER_STOP_K, Sta.STEER_STOP_C]]) == [0.02, 1.0e5, 300.0]
    np.testing.assert_allclose(rows[[Sta.STEER_COS, Sta.STEER_SIN]], [np.cos(half), np.sin(half)], rtol=1e-12)


# --- modes ---------------------------------------------------------------------------------------------------


def test_the_modes_of_the_catalogue(tricycle: Helicopter, seahawk: Helicopter) -> None:
    modes = mode_vector(seahawk)
    assert modes.dtype == np.int64
    assert list(modes[:3]) == [StationKind.PRISMATIC, StationKind.SWING_ARM, StationKind.SWING_ARM]
    assert list(modes[Mode.TIRES : Mode.TIRES + 3]) == [2, 1, 1]
    assert list(mode_vector(tricycle)[Mode.TIRES : Mode.TIRES + 3]) == [2, 2, 2]
    assert mode_vector(with_changes(tricycle, {"tire_model": "linear"}))[Mode.TIRE_MODEL] == TireModel.LINEAR


def test_every_law_has_a_name(tricycle: Helicopter) -> None:
    for key, row, choices in (
        ("contact", Mode.CONTACT, Contact),
        ("friction", Mode.FRICTION, Friction),
        ("probe_law", Mode.PROBE_LAW, ProbeLaw),
        ("claw", Mode.CLAW, ClawDrive),
    ):
        for choice in choices:
            assert mode_vector(tricycle, Modes(**{key: choice.name.lower()}))[row] == choice
    assert Modes(friction="Friction-Circle") == Modes(friction="friction_circle")
    default = mode_vector(tricycle)
    assert default[Mode.CONTACT] == Contact.CONTACT
    assert default[Mode.FRICTION] == Friction.LIMIT_SURFACE
    assert default[Mode.PROBE_LAW] == ProbeLaw.POTENTIAL
    assert default[Mode.CLAW] == ClawDrive.COMMANDED


def test_an_unknown_law_is_refused() -> None:
    with pytest.raises(ConfigurationError, match=r"friction = 'ice' .*limit_surface, friction_circle, independent"):
        Modes(friction="ice")


# --- initial state ---------------------------------------------------------------------------------------------


def test_full_droop_hangs_the_lowest_tire_on_the_deck(tricycle: Helicopter, seahawk: Helicopter) -> None:
    state = droop_state(tricycle)
    assert state.shape == (STATE_ROWS,)
    foot = lowest_points(tricycle.stations.auxiliary)[:, 2].max()
    assert list(state[State.Q8 : State.Q11]) == pytest.approx([0.0, 0.0, -foot])
    assert list(state[State.Q11 : State.Q15]) == [1, 0, 0, 0]
    for row in (State.Q15, State.Q20, State.Q25):
        assert list(state[row : row + 5]) == [1.0, 1, 0, 0, 0]
    assert state[State.PROBE_CAPTURED] == 1.0
    assert not state[: State.Q8].any()
    assert droop_state(seahawk)[State.Q20] == 0.44
    assert droop_state(with_changes(tricycle, {"cg_offset_m": [0, 0, 0.2]}))[State.Q10] == pytest.approx(0.2 - foot)


def test_the_drop_can_start_where_one_says(tricycle: Helicopter) -> None:
    yaw = np.radians(8.0)
    turned = (float(np.cos(yaw / 2)), 0.0, 0.0, float(np.sin(yaw / 2)))
    state = droop_state(tricycle, position_S=(1.0, 0.1, -2.7), orientation=turned)
    assert list(state[State.Q8 : State.Q11]) == [1.0, 0.1, -2.7]
    assert list(state[State.Q11 : State.Q15]) == pytest.approx(turned, abs=1e-15)


def test_a_rolled_helicopter_still_hangs_its_lowest_tire_on_the_deck(seahawk: Helicopter) -> None:
    half = np.radians(5.0) / 2
    height = -droop_state(seahawk, orientation=(float(np.cos(half)), float(np.sin(half)), 0.0, 0.0))[State.Q10]
    # Starboard down by 5 deg: the right main wheel, 1.395 m out, centre 1.91 m down, radius 0.3251 m in its plane.
    by_hand = 1.395 * np.sin(2 * half) + 1.91 * np.cos(2 * half) + 0.3251 * np.cos(2 * half)
    assert height == pytest.approx(by_hand, abs=1e-12)
    assert lowest_points(seahawk.stations.right)[0, 2] == pytest.approx(2.2351)
