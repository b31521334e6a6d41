"""A patch of other friction on the deck: its shape, and what it does to tires that stand, slide and roll on it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from ssmash_gym.dynamics.lane import WIDTH, kernel, load, store, uncompiled
from ssmash_gym.dynamics.layout import PARAMETER_ROWS, STATIONS, TIRE_PAR, TIRE_ROWS, Mode, Par, State, Tir
from ssmash_gym.dynamics.patch import patch_factor
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.ship import Fixed
from ssmash_gym.simulation.batch import Batch
from ssmash_gym.vehicle import load_helicopter
from tests.dynamics.on_deck import PROMPT, WHEELS, brake, loads

HELICOPTERS = ("generic_tricycle", "seahawk_like")
WIDE = ((-50.0, 50.0), (-50.0, 50.0))
TABLES = ("state", "_outputs", "_highs", "_lows")


def block(factor: float = 0.3, edge: float = 0.02) -> np.ndarray:
    p = np.zeros((PARAMETER_ROWS, 1))
    p[Par.PATCH_X_MIN : Par.PATCH_Y_MAX + 1, 0] = 1.0, 2.0, -0.5, 0.5
    p[Par.PATCH_LOSS], p[Par.PATCH_EDGE] = 1.0 - factor, edge
    return p


def factor(x: Any, y: Any, p: np.ndarray | None = None) -> np.ndarray:
    x, y = np.broadcast_arrays(np.atleast_1d(np.asarray(x, dtype=float)), np.asarray(y, dtype=float))
    return np.asarray(uncompiled(patch_factor)(block() if p is None else p, x, y))


# --- shape ---------------------------------------------------------------------------------------------------------


def test_one_outside_the_factor_inside_and_half_way_on_the_middle_of_an_edge() -> None:
    assert np.all(factor([0.9, 1.0, 2.0, 2.1, 1.5, 1.5, 0.0], [0.0, 0.0, 0.0, 0.0, 0.5, -0.6, 9.0]) == 1.0)
    np.testing.assert_allclose(factor([1.02, 1.5, 1.98], [0.0, 0.48, -0.48]), 0.3, rtol=1e-12)
    np.testing.assert_allclose(factor([1.01, 1.99, 1.5, 1.5], [0.0, 0.0, 0.49, -0.49]), 0.65, rtol=1e-9)
    corner = factor(1.01, 0.49)[0]
    assert corner == pytest.approx(1.0 - 0.7 * 0.25, rel=1e-9)
    np.testing.assert_allclose(factor([1.5, 1.01], 0.0, block(1.6)), [1.6, 1.3], rtol=1e-12)


def test_across_an_edge_the_factor_changes_smoothly_and_one_way() -> None:
    x = np.linspace(0.99, 1.03, 4001)
    for values in (factor(x, 0.0), factor(1.5, x - 1.5)):
        slope = np.diff(values) / (x[1] - x[0])
        assert np.all(np.diff(values) <= 0.0)
        assert np.max(np.abs(np.diff(slope))) < 0.01 * np.max(np.abs(slope))
        assert np.max(np.abs(slope)) == pytest.approx(1.5 * 0.7 / 0.02, rel=1e-3)


def test_rows_of_zeros_are_no_patch() -> None:
    assert np.all(factor([-1.0, 0.0, 1.0], 0.0, np.zeros((PARAMETER_ROWS, 1))) == 1.0)


@kernel
def patch_driver(p, y, out):
    store(out, 0, patch_factor(p, load(y, 0), load(y, 1)))


def test_lanes_give_the_bits_of_numpy() -> None:
    rng = np.random.default_rng(5)
    p = np.ascontiguousarray(np.broadcast_to(block(), (PARAMETER_ROWS, WIDTH)))
    for _ in range(200):
        y = np.array([rng.uniform(0.95, 2.05, WIDTH), rng.uniform(-0.55, 0.55, WIDTH)])
        lanes, plain = np.zeros((1, WIDTH)), np.zeros((1, WIDTH))
        patch_driver(p, y, lanes)
        uncompiled(patch_driver)(p, y, plain)
        assert lanes.tobytes() == plain.tobytes()


# --- on the deck ---------------------------------------------------------------------------------------------------


def driven(batch: Batch, intervals: int = 12) -> list[np.ndarray]:
    batch.place(0.0, 0.0, 0.05)
    brake(batch, (1, 2))
    for k in range(intervals):
        batch.advance([[0.5, 1.0 if k < 6 else -1.0]] * batch.n)
    return [getattr(batch, name).copy() for name in TABLES]


@pytest.mark.parametrize("name", HELICOPTERS)
def test_a_patch_elsewhere_or_of_the_same_friction_changes_no_bit(name: str) -> None:
    plain = driven(Batch(load_helicopter(name), 1, claw=PROMPT))
    elsewhere, same = (Batch(load_helicopter(name), 1, claw=PROMPT) for _ in range(2))
    elsewhere.set_patch((20.0, 21.0), (0.0, 1.0), 0.2)
    same.set_patch(*WIDE, 1.0)
    for batch in (elsewhere, same):
        assert batch.mode[Mode.PATCH] == 1
        for got, expected in zip(driven(batch), plain, strict=True):
            assert np.array_equal(got, expected)


@pytest.mark.parametrize("name", HELICOPTERS)
def test_a_patch_under_all_wheels_is_another_friction_coefficient(name: str) -> None:
    batch, other = (Batch(load_helicopter(name), 1, claw=PROMPT) for _ in range(2))
    batch.set_patch(*WIDE, 0.4)
    for t in range(2 * STATIONS):
        other.parameters[TIRE_PAR + t * TIRE_ROWS + Tir.MU] *= 1.0 - (1.0 - 0.4)  # the very product of the kernel
    found, expected = driven(batch), driven(other)
    for got, wanted in zip(found, expected, strict=True):
        np.testing.assert_allclose(got, wanted, rtol=1e-9, atol=1e-9)
    plain = driven(Batch(load_helicopter(name), 1, claw=PROMPT))
    assert np.max(np.abs(found[0] - plain[0])) > 1e-3


def test_a_helicopter_on_braked_wheels_slides_down_a_slope_where_the_patch_is() -> None:
    """tan(6 deg) = 0.105 lies between the friction on the patch, 0.04, and that of the deck."""
    batch = Batch(load_helicopter("generic_tricycle"), 2, claw=PROMPT)
    batch.parameters[Par.PROBE_ACTIVE] = 0.0
    batch.place(0.0, 0.0, 0.0)
    brake(batch)
    mu = batch.parameters[TIRE_PAR + Tir.MU, 0]
    batch.set_patch(*WIDE, 0.04 / mu, columns=[1])
    batch.set_motion([Fixed(pitch_deg=6.0).bake(1.0, 0.25)] * 2)
    start = batch.state[State.Q8].copy()
    batch.advance(intervals=10)
    gone = batch.state[State.Q8] - start
    slope = math.radians(6.0)
    assert abs(gone[0]) < 0.05
    assert gone[1] == pytest.approx(-0.5 * 9.81 * (math.sin(slope) - 0.04 * math.cos(slope)), rel=0.1)
    read = batch.telemetry
    for wheel in WHEELS:
        in_plane = np.hypot(read[f"{wheel}_longitudinal_load"], read[f"{wheel}_lateral_load"])
        assert in_plane[1] == pytest.approx(0.04 * read[f"{wheel}_vertical_load"][1], rel=0.02)


def test_only_the_wheel_on_the_patch_lets_go() -> None:
    """A patch under the right main wheel: its greatest side force shrinks, the left one's does not."""
    batch = Batch(load_helicopter("generic_tricycle"), 2, claw=PROMPT)
    batch.place(0.0, 0.0, 0.0)
    x, y = batch.telemetry["right_contact_x"][0], batch.telemetry["right_contact_y"][0]
    batch.set_patch((x - 1.0, x + 1.0), (y - 0.7, y + 0.7), 0.1, columns=[1])
    share = {wheel: np.zeros(2) for wheel in WHEELS}
    for _ in range(12):
        batch.advance([[0.0, 1.0]] * 2)
        for i, wheel in enumerate(WHEELS):
            side = np.abs(batch.telemetry[f"{wheel}_lateral_load"]) / loads(batch)[i]
            share[wheel] = np.maximum(share[wheel], side)
    mu = batch.parameters[TIRE_PAR + 2 * TIRE_ROWS + Tir.MU, 0]
    assert share["right"][1] < 0.1 * mu * 1.001 < 0.5 * share["right"][0]
    assert share["left"][1] > 0.9 * share["left"][0]


