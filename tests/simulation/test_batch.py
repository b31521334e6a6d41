"""A batch of helicopters: what it takes, what it refuses, and that columns never touch each other."""

from __future__ import annotations

import multiprocessing

import numpy as np
import pytest

from ssmash_gym.dynamics.channels import Out
from ssmash_gym.dynamics.layout import STATE_ROWS, Mode, Par, State
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.ship import Fixed, Sinusoid
from ssmash_gym.simulation.batch import Batch, ClawLimits, Timing
from ssmash_gym.simulation.parameters import Modes, droop_state, parameter_column
from ssmash_gym.vehicle import Helicopter, load_helicopter, with_changes

HELICOPTERS = ("generic_tricycle", "seahawk_like")


@pytest.fixture(scope="module")
def tricycle() -> Helicopter:
    return load_helicopter("generic_tricycle")


def rolling(batch: Batch, seconds: float = 4.0) -> None:
    table = Sinusoid(dof="roll", amplitude_deg=5.0, period_s=6.0).bake(seconds, batch.timing.node_spacing_s)
    batch.set_motion([table] * batch.n)


def bits(batch: Batch, k: int) -> list[np.ndarray]:
    names = ("state", "parameters", "_commands", "clocks", "_outputs", "_highs", "_lows")
    return [getattr(batch, name)[..., k].copy() for name in names] + [batch._nodes[k].copy(), batch._ends[k]]


def same(a: list[np.ndarray], b: list[np.ndarray]) -> bool:
    return all(np.array_equal(x, y) for x, y in zip(a, b, strict=True))


# --- making one ----------------------------------------------------------------------------------------------------


def test_one_description_many_columns(tricycle: Helicopter) -> None:
    batch = Batch(tricycle, 5)
    assert batch.n == 5 and batch.helicopters == [tricycle] * 5
    assert np.array_equal(batch.state, np.repeat(droop_state(tricycle)[:, None], 5, axis=1))
    described = parameter_column(tricycle)
    claw = np.flatnonzero(batch.parameters[:, 0] != described)
    assert np.all((claw >= Par.CLAW_Z) & (claw <= Par.RIPPLE_PHASE))
    assert batch.time_s.tolist() == [0.0] * 5 and not batch.diverged.any()
    assert Batch(tricycle).n == 1


def test_several_descriptions_of_one_layout(tricycle: Helicopter) -> None:
    heavy = with_changes(tricycle, {"mass_kg": 12000.0})
    batch = Batch([tricycle, heavy, tricycle])
    assert batch.parameters[Par.MASS].tolist() == [tricycle.mass_kg, 12000.0, tricycle.mass_kg]


@pytest.mark.parametrize("change", ["seahawk", "tires", "spring", "model"])
def test_another_layout_is_refused(tricycle: Helicopter, change: str) -> None:
    tire = tricycle.station_tuple[0].tires[0].model_dump(mode="json")
    other = {
        "seahawk": load_helicopter("seahawk_like"),
        "tires": with_changes(tricycle, {"stations.auxiliary.tires": [tire]}),
        "spring": with_changes(
            tricycle,
            {"stations.left.spring": {"type": "linear_strut", "stiffness_Npm": 2e5, "damping_Nspm": 1e4}},
        ),
        "model": with_changes(tricycle, {"tire_model": "linear"}),
    }[change]
    with pytest.raises(ConfigurationError, match=r"one layout \(stations, springs, tires\)"):
        Batch([tricycle, other])
    batch = Batch(tricycle, 2)
    before = [bits(batch, k) for k in range(2)]
    with pytest.raises(ConfigurationError, match="another layout"):
        batch.describe([other], [1])
    assert all(same(bits(batch, k), before[k]) for k in range(2))


@pytest.mark.parametrize(
    ("substep", "interval"), [(0.0, 0.1), (-0.002, 0.1), (0.03, 0.3), (0.002, 0.0305), (0.002, 0.0005), (0.004, 0.1021)]
)
def test_timing_is_whole_substeps(substep: float, interval: float) -> None:
    with pytest.raises(ConfigurationError, match=r"substep_s|control_interval_s"):
        Timing(substep, interval)


@pytest.mark.parametrize(("substep", "interval", "count"), [(0.002, 0.1, 50), (0.001, 0.1, 100), (0.003, 0.3, 100)])
def test_timing_counts(substep: float, interval: float, count: int) -> None:
    timing = Timing(substep, interval)
    assert timing.substeps == count
    assert timing.node_spacing_s == timing.substeps_per_node * substep
    assert abs(timing.node_spacing_s - 0.25) <= 0.5 * substep


