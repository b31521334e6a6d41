"""The securing probe: kinematics, in-plane laws, axial tension, moment, capture and loss."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ssmash_gym.dynamics.lane import WIDTH, kernel, load, store, uncompiled
from ssmash_gym.dynamics.layout import PARAMETER_ROWS, Par, ProbeLaw
from ssmash_gym.dynamics.probe import axial_tension, capture, potential_force, probe, probe_kinematics, radial_force
from ssmash_gym.dynamics.vectors import load3, rotation, store3

plain_probe, plain_capture = uncompiled(probe), uncompiled(capture)
plain_kinematics = uncompiled(probe_kinematics)

MOUNT, VECTOR, CLAW_Z = np.array([0.4, 0.05, 1.2]), np.array([0.06, -0.02, 0.9]), -0.05
VALUES = {
    "ks_x": 4.0e5, "ks_y": 6.0e5, "kl_x": 1.2e6, "kl_y": 2.5e6, "d_x": 0.004, "d_y": 0.007,
    "c_x": 2.0e4, "c_y": 3.0e4, "c_z": 1.5e4, "d_z": 0.003, "ks_z": 3.0e5, "kl_z": 2.0e6,
    "capture_radius": 0.10, "ultimate": 9.0e4, "active": 1.0,
}  # fmt: skip
ISOTROPIC = {"ks_y": 4.0e5, "kl_y": 1.2e6, "d_y": 0.004, "c_y": 2.0e4}
LAWS = list(ProbeLaw)


def block(**changes: float) -> np.ndarray:
    p = np.zeros((PARAMETER_ROWS, 1))
    for name, value in {**VALUES, **changes}.items():
        p[Par[f"PROBE_{name.upper()}"]] = value
    p[Par.PROBE_MOUNT : Par.PROBE_MOUNT + 3, 0] = MOUNT
    p[Par.PROBE_VECTOR : Par.PROBE_VECTOR + 3, 0] = VECTOR
    return p


def turn(vector: np.ndarray) -> np.ndarray:
    """Rotation matrix of a rotation vector."""
    angle = np.linalg.norm(vector)
    a = vector / max(angle, 1e-300)
    K = np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def lanes(vector: np.ndarray) -> tuple:
    return tuple(np.asarray(vector, dtype=float)[:, None])


class Pose:
    """A helicopter over the deck with its probe near the claw, and how both move."""

    def __init__(self, seed: int = 0, tilt: float = 0.1) -> None:
        rng = np.random.default_rng(seed)
        self.R = turn(rng.normal(size=3) * tilt)
        self.r_SC = np.array([0.3, -0.2, CLAW_Z])
        above = rng.normal(size=3) * (0.01, 0.01, 0.004)
        self.r_SH = self.r_SC - self.R @ (MOUNT + VECTOR) + above
        self.v_SH, self.w, self.v_SC = rng.normal(size=3), rng.normal(size=3), rng.normal(size=3) * (1.0, 1.0, 0.0)

    def at(self, t: float) -> Pose:
        """The same motion a moment later (w constant in H)."""
        moved = Pose()
        moved.R = self.R @ turn(self.w * t)
        moved.r_SH, moved.r_SC = self.r_SH + self.v_SH * t, self.r_SC + self.v_SC * t
        moved.v_SH, moved.w, moved.v_SC = self.v_SH, self.w, self.v_SC
        return moved

    def still(self) -> Pose:
        self.v_SH = self.w = self.v_SC = np.zeros(3)
        return self

    def arguments(self) -> tuple:
        R = tuple(self.R.reshape(9)[:, None])
        return R, lanes(self.r_SH), lanes(self.v_SH), lanes(self.w), lanes(self.r_SC), lanes(self.v_SC)

    def load(self, law: int = ProbeLaw.POTENTIAL, captured: float = 1.0, **changes: float) -> tuple:
        with np.errstate(divide="raise", invalid="raise", over="raise"):
            F, M, reads = plain_probe(block(**changes), law, *self.arguments(), np.array([captured]))
        return np.array(F)[:, 0], np.array(M)[:, 0], np.array(reads)[:, 0]

    def kinematics(self) -> list[np.ndarray]:
        R, _, v_SH, w, _, v_SC = self.arguments()
        r_HC = lanes(self.R.T @ (self.r_SC - self.r_SH))
        return [np.squeeze(np.array(value)) for value in plain_kinematics(block(), R, v_SH, w, r_HC, v_SC)]


def in_plane(d: np.ndarray, law: int = ProbeLaw.POTENTIAL, v: tuple = (0.0, 0.0), **changes: float) -> np.ndarray:
    """In-plane force of displacements ``d`` (2, n), damping off unless rates are given."""
    p = block(**changes)
    d_x, d_y = np.atleast_2d(d.T).T if d.ndim == 1 else d
    v_x, v_y = (np.broadcast_to(np.asarray(c, dtype=float), d_x.shape) for c in v)
    with np.errstate(divide="raise", invalid="raise", over="raise"):
        if law == ProbeLaw.POTENTIAL:
            return np.array(uncompiled(potential_force)(p, d_x, d_y, v_x, v_y))
        return np.array(uncompiled(radial_force)(p, d_x, d_y, v_x, v_y, law == ProbeLaw.PRINTED))


def two_stage(d: np.ndarray, soft: float, stiff: float, transition: float) -> np.ndarray:
    """(2.183)"""
    return np.where(d <= transition, soft * d, soft * transition + stiff * (d - transition))


# --- in-plane law ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("law", LAWS)
def test_on_the_axes_every_law_is_the_two_stage_curve(law: int) -> None:
    d = np.linspace(1e-5, 0.03, 400)
    zero = np.zeros_like(d)
    for sign in (1.0, -1.0):
        along_x, along_y = in_plane(np.array([sign * d, zero]), law), in_plane(np.array([zero, sign * d]), law)
        np.testing.assert_allclose(along_x[0], -sign * two_stage(d, 4e5, 1.2e6, 0.004), rtol=1e-12)
        np.testing.assert_allclose(along_y[1], -sign * two_stage(d, 6e5, 2.5e6, 0.007), rtol=1e-12)
        np.testing.assert_allclose(along_x[1], 0.0, atol=1e-9)
        np.testing.assert_allclose(along_y[0], 0.0, atol=1e-9)


def isotropic_stiffness(law: int, angle: float) -> tuple[float, np.ndarray]:
    d = np.array([np.cos(angle), np.sin(angle)]) * 0.001
    F = in_plane(d[:, None], law, **ISOTROPIC)[:, 0]
    return float(np.linalg.norm(F) / 0.001), F


@pytest.mark.parametrize("law", [ProbeLaw.POTENTIAL, ProbeLaw.ELLIPSE])
def test_an_isotropic_probe_is_equally_stiff_all_round(law: int) -> None:
    r = np.linspace(1e-4, 0.02, 50)
    for angle in np.linspace(0.0, 2 * np.pi, 25):
        direction = np.array([np.cos(angle), np.sin(angle)])
        F = in_plane(direction[:, None] * r, law, **ISOTROPIC)
        np.testing.assert_allclose(F, -direction[:, None] * two_stage(r, 4e5, 1.2e6, 0.004), rtol=1e-9, atol=1e-8)


def test_the_printed_law_is_41_percent_too_stiff_at_45_degrees() -> None:
    assert isotropic_stiffness(ProbeLaw.PRINTED, np.pi / 4)[0] == pytest.approx(np.sqrt(2.0) * 4e5, rel=1e-9)
    assert isotropic_stiffness(ProbeLaw.PRINTED, 0.0)[0] == pytest.approx(4e5, rel=1e-9)


def loop_work(law: int, points: int = 4096) -> tuple[float, float]:
    """Net work of the probe on a helicopter that goes once round an off-centre ellipse, and its scale."""
    t = 2 * np.pi * np.arange(points) / points
    d = np.array([0.006 + 0.013 * np.cos(t), -0.002 + 0.011 * np.sin(t)])
    rate = np.array([-0.013 * np.sin(t), 0.011 * np.cos(t)])
    power = np.sum(in_plane(d, law) * rate, axis=0)
    return float(np.sum(power) / points), float(np.sum(np.abs(power)) / points)


def crossings(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Parameters in [0, 1] where the straight line from a to b crosses the edge of the free play, with both ends."""
    scale = np.array([VALUES["d_x"], VALUES["d_y"]])
    start, step = a / scale, (b - a) / scale
    roots = np.roots([step @ step, 2 * start @ step, start @ start - 1.0])
    inside = [root.real for root in roots if abs(root.imag) < 1e-12 and 0.0 < root.real < 1.0]
    return np.array([0.0, *sorted(inside), 1.0])


