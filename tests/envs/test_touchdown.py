"""Being set down: contact, velocities and attitude relative to the moving deck at the first instant."""

from __future__ import annotations

import numpy as np

from ssmash_gym.dynamics.layout import Deck, State
from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.simulation.parameters import rotation

TASK = {"wheels": "braked", "horizon_s": 3.0, "substep_s": 0.001, "lead_in": {"duration_s": 4.0, "ramp_s": 4.0}}
SEA = {"base": "ss4", "motion": {"heading_deg": 80.0, "speed_kn": 5.0}, "start": {"sink_rate_m_s": 1.2}}


def test_it_is_level_with_the_horizon_and_sinks_at_the_drawn_rate() -> None:
    core = TraverseBatch(6, task=TASK, scenario=SEA)
    core.reset(seeds=list(range(6)))
    deck = core.batch.deck_rows(np.arange(6))
    for k in range(6):
        state, R_NS = core.batch.state[:, k], deck[Deck.R_NS : Deck.R_NS + 9, k].reshape(3, 3)
        R_SH = rotation(tuple(state[State.Q11 : State.Q14 + 1]))
        R_NH = R_NS @ R_SH
        for vector in (R_NH[2], R_NH[:, 2]):
            assert np.allclose(vector, [0.0, 0.0, 1.0], atol=1e-12)
        w_NS_S, r_SH_S = deck[Deck.W_NS_S : Deck.W_NS_S + 3, k], state[State.Q8 : State.Q10 + 1]
        v_H_N = deck[Deck.V_NS_N : Deck.V_NS_N + 3, k] + R_NS @ (
            state[State.U7 : State.U9 + 1] + np.cross(w_NS_S, r_SH_S)
        )
        assert np.allclose(v_H_N, [0.0, 0.0, 1.2], atol=1e-12)
        assert np.allclose(state[State.U10 : State.U12 + 1] + R_SH.T @ w_NS_S, 0.0, atol=1e-12)
    told = core.telemetry
    deflection = [told[f"{name}_tire_vertical_deflection_largest"] for name in ("auxiliary", "right", "left")]
    assert np.all(np.max(deflection, axis=0) < 1e-9)  # no tire is in the deck
    core.step(np.zeros((6, 2)))
    loads = [core.telemetry.peak_max(f"{name}_vertical_load") for name in ("auxiliary", "right", "left")]
    assert np.all(np.max(loads, axis=0) > 1e3)  # and the lowest one is on it at once


def test_the_probe_stays_free_and_an_ordinary_start_follows() -> None:
    core = TraverseBatch(2, task=TASK, scenario=SEA)
    core.reset(seeds=[1, 2])
    while not core.book.over.all():
        running = np.flatnonzero(~core.book.over)
        core.step(np.zeros((running.size, 2)), running)
    assert np.all(core.book.peak_probe_no_grace_N == 0.0)
    core.change(scenario={"start": {"sink_rate_m_s": None}})
    core.reset(seeds=[1, 2])
    plain = TraverseBatch(2, task=TASK, scenario={**SEA, "start": {"sink_rate_m_s": None}})
    plain.reset(seeds=[1, 2])
    assert np.array_equal(core.batch.state, plain.batch.state) and np.all(core.telemetry["probe_captured"] == 1.0)