@pytest.mark.parametrize(
    "changes",
    [
        {"speed_along_m_s": 0.0}, {"acceleration_m_s2": -1.0}, {"delay_s": -0.1}, {"ripple_hz": 0.0},
        {"x_min_m": 9.0}, {"height_m": -0.1}, {"speed": 1.0}, {"y_travel_m": float("nan")},
    ],
)  # fmt: skip
def test_claw_limits_that_make_no_sense_are_refused(changes: dict[str, float]) -> None:
    with pytest.raises(ValueError, match=next(iter(changes))):
        ClawLimits(**changes)


# --- deck motion -----------------------------------------------------------------------------------------------------


def test_tables_of_another_spacing_are_refused(tricycle: Helicopter) -> None:
    batch = Batch(tricycle, 1)
    with pytest.raises(ConfigurationError, match=r"node spacing 0\.2 s, must be 0\.25 s"):
        batch.set_motion([Fixed().bake(1.0, 0.2)])


def test_the_end_of_a_table_is_refused_before_anything_moves(tricycle: Helicopter) -> None:
    batch = Batch(tricycle, 3)
    batch.place(0.0, 0.0, 0.0)
    short, long = (Sinusoid(dof="heave", amplitude_m=0.1, period_s=6.0).bake(s, 0.25) for s in (1.0, 3.0))
    batch.set_motion([long, short, Fixed(roll_deg=1.0).bake(1.0, 0.25)])
    batch.advance(intervals=10)
    before = [bits(batch, k) for k in range(3)]
    with pytest.raises(ValueError, match="helicopter 1 ends at 1 s; bake a longer table"):
        batch.advance()
    assert all(same(bits(batch, k), before[k]) for k in range(3))
    batch.advance(columns=[0, 2], intervals=20)  # a still deck never ends
    with pytest.raises(ValueError, match="helicopter 0 ends at 3 s"):
        batch.advance(columns=[2, 0])


def test_a_new_table_starts_the_clock_and_forgets_old_commands(tricycle: Helicopter) -> None:
    batch = Batch(tricycle, 2)
    batch.place(0.0, 0.0, 0.0)
    batch.advance([[1.0, 1.0]] * 2)
    batch.set_motion([Fixed().bake(1.0, 0.25)], [0])
    assert batch.time_s.tolist() == [0.0, 0.1]
    batch.advance()
    assert batch.telemetry["claw_vx"][0] == 0.0  # the command in the delay line was of the time before
    assert batch.telemetry["claw_vx"][1] > 0.0


def test_tables_of_different_lengths_live_together(tricycle: Helicopter) -> None:
    """A short table beside a long one, in whatever order they come, is as it is alone."""
    tables = [Sinusoid(dof="roll", amplitude_deg=a, period_s=6.0).bake(s, 0.25) for a, s in ((3.0, 1.0), (5.0, 9.0))]
    alone = Batch(tricycle, 1)
    alone.place(0.0, 0.0, 0.0)
    both, later = alone.fork(2), alone.fork(2)
    alone.set_motion(tables[:1])
    both.set_motion(tables)
    later.set_motion(tables[:1], [0])
    later.set_motion(tables[1:], [1])
    for batch in (alone, both, later):
        batch.advance(intervals=9)
    assert np.array_equal(both.state[:, 0], alone.state[:, 0])
    assert np.array_equal(later.state, both.state)


# --- time and commands -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "command",
    [[[np.nan, 0.0]], [[0.0, np.inf]], [[1.01, 0.0]], [[0.0, -1.5]], [0.0, 0.0], [[0.0]], [[0.0, 0.0], [0.0, 0.0]]],
)
def test_a_bad_command_is_refused_before_anything_moves(tricycle: Helicopter, command: list[list[float]]) -> None:
    batch = Batch(tricycle, 1)
    before = bits(batch, 0)
    with pytest.raises(ValueError, match=r"claw command: must be \(1, 2\) numbers within -1 to 1"):
        batch.advance(command)
    assert same(bits(batch, 0), before)


def test_no_interval_is_refused(tricycle: Helicopter) -> None:
    with pytest.raises(ValueError, match="intervals: must be at least 1, got 0"):
        Batch(tricycle, 1).advance(intervals=0)


def test_a_column_that_is_not_there_is_refused(tricycle: Helicopter) -> None:
    batch = Batch(tricycle, 2)
    with pytest.raises(IndexError):
        batch.advance([[0.0, 0.0]], [2])