def test_the_default_law_is_conservative_through_the_free_play_and_the_radial_ones_are_not() -> None:
    nodes, weights = np.polynomial.legendre.leggauss(60)
    corners = np.array([[0.0171, 0.003], [-0.002, 0.0163], [-0.014, -0.011]])
    work = scale = 0.0
    pieces = 0
    for a, b in itertools.pairwise([*corners, corners[0]]):
        for s0, s1 in itertools.pairwise(crossings(a, b)):  # the stiffness has a kink there
            s = s0 + (s1 - s0) * (nodes + 1) / 2
            power = (b - a) @ in_plane(a[:, None] + (b - a)[:, None] * s) * weights * (s1 - s0) / 2
            work, scale, pieces = work + power.sum(), scale + np.abs(power).sum(), pieces + 1
    assert pieces > 3
    assert abs(work) < 1e-9 * scale
    for law in (ProbeLaw.ELLIPSE, ProbeLaw.PRINTED):
        net, total = loop_work(law)
        assert abs(net) > 1e-3 * total


def potential(d: np.ndarray) -> np.ndarray:
    """Energy of the default law, by its definition."""
    extra_x, extra_y = VALUES["kl_x"] - VALUES["ks_x"], VALUES["kl_y"] - VALUES["ks_y"]
    rho = np.hypot(d[0] / VALUES["d_x"], d[1] / VALUES["d_y"])
    s = np.where(rho > 1.0, 1.0 - 1.0 / np.maximum(rho, 1.0), 0.0)
    soft = VALUES["ks_x"] * d[0] ** 2 + VALUES["ks_y"] * d[1] ** 2
    return 0.5 * (soft + s * s * (extra_x * d[0] ** 2 + extra_y * d[1] ** 2))