def test_rolling_resistance_is_that_of_the_deck() -> None:
    batch = Batch(load_helicopter("generic_tricycle"), 2, claw=PROMPT)
    batch.place(0.0, 0.0, 0.0)
    batch.set_patch(*WIDE, 0.2, columns=[1])
    for _ in range(30):
        batch.advance([[1.0, 0.0]] * 2)
    drag = np.sum([batch.telemetry[f"{wheel}_longitudinal_load"] for wheel in WHEELS], axis=0)
    assert drag[0] < -40.0  # the wheels roll with some resistance
    assert drag[1] == pytest.approx(drag[0], rel=1e-3)


def test_it_belongs_to_its_batch_and_goes_with_a_new_description() -> None:
    helicopter = load_helicopter("generic_tricycle")
    batch = Batch(helicopter, 2, claw=PROMPT)
    batch.set_patch((0.0, 1.0), (-1.0, 0.5), 0.3, 0.1, columns=[0])
    rows = slice(int(Par.PATCH_X_MIN), int(Par.PATCH_EDGE) + 1)
    np.testing.assert_array_equal(batch.parameters[rows, 0], [0.0, 1.0, -1.0, 0.5, 0.7, 0.1])
    assert not batch.parameters[rows, 1].any()
    assert batch.fork(2).mode[Mode.PATCH] == 1
    batch.describe([helicopter], [0])
    assert not batch.parameters[rows].any()


@pytest.mark.parametrize(
    ("x", "y", "factor", "edge", "words"),
    [
        ((2.0, 1.0), (0.0, 1.0), 0.5, 0.02, r"patch: x_m = \(2.0, 1.0\) is refused: it must go from a smaller"),
        ((0.0, 1.0), (0.0, 0.1), 0.5, 0.06, r"patch: y_m = \(0.0, 0.1\) .* two edges, 0.12 m"),
        ((0.0, 1.0), (0.0, math.nan), 0.5, 0.02, "patch: y_m"),
        ((0.0, 1.0), (0.0, 1.0), -0.1, 0.02, "patch: friction_factor = -0.1 .* at least 0"),
        ((0.0, 1.0), (0.0, 1.0), 0.5, 0.0, "patch: edge_m = 0.0 .* positive"),
    ],
)
def test_what_is_no_patch_is_refused(x: Any, y: Any, factor: float, edge: float, words: str) -> None:
    batch = Batch(load_helicopter("generic_tricycle"), 1)
    with pytest.raises(ConfigurationError, match=words):
        batch.set_patch(x, y, factor, edge)
    assert not batch.parameters[Par.PATCH_X_MIN : Par.PATCH_EDGE + 1].any()
    assert batch.mode[Mode.PATCH] == 0
