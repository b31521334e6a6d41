"""The next quiet window, on decks whose windows are known."""

from __future__ import annotations

import numpy as np
import pytest

from ssmash_gym.monitor.quiet import next_quiet


def use(*windows: tuple[float, float], duration_s: float = 45.0) -> np.ndarray:
    """A future that is quiet within the given times."""
    time = 0.25 * np.arange(round(duration_s / 0.25) + 1)
    inside = np.any([(time >= a) & (time <= b) for a, b in windows], axis=0) if windows else np.zeros(time.shape, bool)
    return np.where(inside, 0.5, 1.5)


def test_the_first_window_that_lasts_long_enough_is_told() -> None:
    found = next_quiet(np.stack([use((2.0, 6.0), (10.0, 20.0))] * 4), 0.5)
    assert found is not None
    assert (found.in_s, found.length_s, found.share) == pytest.approx((10.0, 10.0, 1.0))


def test_enough_futures_must_agree_and_those_that_do_give_the_length() -> None:
    futures = np.stack([use((10.0, 20.0)), use((10.0, 18.0)), use(), use((30.0, 44.0))])
    assert next_quiet(futures, 0.75) is None
    found = next_quiet(futures, 0.5)
    assert found is not None
    assert (found.in_s, found.length_s, found.share) == pytest.approx((10.0, 9.0, 0.5))


def test_a_deck_that_is_always_quiet_or_never() -> None:
    found = next_quiet(np.zeros((3, 181)), 1.0)
    assert found is not None
    assert (found.in_s, found.length_s) == (0.0, 45.0)
    assert next_quiet(np.full((3, 181), 2.0), 0.1) is None