@settings(max_examples=100, deadline=None)
@given(st.floats(-0.05, 0.05), st.floats(-0.05, 0.05))
def test_the_default_force_is_the_gradient_of_its_potential(x: float, y: float) -> None:
    d, h = np.array([[x], [y]]), 1e-7
    F = in_plane(d)[:, 0]
    gradient = [
        (potential(d + e) - potential(d - e))[0] / (2 * h) for e in (np.array([[h], [0]]), np.array([[0], [h]]))
    ]
    np.testing.assert_allclose(F, -np.array(gradient), rtol=1e-6, atol=0.5)


def test_work_round_a_loop_outside_the_free_play_vanishes() -> None:
    t = 2 * np.pi * np.arange(2048) / 2048  # smooth force on a smooth loop: the sum converges exponentially
    d = np.array([0.02 * np.cos(t), 0.03 * np.sin(t)])
    rate = np.array([-0.02 * np.sin(t), 0.03 * np.cos(t)])
    power = np.sum(in_plane(d) * rate, axis=0)
    assert abs(power.sum()) < 1e-9 * np.abs(power).sum()


@pytest.mark.parametrize("law", LAWS)
def test_damping_takes_energy_out(law: int) -> None:
    rng = np.random.default_rng(3)
    v = rng.normal(size=(2, 500)) * 10.0 ** rng.uniform(-8, 1, 500)
    F = in_plane(np.zeros((2, 500)), law, v=tuple(v))
    assert np.all(np.sum(F * v, axis=0) < 0.0)
    only_x = in_plane(np.zeros((2, 1)), law, v=(0.5, 0.0))
    np.testing.assert_allclose(only_x[:, 0], (-2.0e4 * 0.5, 0.0), rtol=1e-12)


# --- kinematics --------------------------------------------------------------------------------------------


def test_point_b_lies_on_the_probe_axis_in_the_claw_plane() -> None:
    for seed in range(20):
        pose = Pose(seed)
        reads = pose.load()[2]
        b_S = pose.r_SH + pose.R @ (MOUNT + reads[7] * VECTOR)
        assert b_S[2] == pytest.approx(CLAW_Z, abs=1e-12)
        np.testing.assert_allclose(reads[5:7], b_S[:2], atol=1e-12)
        np.testing.assert_allclose(reads[2:4], (pose.R.T @ (b_S - pose.r_SC))[:2], atol=1e-12)
        assert reads[4] == pytest.approx((reads[7] - 1.0) * np.linalg.norm(VECTOR), rel=1e-12)


def test_rates_are_those_of_the_displacements_with_claw_and_helicopter_moving() -> None:
    h = 1e-5
    for seed in range(20):
        pose = Pose(seed)
        reach_rate, delta_rate = pose.kinematics()[1], pose.kinematics()[5]
        before, after = pose.at(-h), pose.at(h)
        assert reach_rate == pytest.approx(
            (after.kinematics()[0] - before.kinematics()[0]) / (2 * h), rel=1e-7, abs=1e-8
        )
        moved = after.R @ after.kinematics()[4] - before.R @ before.kinematics()[4]  # the ship frame's derivative
        np.testing.assert_allclose(delta_rate, pose.R.T @ moved / (2 * h), rtol=1e-7, atol=1e-8)


