"""Planning: the law, rehearsals that are the simulation, forecasts that know the past alone, and the two searches."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from ssmash_gym.agents.planning_forecast import ArForecast, TrueFuture
from ssmash_gym.agents.planning_law import Drive, Law, Seen
from ssmash_gym.agents.planning_linear import LinearSearch, LinearSteps
from ssmash_gym.agents.planning_rehearsal import Outcome, Rehearsal, seen_of
from ssmash_gym.agents.planning_search import Cost, Span, noise, weights

from ssmash_gym.dynamics.layout import Par
from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.envs.task import load_task
from ssmash_gym.errors import ConfigurationError

TASK = load_task("traverse")
LAW = Law()
ROWS = np.arange(2)


def running(steps: int = 13, n: int = 2, scenario: Any = "ss5") -> TraverseBatch:
    """A batch some intervals after its start, under commands that change all the time."""
    core = TraverseBatch(n, scenario=scenario)
    core.reset(seeds=list(range(50, 50 + n)))
    for k in range(steps):
        core.step(np.tile([0.5 + 0.4 * np.sin(k), 0.3 * np.cos(2.0 * k)], (n, 1)))
    return core


def outcome(load_kN: Any, **others: Any) -> Outcome:
    """An outcome of one helicopter from loads (intervals, copies) in kN along x; other channels are 0 unless given."""
    load = 1e3 * np.asarray(load_kN, dtype=np.float64)[..., None]
    zero = {name: np.zeros_like(load) for name in Outcome.__dataclass_fields__}
    return Outcome(**{**zero, "load_N": np.abs(load), "force_x_N": load, **others})


def test_the_schedule_is_a_trapezoid_that_arrives_in_time() -> None:
    drive = Drive(TASK, LAW)
    time = np.arange(0.0, 60.0, 0.1)
    place = drive.place(time)
    assert place[0] == 0.0
    assert drive.place(np.array([LAW.arrival_s]))[0] == pytest.approx(8.0)
    assert np.all(place[time > LAW.arrival_s] == pytest.approx(8.0))
    assert np.max(np.abs(np.diff(place, 2))) / 0.01 <= LAW.acceleration_m_s2 * (1.0 + 1e-6)
    with pytest.raises(ConfigurationError, match="arrival_s"):
        Drive(TASK, replace(LAW, arrival_s=15.0))


def test_the_law_yields_centres_straightens_follows_and_takes_the_plan_on_top() -> None:
    drive = Drive(TASK, LAW)
    values = {"force_N": 1e3, "yaw_rad": 0.02, "claw_x_m": -0.05, "claw_y_m": 0.03}
    rest = dict.fromkeys(values, 0.0)
    cases = [rest, *({**rest, name: value} for name, value in values.items())]
    seen = Seen(**{name: np.array([case[name] for case in cases]) for name in values})
    steps, plan = np.zeros(5, np.int64), np.array([0.02, -0.01])
    speed = drive.commands(seen, steps, np.zeros((5, 2))) * [0.3, 0.1]
    change = speed[1:] - speed[0]
    expected = [
        [0.0, -LAW.yielding_m_s_per_N * 1e3],
        [0.0, -LAW.straightening_m_s_per_rad * 0.02],
        [LAW.following_per_s * 0.05, 0.0],
        [0.0, -LAW.centring_per_s * 0.03],
    ]
    np.testing.assert_allclose(change, expected, atol=1e-12)
    planned = drive.commands(seen, steps, np.tile(plan, (5, 1))) * [0.3, 0.1]
    np.testing.assert_allclose(planned - speed, np.tile(plan, (5, 1)), atol=1e-12)


def test_a_plan_is_linear_between_its_knots() -> None:
    drive = Drive(TASK, LAW)
    plans = np.zeros((1, LAW.knots(TASK), 2))
    plans[0, 3] = [0.1, -0.05]
    told = np.array([drive.planned(plans, np.array([k]))[0] for k in range(TASK.horizon_steps)])
    middle = (np.arange(TASK.horizon_steps) + 0.5) * TASK.control_interval_s
    expected = np.maximum(1.0 - np.abs(middle / LAW.spacing_s - 3.0), 0.0)[:, None] * [0.1, -0.05]
    np.testing.assert_allclose(told, expected, atol=1e-12)


def test_a_rehearsal_on_the_true_future_is_what_then_happens() -> None:
    core, drive = running(), Drive(TASK, LAW)
    plans = 0.01 * noise((1,), 2, LAW.knots(TASK))
    steps = np.full(2, 13)
    future = TrueFuture(core, 3.0)
    found = Rehearsal(core, drive, TASK.substep_s).run(ROWS, *future.nodes(ROWS), plans[None], steps, 25)
    coarse = Rehearsal(core, drive, 0.005).run(ROWS, *future.nodes(ROWS), plans[None], steps, 25)
    load, yaw, lag = [], [], []
    for k in range(25):
        now = steps + k
        core.batch.advance(drive.commands(seen_of(core.batch), now, drive.planned(plans, now)))
        load.append(core.telemetry.peak_max("probe_in_plane"))
        yaw.append(core.telemetry["yaw"])
        lag.append(drive.place((now + 1) * 0.1) - seen_of(core.batch).claw_x_m)
    np.testing.assert_allclose(found.load_N[:, 0], load, rtol=1e-7)
    np.testing.assert_allclose(found.yaw_rad[:, 0], yaw, atol=1e-10)
    np.testing.assert_allclose(found.lag_m[:, 0], lag, atol=1e-12)
    np.testing.assert_allclose(coarse.load_N.max(axis=0)[0], np.max(load, axis=0), rtol=0.01)


def test_a_rehearsal_changes_nothing_and_copies_do_not_depend_on_each_other() -> None:
    core, drive = running(), Drive(TASK, LAW)
    before = core.snapshot()
    plans = 0.01 * noise((2,), 5, LAW.knots(TASK))
    args = (*TrueFuture(core, 1.0).nodes(ROWS), np.repeat(plans[:, None], 2, axis=1), np.full(2, 13), 6)
    together = Rehearsal(core, drive, 0.005).run(ROWS, *args)
    alone = Rehearsal(core, drive, 0.005).run(
        ROWS[1:], *(nodes[1:] for nodes in args[:2]), np.ascontiguousarray(args[2][3:4, 1:]), args[3][1:], 6
    )
    np.testing.assert_array_equal(together.load_N[:, 3, 1], alone.load_N[:, 0, 0])
    for name, array in before.physics.arrays.items():
        np.testing.assert_array_equal(core.snapshot().physics.arrays[name], array, err_msg=name)


def test_rehearsals_with_nominal_parameters_do_not_know_what_was_drawn() -> None:
    scenario = {"base": "ss5", "helicopter": {"mass_factor": 1.15}}
    core, drive = running(scenario=scenario), Drive(TASK, LAW)
    plain = TraverseBatch(1, scenario="ss5").starter.batch(1, 1).parameters[Par.MASS, 0]
    assert core.batch.parameters[Par.MASS, 0] == pytest.approx(1.15 * plain)
    args = (*TrueFuture(core, 2.0).nodes(ROWS), np.zeros((1, 2, LAW.knots(TASK), 2)), np.full(2, 13), 15)
    own = Rehearsal(core, drive, 0.005).run(ROWS, *args)
    nominal = Rehearsal(core, drive, 0.005, nominal=True)
    assert not np.allclose(nominal.run(ROWS, *args).load_N, own.load_N, rtol=0.01)
    assert core.batch.parameters[Par.MASS, 0] == pytest.approx(1.15 * plain)


def test_a_forecast_knows_the_past_alone_and_is_good_for_a_second() -> None:
    core = TraverseBatch(2, scenario="ss5")
    core.reset(seeds=[60, 61])
    forecast = ArForecast(core, 4.0)
    forecast.begin(ROWS)
    core.batch.advance(None, intervals=20)
    told, gusts = forecast.nodes(ROWS)
    true, true_gusts = TrueFuture(core, 4.0).nodes(ROWS)
    np.testing.assert_array_equal(told[:, 0], true[:, 0])
    np.testing.assert_allclose(gusts[:, 0, 0], true_gusts[:, 0, 0])
    spread = core.batch.nodes[:, 32:].std(axis=1)
    error = np.abs(told - true)[:, 4] / spread  # a second ahead
    assert np.max(error[:, [3, 13, 14]]) < 0.3  # roll, sway and heave acceleration
    passed = 40
    core.batch.nodes[:, passed + 1 :] = 7.0
    core.batch.gust_nodes[:, passed + 1 :] = 7.0
    again, gusts_again = forecast.nodes(ROWS)
    np.testing.assert_array_equal(again, told)
    np.testing.assert_array_equal(gusts_again, gusts)


def test_a_forecast_is_one_motion_and_goes_to_the_mean() -> None:
    core = TraverseBatch(1, scenario="ss5")
    core.reset(seeds=[62])
    forecast = ArForecast(core, 30.0)
    forecast.begin(ROWS[:1])
    nodes = forecast.nodes(ROWS[:1])[0][0]
    h = core.batch.timing.node_spacing_s
    for channel in range(6):
        x, v, a = nodes[:, channel], nodes[:, 6 + channel], nodes[:, 12 + channel]
        scale = np.abs(np.diff(x)).max()
        np.testing.assert_allclose(np.diff(x), h * (v[1:] + v[:-1]) / 2 - h * h * np.diff(a) / 12, atol=0.02 * scale)
    assert np.abs(nodes[-20:, 3]).max() < np.abs(core.batch.nodes[0, 32:, 3]).max()


def test_misses_count_at_the_goal_and_more_is_allowed_before() -> None:
    drive, cost = Drive(TASK, LAW), Cost()
    last = Span(drive, cost, 440, 35)
    early = Span(drive, cost, 300, 50)
    np.testing.assert_allclose(last.tolerances[-1], [np.deg2rad(1.0), 0.05, 0.05])
    assert np.all(last.time_s[last.judged] > LAW.arrival_s)
    assert np.all(early.tolerances[-1] > last.tolerances[-1])
    load = np.full((35, 1), 2.0)
    straight = outcome(load)
    crooked = outcome(load, yaw_rad=np.full((35, 1, 1), np.deg2rad(1.6)))
    assert last.total_kN(straight)[0, 0] == pytest.approx(2.0)
    assert last.total_kN(crooked)[0, 0] == pytest.approx(2.0 + cost.missed_kN * (1.6 - cost.margin))


def test_the_grace_does_not_count() -> None:
    span = Span(Drive(TASK, LAW), Cost(), 0, 30)
    load = np.full((30, 1), 2.0)
    load[:10] = 9.0
    assert span.total_kN(outcome(load))[0, 0] == pytest.approx(2.0)


def test_weights_sum_up_to_one_and_favour_the_cheap() -> None:
    share = weights(np.array([[3.0, 1.0], [1.0, 1.0], [2.0, 1.0]]), 10.0)
    np.testing.assert_allclose(share.sum(axis=0), 1.0)
    assert share[1, 0] > 0.9 > 0.1 > share[2, 0] > share[0, 0]
    np.testing.assert_allclose(share[:, 1], 1.0 / 3.0)


def test_the_linear_search_finds_the_least_peak_of_a_linear_world() -> None:
    drive = Drive(TASK, LAW)
    span = Span(drive, Cost(), 100, 60)
    search = LinearSteps(LinearSearch(samples=48, ridge=0.01), span)
    base = 6.0 * np.sin(span.time_s)[:, None]
    spread = 0.012

    def world(changes: np.ndarray) -> Outcome:
        """A force that each knot pushes for a second; it could be cancelled between the knots but for their shape."""
        pushed = np.array([np.interp(span.time_s, span.knot_s, change[:, 0]) for change in changes]).T
        return outcome(base + 1.5 * pushed / spread)

    proposals = search.proposals(world(search.samples(noise((3,), 48, span.knots.size))))
    peaks = np.abs(world(proposals[:, 0]).force_x_N).max(axis=(0, 2)) * 1e-3
    assert peaks.min() < 0.35 * 6.0
    assert np.all(peaks < 6.0)


def test_noise_is_the_same_whenever_it_is_asked_for() -> None:
    np.testing.assert_array_equal(noise((1, 2), 3, 4), noise((1, 2), 3, 4))
    assert np.any(noise((1, 2), 3, 4) != noise((1, 3), 3, 4))
