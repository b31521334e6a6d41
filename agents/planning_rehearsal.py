"""Rehearsals: copies of running helicopters on which sampled plans are tried out, by the simulation itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from ssmash_gym.agents.planning_law import Drive, Seen

from ssmash_gym.dynamics.layout import Par, State
from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.simulation.batch import Batch, Snapshot, Timing

Array = NDArray[np.float64]
Columns = NDArray[np.int64]
_KEPT = 3  # batches of different sizes that wait for the next rehearsal
DIVERGED_N = 1e6  # load that a helicopter counts with once its numbers have failed


@dataclass(frozen=True)
class Outcome:
    """What rehearsals gave, one row an interval; shape (intervals, copies, helicopters) each.

    Attributes:
        load_N: Largest in-plane probe load within the interval.
        force_x_N: Probe force on the helicopter at its end, H axes, x.
        force_y_N: The same, y.
        yaw_rad: Heading relative to the track at its end.
        probe_y_m: Probe point across the track at its end.
        claw_y_m: Claw across the track at its end.
        lag_m: How far the claw is behind its schedule at its end.
    """

    load_N: Array
    force_x_N: Array
    force_y_N: Array
    yaw_rad: Array
    probe_y_m: Array
    claw_y_m: Array
    lag_m: Array


class Rehearsal:
    """Tries plans on copies of a running batch's helicopters.

    The copies have the whole state of the helicopters, their parameters and the commands still under way. The kernel
    is the simulation's own, on a coarser step.

    Args:
        core: The batch whose helicopters are copied; it is never changed.
        drive: The law that a plan is added to.
        substep_s: Step of the copies [s]; it must divide the deck table's node spacing.
        nominal: Copies get the helicopter as described and the task's claw instead of their own parameters.
    """

    def __init__(self, core: TraverseBatch, drive: Drive, substep_s: float, *, nominal: bool = False) -> None:
        self._core = core
        self._drive = drive
        self._timing = Timing(substep_s, core.control_interval_s)
        self._nominal = nominal
        self._spare: dict[int, Batch] = {}

    def run(
        self,
        rows: Columns,
        nodes: Array,
        gust_nodes: Array,
        plans: Array,
        steps: Columns,
        intervals: int,
    ) -> Outcome:
        """Drive copies of the listed helicopters by their plans.

        Args:
            rows: Helicopters, (n,).
            nodes: Deck motion from the last node that each has passed, (n, m, 18).
            gust_nodes: Gusts from the same node, (n, m, 3).
            plans: Knots [m/s], (copies, n, knots, 2).
            steps: Control intervals since each one's start, (n,).
            intervals: How many to rehearse.
        """
        copies, n = plans.shape[:2]
        batch = self._forked(rows, nodes, gust_nodes, copies)
        flat = plans.reshape(copies * n, *plans.shape[2:])
        now = np.tile(steps, copies)
        found = np.zeros((7, intervals, copies * n))
        seen = seen_of(batch)
        for k in range(intervals):
            planned = self._drive.planned(flat, now)
            batch.advance(self._drive.commands(seen, now, planned))
            now = now + 1
            seen = seen_of(batch)
            telemetry = batch.telemetry
            found[0, k] = np.where(batch.diverged, DIVERGED_N, telemetry.peak_max("probe_in_plane"))
            found[1, k], found[2, k] = telemetry["probe_fx"], seen.force_N
            found[3, k], found[4, k], found[5, k] = seen.yaw_rad, telemetry["probe_y"], seen.claw_y_m
            found[6, k] = self._drive.place(now * self._drive.task.control_interval_s) - seen.claw_x_m
        return Outcome(*found.reshape(7, intervals, copies, n))

    def _forked(self, rows: Columns, nodes: Array, gust_nodes: Array, copies: int) -> Batch:
        """A batch of `copies` copies of the listed helicopters, the copy first, on the coarser step."""
        core = self._core.batch
        count = copies * rows.size
        if count not in self._spare:
            if len(self._spare) == _KEPT:
                self._spare.clear()
            self._spare[count] = self._blank(count)
        batch = self._spare[count]
        arrays = dict(core.snapshot().arrays)
        per_node = core.timing.substeps_per_node
        passed = core.clocks[rows] // per_node
        shift_s = np.asarray(passed * core.timing.node_spacing_s, dtype=np.float64)
        since = core.clocks[rows] - passed * per_node
        length = (nodes.shape[1] - 1) * self._timing.substeps_per_node
        parameters = (self._nominal_parameters(rows) if self._nominal else core.parameters[:, rows]).copy()
        parameters[Par.RIPPLE_PHASE] += parameters[Par.RIPPLE_OMEGA] * shift_s
        own = {
            "parameters": parameters,
            "clocks": np.rint(since * (core.timing.substep_s / self._timing.substep_s)).astype(np.int64),
            "_nodes": nodes,
            "_ends": np.full(rows.size, length),
            "_gust_nodes": gust_nodes,
            "_gust_ends": np.full(rows.size, length),
        }
        for name, array in arrays.items():
            if name in own:
                arrays[name] = own[name]
            elif name == "_claw_nodes":
                arrays[name] = array[rows]
            elif name != "_mode":
                arrays[name] = array[:, rows]
        helicopters = tuple(core.helicopters[k] for k in rows)
        batch.restore(Snapshot(arrays, helicopters).of_columns(np.tile(np.arange(rows.size), copies)))
        return batch

    def _blank(self, count: int) -> Batch:
        core = self._core.batch
        return Batch(
            core.helicopters[0], count, timing=self._timing, modes=core.modes, claw=core.claw,
            threads=self._core.threads, longest_delay_s=core.longest_delay_s,
        )  # fmt: skip

    def _nominal_parameters(self, rows: Columns) -> Array:
        """The helicopter as described, the task's claw; the mean wind is measured, gusts go by their own nodes."""
        plain = self._core.starter.batch(rows.size, 1).parameters
        true = self._core.batch.parameters
        for row in (Par.WIND, Par.GUST):
            plain[row : row + 3] = true[row : row + 3, rows]
        return plain


def seen_of(batch: Batch) -> Seen:
    """What the law reads, from the simulation's own channels."""
    told, state = batch.telemetry, batch.state
    return Seen(told["probe_fy"], told["yaw"], np.array(state[State.CLAW_X]), np.array(state[State.CLAW_Y]))