def test_rates_are_the_printed_quotient() -> None:
    """(2.174)-(2.177), term by term."""
    pose = Pose(4)
    k = np.array([0.0, 0.0, 1.0])
    f = (pose.r_SC - pose.r_SH - pose.R @ MOUNT) @ k
    g = (pose.R @ VECTOR) @ k
    f_rate = (pose.v_SC - pose.v_SH - pose.R @ np.cross(pose.w, MOUNT)) @ k
    g_rate = (pose.R @ np.cross(pose.w, VECTOR)) @ k
    values = pose.kinematics()
    assert values[0] == pytest.approx(f / g, rel=1e-12)
    assert values[1] == pytest.approx((f_rate * g - f * g_rate) / g**2, rel=1e-12)


def test_common_motion_over_the_deck_changes_nothing() -> None:
    pose, other = Pose(5), Pose(5)
    drift = np.array([0.3, -0.4, 0.0])
    other.v_SH, other.v_SC = pose.v_SH + drift, pose.v_SC + drift
    np.testing.assert_allclose(pose.load()[0], other.load()[0], rtol=1e-9)


def test_a_probe_off_the_deck_is_not_held_and_all_stays_finite() -> None:
    for tilt in (1.53, 1.5708, 2.0, 3.1):
        pose = Pose(1)
        pose.R = turn(np.array([tilt, 0.0, 0.0]))
        F, M, reads = pose.load()
        dips = (pose.R @ VECTOR)[2] >= 0.05 * np.linalg.norm(VECTOR)
        assert np.all(np.isfinite(np.concatenate([F, M, reads])))
        if not dips:
            assert np.all(F == 0.0)
            assert reads[7] == 0.0
    assert not dips


# --- axial force -------------------------------------------------------------------------------------------


def tension(extension: object, rate: object = 0.0) -> np.ndarray:
    return uncompiled(axial_tension)(block(), *np.broadcast_arrays(np.atleast_1d(extension).astype(float), rate))


def test_tension_follows_its_two_stages_and_nothing_pushes() -> None:
    x = np.linspace(-0.01, 0.01, 2001)
    np.testing.assert_allclose(tension(x), np.where(x > 0.0, two_stage(x, 3e5, 2e6, 0.003), 0.0), rtol=1e-12)
    for rate in (-5.0, -0.1, 0.1, 5.0):
        assert np.all(tension(x, rate) >= 0.0)
        assert np.all(tension(x[x <= 0.0], rate) == 0.0)


def test_tension_has_no_jump_at_first_tension_however_fast() -> None:
    assert tension(1e-9, 3.0)[0] < 0.1
    assert tension(0.003, 0.2)[0] == pytest.approx(3e5 * 0.003 + 1.5e4 * 0.2, rel=1e-12)


def test_tension_pulls_the_helicopter_along_the_probe() -> None:
    pose = Pose(2).still()
    pose.r_SH = pose.r_SC - pose.R @ (MOUNT + 1.005 * VECTOR)  # claw on the axis, tip pulled out
    F, _, reads = pose.load()
    axis = VECTOR / np.linalg.norm(VECTOR)
    np.testing.assert_allclose(F, tension(0.005 * np.linalg.norm(VECTOR))[0] * axis, rtol=1e-7, atol=1e-6)
    assert reads[0] == pytest.approx(0.0, abs=1e-6)
    assert reads[1] == pytest.approx(np.linalg.norm(F), rel=1e-9)
    slack = Pose(2).still()
    slack.r_SH = slack.r_SC - slack.R @ (MOUNT + 0.995 * VECTOR)
    assert np.linalg.norm(slack.load()[0]) < 1e-6


# --- whole force -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("law", LAWS)
def test_displaced_probe_is_drawn_to_the_claw_with_its_moment_about_the_cg(law: int) -> None:
    for seed in range(10):
        pose = Pose(seed).still()
        F, M, reads = pose.load(law)
        arm = pose.R.T @ (pose.r_SC - pose.r_SH)
        np.testing.assert_allclose(M, np.cross(arm, F), rtol=1e-10, atol=1e-6)
        axial = reads[1] * VECTOR / np.linalg.norm(VECTOR)
        assert (F - axial)[:2] @ reads[2:4] < 0.0
        assert np.hypot(*(F - axial)[:2]) == pytest.approx(reads[0], rel=1e-9)
        np.testing.assert_allclose((F - axial)[:2], in_plane(reads[2:4, None], law)[:, 0], rtol=1e-6, atol=1e-4)


