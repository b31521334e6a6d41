"""The node table: consistent derivatives, smooth across nodes, close to the motion it was baked from."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.ship import Component, Fixed, Harmonics, Irregular, MotionTable, Sinusoid, smootherstep
from ssmash_gym.ship.kinematics import angular_velocity

ROUGH = Irregular.model_validate(
    {
        "surge": {"rms_m": 0.2, "period_s": 9.0},
        "sway": {"rms_m": 0.6, "period_s": 9.5},
        "heave": {"rms_m": 0.7, "period_s": 7.0},
        "roll": {"rms_deg": 4.4, "period_s": 10.4},
        "pitch": {"rms_deg": 1.4, "period_s": 7.0},
        "yaw": {"rms_deg": 1.0, "period_s": 11.0},
        "roll_deg": 2.0,
        "z_m": -1.0,
    }
)


@pytest.fixture
def rough() -> Harmonics:
    return ROUGH.realise(np.random.default_rng(7))


def one_row(columns: np.ndarray) -> MotionTable:
    return MotionTable(0.5, columns)


@settings(max_examples=25, deadline=None)
@given(arrays(np.float64, (3, 18), elements=st.floats(-10.0, 10.0)))
def test_any_table_goes_through_its_nodes_and_is_c2_there(nodes: np.ndarray) -> None:
    table = one_row(nodes)
    tiny = 1e-9
    before, after = table.at(0.5 - tiny), table.at(0.5 + tiny)
    for k, (b, a, slack) in enumerate(zip(before, after, (1e-6, 1e-5, 1e-4), strict=True)):
        np.testing.assert_allclose(table.at([0.0, 0.5, 1.0])[k], nodes[:, 6 * k : 6 * k + 6], atol=1e-9)
        np.testing.assert_allclose(b, a, atol=slack)


@settings(max_examples=25, deadline=None)
@given(arrays(np.float64, (2, 18), elements=st.floats(-10.0, 10.0)), st.floats(0.05, 0.45))
def test_any_table_reports_the_derivatives_of_what_it_reports(nodes: np.ndarray, t: float) -> None:
    table = one_row(nodes)
    h = 1e-5
    low, mid, high = table.at(t - h), table.at(t), table.at(t + h)
    np.testing.assert_allclose((high.position - low.position) / (2 * h), mid.rate, atol=1e-4)
    np.testing.assert_allclose((high.rate - low.rate) / (2 * h), mid.acceleration, atol=1e-3)


def test_rates_are_the_derivatives_of_the_table_in_a_rough_sea(rough: Harmonics) -> None:
    table = rough.bake(60.0, 0.25)
    t = np.random.default_rng(0).uniform(0.01, 59.99, 500)
    h = 1e-3
    low, mid, high = table.at(t - h), table.at(t), table.at(t + h)
    for lower, exact in ((0, 1), (1, 2)):
        slope = (high[lower] - low[lower]) / (2.0 * h)
        assert np.max(np.abs(slope - mid[exact]) / np.std(mid[exact], axis=0)) < 1e-5


@pytest.mark.parametrize(
    ("spacing", "bounds"),
    [(0.5, (1e-4, 1e-3, 1e-2)), (0.25, (2e-6, 2e-5, 5e-4)), (0.1, (2e-8, 5e-7, 2e-5))],
)
def test_the_table_follows_the_motion(rough: Harmonics, spacing: float, bounds: tuple[float, ...]) -> None:
    table = rough.bake(60.0, spacing)
    t = np.random.default_rng(1).uniform(0.0, 60.0, 1000)
    for found, exact, bound in zip(table.at(t), rough.signal(t), bounds, strict=True):
        assert np.max(np.abs(found - exact) / np.std(exact, axis=0)) < bound


def test_interpolation_error_of_ten_second_roll_matches_the_study() -> None:
    """Spacing 0.25 s: 3e-8 of the standard deviation in position, 5e-7 in rate, 2e-5 in acceleration."""
    motion = Sinusoid(dof="roll", amplitude_deg=5.0, period_s=5.0).realise()
    t = np.linspace(0.0, 20.0, 3001)
    bounds = (3e-8, 5e-7, 2e-5)
    for found, exact, bound in zip(motion.bake(20.0, 0.25).at(t), motion.signal(t), bounds, strict=True):
        assert np.max(np.abs(found - exact)[:, 3]) / np.std(exact[:, 3]) < bound


def test_even_sampling_gives_the_motion_itself_at_the_nodes(rough: Harmonics) -> None:
    table = rough.bake(100.0, 0.25, start_s=12.3)
    exact = rough.signal(12.3 + 0.25 * np.arange(401))
    np.testing.assert_allclose(table.nodes, np.concatenate(exact, axis=1), atol=1e-12)


def test_a_longer_table_begins_with_the_same_bits(rough: Harmonics) -> None:
    long, short = rough.bake(100.0, 0.25).nodes, rough.bake(33.0, 0.25).nodes
    assert np.array_equal(long[: len(short)], short)


def test_pose_agrees_with_finite_differences_at_large_angles() -> None:
    components = tuple(
        Component(k, np.array([w]), np.array([a]), np.array([p]))
        for k, (w, a, p) in enumerate(
            [(0.9, 2.0, 0.1), (0.7, 1.0, 0.2), (1.1, 3.0, 0.3), (0.8, 2.5, 0.4), (0.9, 1.3, 0.5), (0.6, 3.0, 0.6)]
        )
    )
    table = Harmonics(np.zeros(6), components).bake(20.0, 0.1)
    t, h = np.linspace(0.5, 19.5, 200), 1e-4
    low, mid, high = table.pose(t - h), table.pose(t), table.pose(t + h)
    skew = np.einsum("nji,njk->nik", mid.R_NS, (high.R_NS - low.R_NS) / (2.0 * h))
    w = np.stack([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]], axis=-1)
    np.testing.assert_allclose(mid.w_NS_S, w, atol=1e-6)
    np.testing.assert_allclose(mid.wdot_NS_S, (high.w_NS_S - low.w_NS_S) / (2.0 * h), atol=1e-6)
    np.testing.assert_allclose(mid.v_NS_N, (high.r_NS_N - low.r_NS_N) / (2.0 * h), atol=1e-6)
    np.testing.assert_allclose(mid.a_NS_N, (high.v_NS_N - low.v_NS_N) / (2.0 * h), atol=1e-6)
    assert np.max(np.abs(mid.w_NS_S - table.at(t).rate[:, 3:])) > 0.5


def test_specific_force_of_a_heeled_and_a_falling_deck() -> None:
    pose = Fixed(roll_deg=10.0).bake(1.0, 0.25).pose(0.5)
    expected = 9.81 * np.array([0.0, -np.sin(np.radians(10.0)), -np.cos(np.radians(10.0))])
    np.testing.assert_allclose(pose.specific_force_S(9.81), expected, atol=1e-12)
    t = 0.25 * np.arange(5)
    nodes = np.zeros((5, 18))
    nodes[:, 2], nodes[:, 8], nodes[:, 14] = 0.5 * 9.81 * t**2, 9.81 * t, 9.81
    falling = MotionTable(0.25, nodes).pose(np.linspace(0.0, 1.0, 9))
    np.testing.assert_allclose(falling.specific_force_S(9.81), 0.0, atol=1e-11)


def test_scalar_and_vector_times_agree(rough: Harmonics) -> None:
    table = rough.bake(5.0, 0.25)
    assert table.at(1.3).position.shape == (6,)
    assert table.pose(1.3).R_NS.shape == (3, 3)
    assert table.at(np.zeros((2, 3))).rate.shape == (2, 3, 6)
    for one, many in zip(table.at(1.3), table.at([1.3, 2.0]), strict=True):
        assert np.array_equal(one, many[0])


def test_ramp_starts_at_rest_in_the_mean_pose_and_ends_in_the_motion(rough: Harmonics) -> None:
    ramped, plain = rough.bake(20.0, 0.25, ramp_s=5.0), rough.bake(20.0, 0.25)
    assert np.array_equal(ramped.nodes[0], np.concatenate([rough.mean, np.zeros(12)]))
    assert rough.mean[3] == np.radians(2.0)
    np.testing.assert_allclose(ramped.nodes[20:], plain.nodes[20:], rtol=0, atol=1e-15)
    assert np.abs(plain.nodes[0, 6:]).max() > 0.01  # without the ramp it does not start at rest


def test_ramped_nodes_hold_derivatives_by_the_product_rule(rough: Harmonics) -> None:
    def ramped(t: np.ndarray) -> np.ndarray:
        factor = smootherstep(t, 4.9)[0][:, np.newaxis]
        return rough.mean + factor * (rough.signal(3.0 + t).position - rough.mean)

    t, h = 0.25 * np.arange(1, 30), 1e-3  # the ramp ends between nodes: there its third derivative jumps
    nodes = rough.bake(7.5, 0.25, ramp_s=4.9, start_s=3.0).nodes[1:30]
    low, mid, high = ramped(t - h), ramped(t), ramped(t + h)
    np.testing.assert_allclose(nodes[:, :6], mid, atol=1e-12)
    np.testing.assert_allclose(nodes[:, 6:12], (high - low) / (2.0 * h), atol=2e-6)
    np.testing.assert_allclose(nodes[:, 12:], (high - 2.0 * mid + low) / h**2, atol=1e-5)


def test_smootherstep_is_c2_and_monotone() -> None:
    t = np.linspace(-1.0, 6.0, 7001)
    r, rd, rdd = smootherstep(t, 5.0)
    assert np.all(r[t <= 0.0] == 0.0)
    assert np.all(r[t >= 5.0] == 1.0)
    assert np.all(np.diff(r) >= 0.0)
    assert np.max(np.abs(np.gradient(r, t) - rd)) < 1e-4
    assert np.max(np.abs(np.gradient(rd, t) - rdd)) < 2e-3
    assert np.max(np.abs(np.diff(rdd))) < 5e-3  # no jump in the second derivative


def test_a_table_is_frozen_also_after_copies(rough: Harmonics) -> None:
    table = rough.bake(2.0, 0.25)
    for one in (table, copy.deepcopy(table), pickle.loads(pickle.dumps(table))):
        assert np.array_equal(one.nodes, table.nodes)
        assert not one.nodes.flags.writeable
        with pytest.raises(ValueError, match="read-only"):
            one.nodes[0, 0] = 1.0
    with pytest.raises(AttributeError):
        table.spacing_s = 1.0  # type: ignore[misc]


def test_a_table_does_not_change_with_the_array_it_was_made_of() -> None:
    nodes = np.zeros((3, 18))
    table = MotionTable(0.5, nodes)
    nodes[:] = 1.0
    assert np.all(table.nodes == 0.0)


def test_duration_is_rounded_up_to_whole_spacings() -> None:
    still = Fixed()
    assert still.bake(1.0, 0.25).duration_s == 1.0
    assert still.bake(1.01, 0.25).duration_s == 1.25
    assert len(still.bake(0.1, 0.25).nodes) == 2
    assert len(still.bake(60.0, 0.1).nodes) == 601  # 60 / 0.1 is not exact in binary


@pytest.mark.parametrize(
    ("nodes", "spacing", "message"),
    [
        (np.zeros((1, 18)), 0.25, "shape"),
        (np.zeros((3, 12)), 0.25, "shape"),
        (np.full((3, 18), np.nan), 0.25, "node 0 .* not finite"),
        (np.zeros((3, 18)), 0.0, "spacing_s is 0.0"),
    ],
)
def test_unusable_nodes_are_refused(nodes: np.ndarray, spacing: float, message: str) -> None:
    with pytest.raises(ConfigurationError, match=message):
        MotionTable(spacing, nodes)


@pytest.mark.parametrize("t", [-0.1, 1.1, np.nan])
def test_times_outside_the_table_are_refused(t: float) -> None:
    with pytest.raises(ConfigurationError, match="outside the table, 0 to 1 s"):
        Fixed().bake(1.0, 0.25).at([0.5, t])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"duration_s": 0.0}, "duration_s is 0.0"),
        ({"duration_s": np.inf}, "duration_s is inf"),
        ({"spacing_s": -1.0}, "spacing_s is -1.0"),
        ({"ramp_s": -1.0}, "ramp_s is -1.0"),
        ({"start_s": np.nan}, "start_s is nan"),
    ],
)
def test_unusable_times_are_refused(arguments: dict[str, float], message: str) -> None:
    with pytest.raises(ConfigurationError, match=message):
        Fixed().bake(**({"duration_s": 1.0, "spacing_s": 0.25} | arguments))


def test_body_rates_of_a_table_follow_from_its_own_angles(rough: Harmonics) -> None:
    table = rough.bake(10.0, 0.25)
    t = np.linspace(0.0, 10.0, 37)
    at = table.at(t)
    assert np.array_equal(table.pose(t).w_NS_S, angular_velocity(at.position[:, 3:], at.rate[:, 3:]))