@pytest.mark.parametrize("delay", [0.0, 0.06, 0.2])
@pytest.mark.parametrize("k", [2, 3, 7])
def test_intervals_in_one_call_are_as_many_calls(tricycle: Helicopter, delay: float, k: int) -> None:
    """Whatever commands still wait in the delay line, and go on waiting after the call; extremes cover all."""
    one, many = (Batch(tricycle, 3, claw=ClawLimits(delay_s=delay)) for _ in range(2))
    highs, lows = [], []
    for batch in (one, many):
        batch.place(0.0, 0.0, [0.0, 0.05, -0.1])
        rolling(batch)
        batch.advance([[1.0, -1.0]] * 3)
        batch.advance([[-0.3, 0.4]] * 3)
    one.advance([[0.8, 0.6]] * 3, intervals=k)
    for _ in range(k):
        telemetry = many.advance([[0.8, 0.6]] * 3)
        highs.append(telemetry.highs.copy())
        lows.append(telemetry.lows.copy())
    assert np.array_equal(one.state, many.state) and np.array_equal(one.clocks, many.clocks)
    assert np.array_equal(one.telemetry.outputs, many.telemetry.outputs)
    assert np.array_equal(one.telemetry.highs, np.max(highs, axis=0))
    assert np.array_equal(one.telemetry.lows, np.min(lows, axis=0))
    for batch in (one, many):
        batch.advance([[0.0, 0.0]] * 3)
    assert np.array_equal(one.state, many.state)


def test_columns_by_index_or_by_mask(tricycle: Helicopter) -> None:
    batch = Batch(tricycle, 4)
    assert batch.columns(None).tolist() == [0, 1, 2, 3] and batch.columns(2).tolist() == [2]
    assert batch.columns(np.array([False, True, False, True])).tolist() == [1, 3]
    batch.place(0.0, 0.0, 0.0)
    before = batch.state.copy()
    batch.advance(columns=[])
    assert np.array_equal(batch.state, before) and not batch.clocks.any()
    batch.advance(columns=[False, True, False, False])
    assert batch.clocks.tolist() == [0, 50, 0, 0]


def test_no_command_holds_the_claw(tricycle: Helicopter) -> None:
    a, b = Batch(tricycle, 2), Batch(tricycle, 2)
    for batch, command in ((a, None), (b, np.zeros((2, 2)))):
        batch.place(1.0, 0.0, 0.05)
        rolling(batch)
        batch.advance(command, intervals=5)
    assert np.array_equal(a.state, b.state)
    assert np.all(a.telemetry["claw_x"] == 1.0) and a.time_s.tolist() == [0.5, 0.5]


# --- placing and describing some columns -----------------------------------------------------------------------------


@pytest.mark.parametrize("name", HELICOPTERS)
def test_place_puts_the_probe_over_the_claw(name: str) -> None:
    batch = Batch(load_helicopter(name), 4)
    x, y, yaw = np.array([0.0, 2.0, -0.4, 8.0]), np.array([0.1, -0.1, 0.0, 0.3]), np.array([0.0, 0.14, -0.14, 0.5])
    assert np.all(batch.place(x, y, yaw) < 1e-6)
    read = batch.telemetry
    for name_, value in (("probe_x", x), ("probe_y", y), ("claw_x", x), ("claw_y", y), ("yaw", yaw)):
        np.testing.assert_allclose(read[name_], value, rtol=0.0, atol=1e-9)
    assert np.max(read["probe_in_plane"]) < 1e-3
    batch.advance(intervals=20)
    np.testing.assert_allclose(batch.telemetry["yaw"], yaw, rtol=0.0, atol=1e-7)  # and there it stays


def test_place_takes_one_column_of_many_and_leaves_the_bits_of_the_others(tricycle: Helicopter) -> None:
    batch = Batch(tricycle, 5)
    batch.place(0.0, 0.0, np.linspace(-0.1, 0.1, 5))
    rolling(batch)
    batch.advance([[0.5, 0.3]] * 5, intervals=3)
    before = [bits(batch, k) for k in range(5)]
    batch.place(1.0, 0.2, 0.1, [3])
    assert [same(bits(batch, k), before[k]) for k in range(5)] == [True, True, True, False, True]
    fresh = Batch(tricycle, 1)
    fresh.set_motion([Fixed(roll_deg=np.rad2deg(batch.telemetry["deck_roll"][3])).bake(1.0, 0.25)])
    fresh.place(1.0, 0.2, 0.1)
    np.testing.assert_allclose(fresh.state[: State.CLAW_X, 0], batch.state[: State.CLAW_X, 3], atol=1e-9)
    batch.advance(columns=[3])
    assert batch.telemetry["claw_vx"][3] == 0.0  # nothing of the old commands


