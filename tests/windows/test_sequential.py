"""The confidence sequence: exact coverage whenever one stops, decisions, and what is refused."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from scipy.stats import binom

from ssmash_gym.windows.sequential import BEYOND, UNDECIDED, WITHIN, bounds, fewest, log_bet_greater, log_bet_smaller

TOOL = Path(__file__).resolve().parents[2] / "tools" / "window_calibration.py"


@pytest.mark.parametrize("bet", [log_bet_smaller, log_bet_greater])
@pytest.mark.parametrize("p", [0.02, 0.1, 0.5, 0.93])
def test_the_bets_are_fair(bet: Callable[..., np.ndarray], p: float) -> None:
    """Under p the expected bet is 1 after any number of episodes: Ville's inequality rests on that and nothing else."""
    for n in (1, 7, 60):
        hits = np.arange(n + 1)
        assert np.sum(binom.pmf(hits, n, p) * np.exp(bet(p, hits, n))) == pytest.approx(1.0, abs=1e-9)


def test_the_interval_holds_the_share_after_every_episode_at_once() -> None:
    """Somebody looks after each of 400 episodes and stops when it suits him: still at most 5 % misses."""
    rng = np.random.default_rng(1)
    n = np.arange(1, 401)
    for p in (0.03, 0.1, 0.4):
        hits = np.cumsum(rng.random((1000, 400)) < p, axis=1)
        found = bounds(hits, np.broadcast_to(n, hits.shape))
        missed = np.any((found.low > p) | (found.high < p), axis=1)
        assert np.mean(missed) < 0.05
        fixed_width = np.abs(hits / n - p) > 1.96 * np.sqrt(p * (1 - p) / n)
        assert np.mean(np.any(fixed_width[:, 20:], axis=1)) > 0.15  # what repeated intervals of fixed size would miss


def test_bounds_enclose_the_share_and_tighten() -> None:
    n = np.array([0, 20, 40, 400, 4000])
    found = bounds(np.round(0.25 * n), n)
    assert found.low[0] == 0.0 and found.high[0] == 1.0
    assert np.all(np.diff(found.low) > 0.0) and np.all(np.diff(found.high) < 0.0)
    assert np.all((found.low <= 0.25) & (found.high >= 0.25))
    assert found.high[-1] - found.low[-1] < 0.06
    none, all_of_them = bounds(0, 50), bounds(50, 50)
    assert float(none.low) == 0.0 and float(all_of_them.high) == 1.0


def test_forty_quiet_episodes_are_within_ten_percent_and_a_few_loud_ones_beyond() -> None:
    assert bounds([0, 0, 7, 1], [38, 40, 10, 20]).verdicts(0.1).tolist() == [UNDECIDED, WITHIN, BEYOND, UNDECIDED]
    assert bounds(0, 40, 0.999).verdicts(0.1) == UNDECIDED  # more confidence takes more


def test_the_fewest_quiet_episodes_are_the_first_that_show_it() -> None:
    for acceptance, level in ((0.5, 0.95), (0.1, 0.95), (0.1, 0.99), (0.001, 0.95)):
        n = fewest(acceptance, level)
        assert bounds([0, 0], [n - 1, n], level).verdicts(acceptance).tolist() == [UNDECIDED, WITHIN]


@pytest.mark.parametrize(("hits", "episodes", "level"), [(3, 2, 0.95), (-1, 2, 0.95), (1, 2, 1.0)])
def test_no_share_is_refused(hits: int, episodes: int, level: float) -> None:
    with pytest.raises(ValueError, match="no share"):
        bounds(hits, episodes, level)


@pytest.fixture(scope="module")
def calibration() -> ModuleType:
    spec = importlib.util.spec_from_file_location("window_calibration", TOOL)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    import sys

    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def test_the_rule_of_a_window_keeps_its_promise_on_synthetic_cells(calibration: ModuleType) -> None:
    config = calibration.window(20, 20, 100)
    rng = np.random.default_rng(0)
    for p in (0.0, 0.05, 0.1, 0.15, 0.3):
        found = calibration.calibrated(config, p, 1500, rng)
        assert found.always > 0.95 and found.wrong < 0.05
    assert calibration.calibrated(config, 0.0, 50, rng).episodes == 40  # instead of 100
    assert calibration.calibrated(config, 0.9, 200, rng).undecided == 0.0