def test_neither_an_uncaptured_nor_an_absent_probe_pulls() -> None:
    held = Pose(3)
    for F, M, reads in (held.load(captured=0.0), held.load(active=0.0)):
        assert np.all(F == 0.0) and np.all(M == 0.0) and np.all(reads[:2] == 0.0)
        np.testing.assert_array_equal(reads[2:], held.load()[2][2:])


def test_a_row_of_zeros_for_an_absent_probe_is_harmless() -> None:
    pose = Pose(3)
    for law in LAWS:
        with np.errstate(divide="raise", invalid="raise", over="raise"):
            F, M, reads = plain_probe(np.zeros((PARAMETER_ROWS, 1)), law, *pose.arguments(), np.ones(1))
        assert np.all(np.array(F) == 0.0) and np.all(np.array(M) == 0.0) and np.all(np.isfinite(np.array(reads)))


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 10_000), tilt=st.floats(0.0, 3.0), law=st.sampled_from(LAWS))
def test_everything_is_finite_on_a_wide_sweep(seed: int, tilt: float, law: int) -> None:
    values = np.concatenate(Pose(seed, tilt).load(law))
    assert np.all(np.isfinite(values))


# --- capture and loss --------------------------------------------------------------------------------------


def status(d: tuple, reach: float, captured: float = 0.0, lost: float = 0.0, resultant: float = 0.0) -> tuple:
    numbers = (np.array([value]) for value in (*d, reach, resultant, captured, lost))
    return tuple(float(value[0]) for value in plain_capture(block(), *numbers))


def test_capture_needs_the_window_and_the_tip_at_or_below_the_claw_plane() -> None:
    assert status((0.07, 0.07), 0.95) == (1.0, 0.0)
    assert status((0.08, 0.07), 0.95) == (0.0, 0.0)
    assert status((0.0, 0.0), 1.0) == (1.0, 0.0)
    assert status((0.0, 0.0), 1.001) == (0.0, 0.0)
    assert status((0.0, 0.0), 0.0) == (0.0, 0.0)


def test_capture_is_for_good_until_the_ultimate_load_and_loss_for_ever() -> None:
    assert status((0.5, 0.5), 1.4, captured=1.0, resultant=8.9e4) == (1.0, 0.0)
    assert status((0.0, 0.0), 0.95, captured=1.0, resultant=9.1e4) == (0.0, 1.0)
    assert status((0.0, 0.0), 0.95, captured=0.0, lost=1.0) == (0.0, 1.0)
    assert status((0.0, 0.0), 0.95, captured=0.0, resultant=9.1e4) == (1.0, 0.0)


# --- lanes -------------------------------------------------------------------------------------------------


@kernel
def probe_driver(p, law, y, out):
    R_SH = rotation(load(y, 0), load(y, 1), load(y, 2), load(y, 3))
    F, M, reads = probe(p, law, R_SH, load3(y, 4), load3(y, 7), load3(y, 10), load3(y, 13), load3(y, 16), load(y, 19))
    store3(out, 0, F)
    store3(out, 3, M)
    store3(out, 6, (reads[0], reads[1], reads[2]))
    store3(out, 9, (reads[3], reads[4], reads[5]))
    captured, lost = capture(p, reads[2], reads[3], reads[7], reads[0], load(y, 19), load(y, 20))
    store3(out, 12, (reads[6], reads[7], captured))
    store(out, 15, lost)


def test_lanes_give_the_bits_of_numpy() -> None:
    rng = np.random.default_rng(5)
    p = np.ascontiguousarray(np.broadcast_to(block(), (PARAMETER_ROWS, WIDTH)))
    for law in (int(law) for law in LAWS):
        for _ in range(100):
            y = rng.normal(size=(21, WIDTH))
            y[:4] += np.array([[6.0], [0], [0], [0]])
            y[:4] /= np.linalg.norm(y[:4], axis=0)
            y[4:7] = np.array([[0.0], [0.0], [-2.1]]) + 0.05 * y[4:7]
            y[13:16] *= 0.05
            y[19:] = y[19:] > 0.0
            compiled, plain = np.zeros((16, WIDTH)), np.zeros((16, WIDTH))
            probe_driver(p, law, y, compiled)
            uncompiled(probe_driver)(p, law, y, plain)
            assert compiled.tobytes() == plain.tobytes()
