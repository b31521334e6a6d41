"""Reference integration: the same right-hand side, claw and deck as the engine, by SciPy's solvers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ssmash_gym.dynamics import reference
from ssmash_gym.dynamics.channels import OUTPUT_ROWS, STATION_OUT, STATION_OUT_ROWS, Out, StaOut
from ssmash_gym.dynamics.layout import ODE_ROWS, SPEEDS, STATE_ROWS, STATIONS, Par, State
from ssmash_gym.dynamics.reference import Method, Problem, Reference, integrate
from ssmash_gym.ship import Sinusoid
from ssmash_gym.ship.wind import Gust
from ssmash_gym.simulation.batch import Batch, ClawLimits, Timing
from ssmash_gym.vehicle import load_helicopter
from tests.dynamics.on_deck import brake

COMMANDS = np.array([[0.8, 0.0], [0.8, 0.5], [-0.2, 0.5], [0.0, -1.0], [0.0, 0.0]])


def prepared(name: str = "generic_tricycle", substep: float = 0.002, start_clock: int = 0) -> Batch:
    """Settled on a rolling deck, rippling claw with a delay of 0.03 s."""
    claw = ClawLimits(delay_s=0.03, ripple_along_m=0.001, ripple_across_m=0.0005)
    batch = Batch(load_helicopter(name), 1, timing=Timing(substep, 0.1), claw=claw)
    batch.set_motion([Sinusoid(dof="roll", amplitude_deg=4.0, period_s=7.0).bake(3.0, batch.timing.node_spacing_s)])
    batch.place(0.0, 0.0, 0.05)
    batch.clocks[:] = start_clock
    return batch


def problem(batch: Batch, commands: np.ndarray = COMMANDS) -> Problem:
    timing = batch.timing
    return Problem(
        batch.state[:, 0].copy(), batch.parameters[:, 0].copy(), batch.mode, batch.nodes[0].copy(),
        batch._claw_nodes[0].copy(), commands, timing.substep_s, timing.substeps, timing.substeps_per_node,
        int(batch.clocks[0]),
    )  # fmt: skip


def run(batch: Batch) -> tuple[np.ndarray, np.ndarray]:
    """States and outputs at the ends of the intervals."""
    states, outputs = [], []
    for command in COMMANDS:
        batch.advance(command[None])
        states.append(batch.state[:, 0].copy())
        outputs.append(batch.telemetry.outputs[:, 0].copy())
    return np.array(states).T, np.array(outputs).T


@pytest.mark.parametrize("name", ["generic_tricycle", "seahawk_like"])
def test_the_engine_comes_to_the_reference(name: str) -> None:
    """At 0.25 ms the fixed step is within a millionth; the claw is the same to rounding, ripple and delay included."""
    batch = prepared(name, 0.00025)
    expected = integrate(problem(batch), rtol=1e-8, atol=1e-10)
    states, outputs = run(batch)
    ends = 400 * np.arange(1, 6)
    assert expected.states.shape == (STATE_ROWS, 2001) and expected.outputs.shape == (OUTPUT_ROWS, 2001)
    scale = 1e-3 + np.max(np.abs(expected.states), axis=1)[:, None]
    error = np.abs(states - expected.states[:, ends]) / scale
    assert np.max(error[: State.TIRE]) < 2e-4
    np.testing.assert_allclose(
        states[State.CLAW_X : State.CLAW_VY + 1], expected.states[State.CLAW_X : State.CLAW_VY + 1, ends], atol=1e-13
    )
    claw = slice(int(Out.CLAW_X), int(Out.CLAW_VY) + 1)
    np.testing.assert_allclose(outputs[claw], expected.outputs[claw, ends], rtol=0.0, atol=1e-12)
    assert outputs[Out.PROBE_IN_PLANE] == pytest.approx(expected.outputs[Out.PROBE_IN_PLANE, ends], rel=1e-3)
    assert np.ptp(expected.outputs[Out.PROBE_IN_PLANE]) > 2000.0
    np.testing.assert_allclose(expected.time_s[[0, -1]], [0.0, 0.5], atol=1e-12)


def test_two_solvers_agree() -> None:
    start = problem(prepared())
    a = integrate(start, "DOP853", rtol=1e-8)
    b = integrate(start, "LSODA", rtol=1e-8)
    scale = 1e-3 + np.max(np.abs(a.states[:ODE_ROWS]), axis=1)
    assert np.max(np.abs(a.states - b.states)[:ODE_ROWS, -1] / scale) < 1e-4
    assert max(a.evaluations, b.evaluations) < 30000  # no chatter at the friction limits: half a second, five starts


def test_it_starts_where_its_clock_says() -> None:
    """The deck and the ripple go on from there."""
    early, late = (problem(prepared(start_clock=clock), COMMANDS[:1]) for clock in (0, 400))
    a, b = (integrate(p, rtol=1e-6) for p in (early, late))
    assert a.outputs[Out.DECK_ROLL, 0] == 0.0
    expected = np.deg2rad(4.0) * np.sin(2.0 * np.pi * 0.8 / 7.0)
    assert b.outputs[Out.DECK_ROLL, 0] == pytest.approx(expected, rel=1e-6)
    drive = b.states[State.CLAW_X, 0] + 0.001 * np.sin(2.0 * np.pi * 0.8)
    assert b.outputs[Out.CLAW_X, 0] == pytest.approx(drive, abs=1e-12)


def test_prescribed_claw() -> None:
    batch = prepared()
    batch.set_motion([Sinusoid(dof="roll", amplitude_deg=1e-9, period_s=7.0).bake(3.0, 0.25)])
    times = 0.25 * np.arange(8)
    nodes = np.zeros((1, 8, 9))
    nodes[0, :, 0], nodes[0, :, 3] = 0.1 * times, 0.1
    batch.prescribe_claw(nodes)
    batch.place(0.0, 0.0, 0.0)
    batch.state[State.U7] = 0.1
    expected = integrate(problem(batch), rtol=1e-7)
    states, _ = run(batch)
    ends = 50 * np.arange(1, 6)
    np.testing.assert_allclose(expected.outputs[Out.CLAW_X, ends], 0.01 * np.arange(1, 6), atol=1e-12)
    np.testing.assert_allclose(states[State.Q8], expected.states[State.Q8, ends], atol=1e-5)
    assert states[State.Q8, -1] > states[State.Q8, 0] + 0.03


def test_without_a_moving_claw_there_is_nothing_to_stop_at() -> None:
    still = problem(prepared(), np.zeros((5, 2)))
    assert reference._segments(still) == [0, 250]
    assert reference._segments(problem(prepared())) == [0, 50, 100, 150, 200, 250]


# --- every method -----------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def drop() -> Problem:
    """The generic tricycle of section 3.2.1, wheels and steering locked, let fall from 2.7 m; 3 s."""
    batch = Batch(load_helicopter("generic_tricycle"), 1)
    batch.parameters[Par.PROBE_ACTIVE] = 0.0
    brake(batch)
    batch.parameters[[Par.LOCK + State.U14 + 2 * i for i in range(STATIONS)]] = 1.0
    batch.state[State.Q10] = -2.7
    return problem(batch, np.zeros((30, 2)))


def largest(found: Reference) -> np.ndarray:
    """Peaks of the tire loads, the compressions and the pitch."""
    stations = [STATION_OUT + i * STATION_OUT_ROWS for i in range(STATIONS)]
    rows = [base + row for base in stations for row in (StaOut.VERTICAL_LOAD, StaOut.COMPRESSION)]
    return np.max(np.abs(found.outputs[[*rows, Out.PITCH]]), axis=1)


@pytest.fixture(scope="module")
def expected(drop: Problem) -> Reference:
    return integrate(drop, "DOP853", rtol=1e-8, atol=1e-9)


@pytest.mark.parametrize("method", ["Adams", "Gear", "LSODA", "RK45"])
def test_every_method_finds_the_same_drop(method: Method, drop: Problem, expected: Reference) -> None:
    done: list[float] = []
    found = integrate(drop, method, rtol=1e-6, atol=1e-8, progress=done.append)
    np.testing.assert_allclose(largest(found), largest(expected), rtol=1e-3)
    assert np.min(largest(expected)[:6]) > 0.3 and largest(expected)[-1] > 0.01
    assert 1000 < found.evaluations < 50_000
    assert done == sorted(done) and len(done) > 20
    assert done[0] > 0.0 and done[-1] == 1.0


@pytest.mark.parametrize("method", ["DOP853", "Adams", "Gear", "LSODA"])
def test_no_step_is_longer_than_it_may_be(method: Method) -> None:
    """As one rigid body high in the air: nothing but `max_step` holds a solver back."""
    batch = prepared()
    batch.parameters[Par.LOCK + State.U13 : Par.LOCK + SPEEDS] = 1.0
    batch.state[State.TIRE : State.CLAW_X] = 0.0
    batch.parameters[Par.PROBE_ACTIVE] = 0.0
    batch.state[State.Q10] -= 100.0
    fall = problem(batch, np.zeros((5, 2)))
    free, bounded = (integrate(fall, method, rtol=1e-5, max_step=longest) for longest in (None, 0.001))
    assert free.evaluations < 450 < bounded.evaluations
    np.testing.assert_allclose(bounded.states[State.Q10], free.states[State.Q10], rtol=1e-5)


@pytest.mark.parametrize("method", ["DOP853", "LSODA", "RK45", "Radau", "BDF", "Adams", "Gear"])
def test_a_solver_that_gets_nowhere_is_stopped(method: Method, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reference, "SPARE_EVALUATIONS", 40)
    monkeypatch.setattr(reference, "EVALUATIONS_PER_S", 0)
    with pytest.raises(RuntimeError, match=rf"^{method} gave up at t = 0[.0-9e-]* s: 40 right-hand sides are used up$"):
        integrate(problem(prepared(), COMMANDS[:1]), method)


@pytest.mark.parametrize("method", ["DOP853", "LSODA", "RK45", "Radau", "BDF", "Adams", "Gear"])
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_numbers_that_are_none_end_a_run(method: Method) -> None:
    broken = problem(prepared(), np.zeros((1, 2)))
    broken.parameters[Par.MASS] = np.nan
    with pytest.raises(RuntimeError, match=rf"^{method} gave up (at|by) t = "):
        integrate(broken, method)


@pytest.mark.parametrize("method", ["Adams", "Gear"])
def test_a_multistep_solver_tells_why_it_gives_up(method: Method, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reference, "MOST_STEPS", 2)
    with pytest.raises(RuntimeError, match=rf"^{method} gave up at t = 0 s: vode: Excess work done"):
        integrate(problem(prepared(), COMMANDS[:1]), method)


def test_what_is_locked_stays() -> None:
    batch = prepared()
    batch.parameters[Par.LOCK : Par.LOCK + SPEEDS] = 1.0
    got = integrate(problem(batch, COMMANDS[:2]), rtol=1e-6)
    assert np.array_equal(got.states[: State.TIRE], np.repeat(got.states[: State.TIRE, :1], 101, axis=1))


def test_the_reference_meets_the_same_gust() -> None:
    batch = prepared("generic_tricycle", 0.001, start_clock=400)
    batch.parameters[Par.WIND + 1], batch.parameters[Par.GUST + 1] = 8.0, 1.0
    gust = Gust.draw(20.0, 0.25, np.random.default_rng(4))
    batch.set_gusts([gust.bake(3.0, batch.timing.node_spacing_s)])
    given = problem(batch, np.zeros((5, 2)))
    calm = integrate(given, rtol=1e-7, atol=1e-9)
    expected = integrate(replace(given, gust_nodes=batch.gust_nodes[0].copy()), rtol=1e-7, atol=1e-9)
    rows = []
    for k in range(5):
        batch.advance()
        rows.append((batch.telemetry["wind_fy"][0], expected.outputs[Out.WIND_FY, 100 * (k + 1)]))
    engine, reference = np.array(rows).T
    np.testing.assert_allclose(engine, reference, rtol=1e-4)
    assert np.ptp(reference) > 0.3 * np.mean(reference)
    assert np.max(np.abs(calm.outputs[Out.WIND_FY] / calm.outputs[Out.WIND_FY, 0] - 1.0)) < 0.1
