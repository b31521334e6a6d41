"""The right-hand side has no size of its own but that of a few constants: with those scaled, it is exactly similar."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from numpy.typing import NDArray

from ssmash_gym.cases import Case, History, prepared
from ssmash_gym.dynamics import system, tire
from ssmash_gym.dynamics.channels import OUTPUT_ROWS, Out
from ssmash_gym.dynamics.lane import uncompiled
from ssmash_gym.dynamics.layout import DECK_ROWS, ODE_ROWS, WORK_ROWS, Deck, Par
from ssmash_gym.systems.models import output_exponents, scaled_case, state_exponents

Array = NDArray[np.float64]
SCALE = 0.1
# Constants of the tire kernel that have a unit, and the power of the length scale that it asks for.
SIZED = {"TOUCH_LOAD": 3.0, "EPS_SPEED": 0.5, "EPS_SIDE": 0.5, "FASTEST": -0.5}


@pytest.fixture
def fresh() -> Iterator[None]:
    """Plain Python of the kernels made anew before and after: it keeps the constants that it was made with."""
    uncompiled.cache_clear()
    yield
    uncompiled.cache_clear()


def deck_exponents() -> Array:
    powers = np.zeros(DECK_ROWS)
    for row, power in ((Deck.W_NS_S, -0.5), (Deck.WDOT_NS_S, -1.0), (Deck.V_NS_N, 0.5), (Deck.C_CLAW_S, 1.0),
                       (Deck.V_CLAW_S, 0.5), (Deck.WIND, 0.5)):  # fmt: skip
        powers[row : row + 3] = power
    return powers


def samples(case: Case, history: History) -> tuple[Array, Array, Array, NDArray[np.int64]]:
    """States, deck rows and parameters at some instants of a run, one column each; and the modes."""
    batch = prepared(case)
    columns = np.arange(100, history.time_s.size, 250)
    decks = np.zeros((DECK_ROWS, columns.size))
    for k, row in enumerate(columns):
        batch.clocks[0] = round(history.time_s[row] / batch.timing.substep_s)
        decks[:, k] = batch.deck_rows(np.arange(1))[:, 0]
    parameters = np.repeat(batch.parameters, columns.size, axis=1)
    parameters[Par.GUST : Par.GUST + 3] = 0.0
    return history.states[:, columns], decks, parameters, batch.mode


def right_hand_side(state: Array, decks: Array, parameters: Array, mode: NDArray[np.int64]) -> tuple[Array, Array]:
    """Rates and outputs by the uncompiled kernel."""
    width = state.shape[1]
    rates, outputs, work = (np.zeros((rows, width)) for rows in (ODE_ROWS, OUTPUT_ROWS, WORK_ROWS))
    uncompiled(system.rates)(state, parameters, decks, mode, rates, rates, outputs, work, 0.0, 0)
    return rates, outputs


def largest_difference(model: Array, full: Array, powers: Array) -> float:
    """Largest difference of rows told at full scale, over the largest value of each row's unit."""
    told = model * SCALE ** -powers[:, None]
    size = np.array([max(np.max(np.abs(full[powers == power])), 1e-9) for power in powers])
    return float(np.max(np.abs(told - full) / size[:, None]))


def both(case: Case, history: History, monkeypatch: pytest.MonkeyPatch | None) -> float:
    """Difference of the right-hand sides of a case and its model; the kernel's constants scaled if asked for."""
    state, decks, parameters, mode = samples(case, history)
    rates, _ = right_hand_side(state, decks, parameters, mode)
    if monkeypatch is not None:
        for name, power in SIZED.items():
            monkeypatch.setattr(tire, name, getattr(tire, name) * SCALE**power)
        uncompiled.cache_clear()
    powers = state_exponents(case.vehicle)
    model_parameters = np.repeat(prepared(scaled_case(case, SCALE)).parameters, state.shape[1], axis=1)
    small = right_hand_side(
        state * SCALE ** powers[:, None], decks * SCALE ** deck_exponents()[:, None], model_parameters, mode
    )
    return largest_difference(small[0], rates, powers[:ODE_ROWS] - 0.5)


@pytest.mark.usefixtures("fresh")
def test_with_the_constants_scaled_the_model_is_exactly_similar(
    rolling_traverse: Case, runs: dict[str, History], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A traverse on a rolling deck, at a dozen instants: rates to rounding."""
    assert both(rolling_traverse, runs["ssmash"], monkeypatch) < 1e-9


@pytest.mark.usefixtures("fresh")
def test_without_that_it_is_not(rolling_traverse: Case, runs: dict[str, History]) -> None:
    assert both(rolling_traverse, runs["ssmash"], None) > 1e-6


def test_every_output_has_a_scale() -> None:
    powers = output_exponents()
    assert powers.shape == (OUTPUT_ROWS,)
    assert powers[Out.PROBE_IN_PLANE] == 3.0 and powers[Out.ROLL] == 0.0 and powers[Out.DECK_WX] == -0.5
