"""The time grid: node spacing in whole substeps, and claw and deck tables as fine as they need to be."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ssmash_gym.dynamics.channels import Out
from ssmash_gym.dynamics.reference import Problem, integrate
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.ship import Fixed, Sinusoid
from ssmash_gym.simulation.batch import Batch
from ssmash_gym.simulation.timing import NODE_SPACING_S, Timing
from ssmash_gym.vehicle import load_helicopter


def test_nodes_are_a_quarter_of_a_second_apart_unless_told_otherwise() -> None:
    assert Timing().longest_node_s == NODE_SPACING_S == 0.25
    assert Timing().substeps_per_node == 125
    assert Timing() == Timing(longest_node_s=0.25)


@pytest.mark.parametrize(
    ("substep", "longest", "substeps"),
    [(0.002, 0.05, 25), (0.002, 0.02, 10), (0.004, 0.05, 12), (0.0045, 0.25, 56), (0.001, 0.001, 1), (0.005, 0.005, 1)],
)
def test_the_node_spacing_is_a_whole_number_of_substeps(substep: float, longest: float, substeps: int) -> None:
    timing = Timing(substep, substep * 10, longest)
    assert timing.substeps_per_node == substeps
    assert timing.node_spacing_s == substeps * substep
    assert abs(timing.node_spacing_s - longest) <= 0.5 * substep + 1e-12


@pytest.mark.parametrize("longest", [0.001, 0.0, -1.0, 0.26, math.inf, math.nan])
def test_a_spacing_out_of_range_is_refused(longest: float) -> None:
    with pytest.raises(
        ConfigurationError, match=r"^longest_node_s = .*: must be from the substep of 0.002 s to 0.25 s"
    ):
        Timing(longest_node_s=longest)


def test_a_table_of_another_spacing_is_refused() -> None:
    batch = Batch(load_helicopter("generic_tricycle"), 1, timing=Timing(longest_node_s=0.05))
    with pytest.raises(ConfigurationError, match=r"node spacing 0.25 s, must be 0.05 s"):
        batch.set_motion([Fixed().bake(1.0, 0.25)])


def test_a_deck_in_motion_is_the_same_on_fine_and_coarse_nodes() -> None:
    """Smooth motion: the coarse nodes are good enough, so the finer ones find the same loads."""
    peaks = []
    for longest in (0.25, 0.02):
        batch = Batch(load_helicopter("generic_tricycle"), 1, timing=Timing(longest_node_s=longest))
        spacing = batch.timing.node_spacing_s
        batch.set_motion([Sinusoid(dof="roll", amplitude_deg=6.0, period_s=6.0).bake(3.0, spacing)])
        batch.place(0.0, 0.0, 0.05)
        peaks.append(max(batch.advance([[0.3, 0.2]]).peak_max("probe_in_plane")[0] for _ in range(20)))
        with pytest.raises(ValueError, match="ends at 3 s"):
            batch.advance(intervals=11)
    assert peaks[0] == pytest.approx(peaks[1], rel=1e-4) and peaks[0] > 2000.0


def test_a_claw_that_trembles_at_five_hertz_needs_fine_nodes_and_gets_them() -> None:
    """Between nodes 0.02 s apart claw position and velocity are those asked for; 0.25 s apart they cannot be."""
    omega, size = 2.0 * math.pi * 5.0, 0.001
    errors = []
    for longest in (0.02, 0.25):
        timing = Timing(longest_node_s=longest, control_interval_s=0.01)
        batch = Batch(load_helicopter("generic_tricycle"), 1, timing=timing)
        batch.place(0.0, 0.0, 0.0)
        t = timing.node_spacing_s * np.arange(1.0 + 1.0 / timing.node_spacing_s)
        nodes = np.zeros((1, t.size, 9))
        nodes[0, :, 1] = size * np.sin(omega * t)
        nodes[0, :, 4] = size * omega * np.cos(omega * t)
        nodes[0, :, 7] = -size * omega**2 * np.sin(omega * t)
        batch.prescribe_claw(nodes)
        misses = []
        for k in range(1, 81):
            read = batch.advance()
            angle = omega * 0.01 * k
            misses.append(abs(read["claw_y"][0] - size * math.sin(angle)) / size)
            misses.append(abs(read["claw_vy"][0] - size * omega * math.cos(angle)) / (size * omega))
        errors.append(max(misses))
    assert errors[0] < 1e-4
    assert errors[1] > 0.1


def test_the_reference_reads_the_same_fine_nodes() -> None:
    timing = Timing(longest_node_s=0.02)
    batch = Batch(load_helicopter("generic_tricycle"), 1, timing=timing)
    batch.place(0.0, 0.0, 0.0)
    batch.set_motion([Sinusoid(dof="pitch", amplitude_deg=2.0, period_s=5.0).bake(2.0, timing.node_spacing_s)])
    nodes = np.zeros((1, 60, 9))
    nodes[0, :, 0] = np.random.default_rng(3).normal(size=60) * 1e-4
    batch.prescribe_claw(nodes)
    start = Problem(
        batch.state[:, 0].copy(), batch.parameters[:, 0], batch.mode, batch.nodes[0], batch.claw_nodes[0],
        np.zeros((4, 2)), timing.substep_s, timing.substeps, timing.substeps_per_node,
    )  # fmt: skip
    found = integrate(start, "Adams", rtol=1e-6)
    for k in range(4):
        batch.advance()
        for row in (Out.CLAW_X, Out.CLAW_VX, Out.DECK_PITCH, Out.DECK_WY):
            there = found.outputs[row, 50 * (k + 1)]
            assert batch.telemetry.outputs[row, 0] == pytest.approx(there, rel=1e-9, abs=1e-13)
    assert np.ptp(found.outputs[Out.CLAW_X]) > 1e-4
