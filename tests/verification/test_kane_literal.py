"""The thesis' own equations against numerical differentiation, against the reference answers and against the kernel."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ssmash_gym.analysis import rigid_body_oracle as oracle
from tests.verification import kane_kinematics as kin
from tests.verification import kane_literal as kane

PUBLISHED = json.loads((Path(__file__).parent / "data" / "rigid_body_cases.json").read_text())["cases"]
STEP = 1e-5  # of the central differences [s]


def unit(rng: np.random.Generator) -> list[float]:
    p = rng.normal(size=4)
    return (p / np.linalg.norm(p)).tolist()


def inertia(rng: np.random.Generator, size: float) -> list[list[float]]:
    """Tensor of four random point masses: symmetric, positive, within the triangle inequality."""
    r = rng.normal(size=(4, 3))
    return (size * (np.eye(3) * np.sum(r * r) - r.T @ r)).tolist()


def random_case(seed: int) -> dict[str, Any]:
    """A case of any attitude and any mixture of stations; every third one has locked speeds."""
    rng = np.random.default_rng(seed)

    def vector(size: float) -> list[float]:
        return (size * rng.normal(size=3)).tolist()

    kinds = rng.choice(["prismatic", "swing"], size=3)
    return {
        "params": {
            "helicopter": {"mass": rng.uniform(5e3, 2e4), "inertia": inertia(rng, 1e4)},
            "stations": [
                {"type": str(k), "mass": rng.uniform(20.0, 400.0), "inertia": inertia(rng, 5.0), "mount": vector(2.0)}
                for k in kinds
            ],
        },
        "ship": {
            "p_S": unit(rng), "w_S": vector(0.5), "wdot_S": vector(0.5), "a_S": vector(5.0), "r_S": vector(50.0),
            "v_S": vector(10.0),
        },
        "state": {
            "r_H": vector(10.0), "p_H": unit(rng), "v_H": vector(2.0), "w_H": vector(0.7),
            "stations": [{"p_O": unit(rng), "r_W": vector(1.0), "u": rng.normal(size=2).tolist()} for _ in range(3)],
        },
        "loads": {
            "H": {"force": vector(5e4), "moment": vector(5e4)},
            "W": [{"force": vector(3e4), "moment": vector(2e3)} for _ in range(3)],
        },
        "locked": (rng.random(12) < 0.3).tolist() if seed % 3 == 0 else [False] * 12,
    }  # fmt: skip


def derivative(value: Any, c: kin.Chain, udot: np.ndarray) -> np.ndarray:
    """Time derivative of a function of the chain by central differences."""
    return (value(c.moved(udot, STEP)) - value(c.moved(udot, -STEP))) / (2.0 * STEP)


def close(got: np.ndarray, expected: np.ndarray, relative: float) -> bool:
    return bool(np.linalg.norm(got - expected) <= relative * np.linalg.norm(expected))


@pytest.mark.parametrize("seed", range(30))
def test_the_kernel_gives_the_accelerations_of_the_literal_equations(seed: int) -> None:
    case = random_case(seed)
    assert close(oracle.accelerations(case), kane.accelerations(case), 1e-9)


@pytest.mark.parametrize("case", PUBLISHED, ids=[c["id"] for c in PUBLISHED])
def test_the_literal_equations_give_the_reference_answers(case: dict[str, Any]) -> None:
    assert close(kane.accelerations(case), np.array(case["expected"]["udot"]), 1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_active_and_inertial_forces_of_the_kernels_accelerations_cancel(seed: int) -> None:
    case = random_case(seed)
    udot = np.concatenate([case["ship"]["a_S"], case["ship"]["wdot_S"], oracle.accelerations(case)])
    system = kane.bodies(case)
    active = kane.active_forces(system)[6:]
    residual = active + kane.inertia_forces(system, udot)[6:]  # (2.92)
    free = ~np.array(case["locked"])
    assert np.linalg.norm(residual[free]) <= 1e-9 * np.linalg.norm(active)


@pytest.mark.parametrize("seed", range(5))
def test_mass_matrix_is_symmetric_and_positive(seed: int) -> None:
    A, _ = kane.assemble(kane.bodies(random_case(seed)))
    np.testing.assert_allclose(A, A.T, atol=1e-9 * np.max(np.abs(A)))
    np.linalg.cholesky(-A[6:, 6:])
    assert np.linalg.matrix_rank(A) == 12, "six equations of the ship are not independent of the other twelve"


@pytest.mark.parametrize("seed", range(5))
def test_velocities_are_the_derivatives_of_the_positions(seed: int) -> None:
    c = kin.Chain.of(random_case(seed))
    rest = np.zeros(18)
    assert close(c.T_NH @ kin.velocity_H(c), derivative(kin.position_H, c, rest), 1e-7)
    assert close(kin.velocity_H_in_N(c), c.T_NH @ kin.velocity_H(c), 1e-13)
    for i, s in enumerate(c.stations):
        moving = derivative(lambda x, i=i: kin.position_W(x, x.stations[i]), c, rest)
        assert close(kin.velocity_W_in_N(c, s), moving, 1e-7)
        assert close(kin.velocity_W(c, s), (c.T_NH @ s.T_HO).T @ moving, 1e-7)


@pytest.mark.parametrize("seed", range(5))
def test_accelerations_are_the_derivatives_of_the_velocities(seed: int) -> None:
    c = kin.Chain.of(random_case(seed))
    udot = np.random.default_rng(seed).normal(size=18)
    joints = udot[12:].reshape(3, 2)
    assert close(c.T_NH @ kin.acceleration_H(c, udot), derivative(kin.velocity_H_in_N, c, udot), 1e-7)
    assert close(c.T_NH @ kin.acceleration_H(c, udot), kin.acceleration_H_in_N(c, udot), 1e-13)
    spin = derivative(lambda x: x.T_NH @ kin.angular_velocity_H(x), c, udot)
    assert close(kin.angular_acceleration_H_in_N(c, udot), spin, 1e-7)
    for i, (s, joint) in enumerate(zip(c.stations, joints, strict=True)):
        T_NW = c.T_NH @ s.T_HO
        linear = derivative(lambda x, i=i: kin.velocity_W_in_N(x, x.stations[i]), c, udot)
        assert close(T_NW @ kin.acceleration_W(c, s, udot, joint), linear, 1e-7)
        spin = derivative(
            lambda x, i=i: x.T_NH @ x.stations[i].T_HO @ kin.angular_velocity_W(x, x.stations[i]), c, udot
        )
        assert close(T_NW @ kin.angular_acceleration_W(c, s, udot, joint), spin, 1e-7)


@pytest.mark.parametrize("seed", range(5))
def test_partial_velocities_and_remainders_make_up_velocities_and_accelerations(seed: int) -> None:
    case = random_case(seed)
    c = kin.Chain.of(case)
    udot = np.random.default_rng(seed).normal(size=18)
    body, *carriages = kane.bodies(case)
    assert close(body.V @ c.speeds, kin.velocity_H(c), 1e-13)
    assert close(body.W @ c.speeds, kin.angular_velocity_H(c), 1e-13)
    assert close(body.V @ udot + body.Z, kin.acceleration_H(c, udot), 1e-13)
    assert close(body.W @ udot + body.Y, c.T_NH.T @ kin.angular_acceleration_H_in_N(c, udot), 1e-13)
    for b, s, joint in zip(carriages, c.stations, udot[12:].reshape(3, 2), strict=True):
        assert close(b.V @ c.speeds, kin.velocity_W(c, s), 1e-13)
        assert close(b.W @ c.speeds, kin.angular_velocity_W(c, s), 1e-13)
        assert close(b.V @ udot + b.Z, kin.acceleration_W(c, s, udot, joint), 1e-13)
        assert close(b.W @ udot + b.Y, kin.angular_acceleration_W(c, s, udot, joint), 1e-13)


def test_transformations_turn_with_the_angular_velocity() -> None:
    rng = np.random.default_rng(1)
    p, w = np.array(unit(rng)), rng.normal(size=3)
    T, rate = kin.transformation(p), kin.parameter_rates(p, w)
    np.testing.assert_allclose(T @ T.T, np.eye(3), atol=1e-14)
    assert p @ rate == pytest.approx(0.0, abs=1e-15)
    by_difference = (kin.transformation(p + STEP * rate) - kin.transformation(p - STEP * rate)) / (2.0 * STEP)
    np.testing.assert_allclose(by_difference, kin.transformation_rate(T, w), atol=1e-9)


def test_the_plus_signs_of_the_print_are_wrong() -> None:
    parameters = kin.euler_parameters(np.array([0.6, 0.64, 0.48]), 1.0)
    e0, e1, e2, e3 = parameters
    printed = kin.transformation(parameters)
    printed[1, 2] = 2.0 * (e2 * e3 + e0 * e1)
    printed[2, 0] = 2.0 * (e1 * e3 + e0 * e2)
    assert np.max(np.abs(printed @ printed.T - np.eye(3))) > 0.1, "(2.5) as printed is no rotation"
    shifts = []
    for case in PUBLISHED:
        right = kane.accelerations(case)
        shifts.append(np.linalg.norm(kane.accelerations(case, printed_signs=True) - right) / np.linalg.norm(right))
    assert np.max(shifts) > 0.1, "(2.68), (2.70), (2.72) as printed change the accelerations"