def test_describe_takes_one_column_of_many_and_leaves_the_bits_of_the_others(tricycle: Helicopter) -> None:
    batch = Batch(tricycle, 3)
    batch.place(0.0, 0.0, 0.0)
    batch.advance([[1.0, 0.0]] * 3, intervals=2)
    before = [bits(batch, k) for k in range(3)]
    light = with_changes(tricycle, {"mass_kg": 8000.0})
    batch.describe([light], [1])
    assert [same(bits(batch, k), before[k]) for k in range(3)] == [True, False, True]
    assert batch.parameters[Par.MASS, 1] == 8000.0 and batch.helicopters[1] is light
    assert batch.time_s.tolist() == [0.2, 0.0, 0.2]
    assert np.array_equal(batch.state[:, 1], droop_state(light))


def test_columns_of_another_batch_can_be_taken(tricycle: Helicopter) -> None:
    source, target = Batch(tricycle, 2), Batch(tricycle, 3)
    for batch in (source, target):
        batch.place(0.0, 0.0, 0.0)
    rolling(source)
    source.advance([[0.5, 0.5]] * 2, intervals=3)
    kept = bits(target, 1)
    target.take(source, [1, 0], [0, 2])
    assert same(bits(target, 1)[:7], kept[:7])
    twin = source.fork(1)
    for batch, columns in ((target, [2, 0]), (twin, [0, 1])):
        batch.advance([[0.1, 0.2]] * 2, columns, intervals=3)
    assert np.array_equal(target.state[:, [2, 0]], twin.state)
    for other in (Batch(tricycle, 1, timing=Timing(0.001)), Batch(tricycle, 1, longest_delay_s=0.5)):
        with pytest.raises(ConfigurationError, match="same timing and longest delay"):
            target.take(other, [0], [0])
    with pytest.raises(ConfigurationError, match="same layout and modes"):
        target.take(Batch(tricycle, 1, modes=Modes(contact="centre")), [0], [0])


# --- claw histories --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("shape", [(2, 4, 9), (1, 1, 9), (1, 4, 6), (4, 9)])
def test_claw_histories_of_another_shape_are_refused(tricycle: Helicopter, shape: tuple[int, ...]) -> None:
    batch = Batch(tricycle, 1)
    with pytest.raises(ConfigurationError, match=r"must be \(1, at least 2, 9\)"):
        batch.prescribe_claw(np.zeros(shape))
    assert batch.mode[Mode.CLAW] == 0


def test_evaluate_reads_the_state_as_it_stands(tricycle: Helicopter) -> None:
    batch = Batch(tricycle, 2)
    batch.place(0.0, 0.0, 0.05)
    rolling(batch)
    batch.advance([[0.5, 0.2]] * 2, intervals=4)
    outputs, state = batch.telemetry.outputs.copy(), batch.state.copy()
    telemetry = batch.evaluate()
    np.testing.assert_allclose(telemetry.outputs, outputs, rtol=1e-12, atol=1e-12)
    assert np.array_equal(telemetry.highs, telemetry.lows)
    assert np.array_equal(batch.state, state) and state.shape == (STATE_ROWS, 2)
    assert telemetry.outputs[Out.DECK_ROLL, 0] != 0.0


def test_what_cannot_be_meant_is_refused(tricycle: Helicopter) -> None:
    with pytest.raises(ConfigurationError, match="prescribe_claw"):
        Batch(tricycle, 1, modes=Modes(claw="prescribed")).advance()
    with pytest.raises(ConfigurationError, match="count"):
        Batch(tricycle, 0)
    with pytest.raises(ConfigurationError, match="count"):
        Batch([tricycle, tricycle], 5)
    with pytest.raises(ValueError, match="twice"):
        Batch(tricycle, 2).advance(columns=[0, 0])
    with pytest.raises(ConfigurationError, match="snapshot"):
        Batch(tricycle, 2).restore(Batch(tricycle, 3).snapshot())


def test_the_last_instant_of_a_table_is_the_tables(tricycle: Helicopter) -> None:
    """The deck at the end of its table is read from the table's end, not from the piece before."""
    table = Sinusoid(dof="roll", amplitude_deg=5.0, period_s=7.0).bake(2.0, 0.25)
    batch = Batch(tricycle, 1)
    batch.set_motion([table])
    batch.place(0.0, 0.0, 0.0)
    read = batch.advance(intervals=20)
    assert read["deck_roll"][0] == pytest.approx(table.nodes[-1, 3], abs=1e-12)


def test_a_forked_process_has_its_own_threads(tricycle: Helicopter) -> None:
    batch = Batch(tricycle, 20, threads=2)
    batch.advance()
    context = multiprocessing.get_context("fork")
    child = context.Process(target=batch.advance)
    child.start()
    child.join(60.0)
    assert child.exitcode == 0
