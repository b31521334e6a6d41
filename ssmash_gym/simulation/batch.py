"""A batch of helicopters in time: place, settle, advance, read; save, restore and fork, bit for bit.

The single helicopter is the batch of one; there is no second implementation of the physics.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ssmash_gym.dynamics import engine
from ssmash_gym.dynamics.channels import OUTPUT_ROWS, Out
from ssmash_gym.dynamics.layout import PARAMETER_ROWS, STATE_ROWS, ClawDrive, Mode, State
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.simulation import settle as settling
from ssmash_gym.simulation import tables as node_tables
from ssmash_gym.simulation.claw import ClawLimits, history_nodes, write_drive, write_history
from ssmash_gym.simulation.parameters import Modes, common_mode, droop_state, parameter_column
from ssmash_gym.simulation.patch import DEFAULT_EDGE_M, Range, write_patch
from ssmash_gym.simulation.snapshot import Snapshot
from ssmash_gym.simulation.telemetry import Telemetry
from ssmash_gym.simulation.timing import Timing

if TYPE_CHECKING:
    from ssmash_gym.ship import MotionTable
    from ssmash_gym.ship.wind import GustTable
    from ssmash_gym.vehicle import Helicopter

Array = NDArray[np.float64]
Columns = NDArray[np.int64]
DECK_COLUMNS = 18
NO_GUST = np.zeros((2, 3))


class Batch:
    """N helicopters of one layout, each with its own parameters, deck motion and clock.

    Args:
        helicopters: one description, or one for each column (all of the same layout: station kinds, springs, tires).
        count: number of columns when one description is given.
        timing: substep and control interval.
        modes: choices of model (tire contact point, friction limit, probe law).
        claw: limits of the claw drive, the same for all columns; edit `parameters` to randomise.
        threads: workers for a call; results do not depend on it.
        longest_delay_s: longest command delay that any column will have (never less than the claw's own).

    Attributes:
        state: (STATE_ROWS, N), rows `layout.State`; parameters: (PARAMETER_ROWS, N), rows `layout.Par`.

    Raises:
        ConfigurationError: the descriptions differ in layout.
    """

    _SAVED = ("state", "parameters", "_commands", "clocks", "_nodes", "_ends", "_gust_nodes", "_gust_ends",
              "_claw_nodes", "_outputs", "_highs", "_lows", "_mode")  # fmt: skip

    def __init__(
        self,
        helicopters: Helicopter | Sequence[Helicopter],
        count: int | None = None,
        *,
        timing: Timing | None = None,
        modes: Modes | None = None,
        claw: ClawLimits | None = None,
        threads: int = 1,
        longest_delay_s: float = 0.2,
    ) -> None:
        if isinstance(helicopters, Sequence):
            fleet = list(helicopters)
        else:
            fleet = [helicopters] * (1 if count is None else count)
        if not fleet or (count is not None and count != len(fleet)):
            raise ConfigurationError(f"count = {count}: must be at least 1, and is not needed beside a list")
        self.helicopters = fleet
        self.timing = timing or Timing()
        self.modes = modes or Modes()
        self.claw = claw or ClawLimits()
        self.threads = threads
        self.n = len(fleet)
        self._mode = common_mode(fleet, self.modes)
        self.state: Array = np.zeros((STATE_ROWS, self.n))
        self.parameters: Array = np.zeros((PARAMETER_ROWS, self.n))
        self.longest_delay_s = max(longest_delay_s, self.claw.delay_s)
        history = int(np.ceil(self.longest_delay_s / self.timing.control_interval_s - 1e-9)) + 1
        self._commands: Array = np.zeros((2 * history, self.n))
        self.clocks: Columns = np.zeros(self.n, np.int64)
        self._nodes: Array = np.zeros((self.n, 2, DECK_COLUMNS))
        self._ends: Columns = np.full(self.n, node_tables.ENDLESS)  # last substep each table covers
        self._gust_nodes: Array = np.zeros((self.n, *NO_GUST.shape))
        self._gust_ends: Columns = np.full(self.n, node_tables.ENDLESS)
        self._claw_nodes: Array = np.zeros((self.n, 2, 9))
        self._outputs: Array = np.zeros((OUTPUT_ROWS, self.n))
        self._highs: Array = np.zeros((OUTPUT_ROWS, self.n))
        self._lows: Array = np.zeros((OUTPUT_ROWS, self.n))
        self.describe(fleet)

    # --- what the columns are ------------------------------------------------------------------------------

    def describe(self, helicopters: Sequence[Helicopter], columns: ArrayLike | None = None) -> None:
        """Fill the parameters of the listed columns from descriptions and put them at full droop, claw at rest.

        Raises:
            ConfigurationError: a description has another layout than the batch.
        """
        chosen = self.columns(columns)
        if np.any(common_mode(list(helicopters), self.modes)[: Mode.CLAW] != self._mode[: Mode.CLAW]):
            raise ConfigurationError("a helicopter has another layout (stations, springs, tires) than its batch")
        made: dict[int, tuple[Array, Array]] = {}  # most batches hold one description many times
        for k, helicopter in zip(chosen, helicopters, strict=True):
            if id(helicopter) not in made:
                made[id(helicopter)] = parameter_column(helicopter), droop_state(helicopter)
            self.helicopters[k] = helicopter
            self.parameters[:, k], self.state[:, k] = made[id(helicopter)]
            self.claw.fill(self.parameters[:, k], self.timing.substep_s)
        self.clocks[chosen] = 0
        self._commands[:, chosen] = 0.0

    def columns(self, columns: ArrayLike | None) -> Columns:
        """The listed columns (indices, or a mask of all) as an index array; None means all."""
        return np.arange(self.n) if columns is None else node_tables.listed(columns)

    @property
    def time_s(self) -> Array:
        """Time since the start of each column's deck-motion table [s], (N,)."""
        return np.asarray(self.clocks * self.timing.substep_s, dtype=np.float64)

    @property
    def nodes(self) -> Array:
        """Deck-motion nodes, (N, nodes, 18)."""
        return self._nodes

    @property
    def claw_nodes(self) -> Array:
        """Nodes of a prescribed claw, (N, nodes, 9): x, y, z in S [m], their rates and accelerations."""
        return self._claw_nodes

    @property
    def mode(self) -> Columns:
        """The integers that say what kind of helicopter and model this batch holds, (MODES,)."""
        return self._mode

    @property
    def gust_nodes(self) -> Array:
        """Nodes of the gust speed [m/s], its rate and acceleration, (N, nodes, 3); zero where there is no gust."""
        return self._gust_nodes

    def set_motion(self, tables: Sequence[MotionTable], columns: ArrayLike | None = None) -> None:
        """Give each listed column its deck motion; its clock starts anew.

        Commands not yet acted on and earlier gusts are dropped: `set_gusts` comes after.

        Raises:
            ConfigurationError: a table's node spacing is not the batch's (`Timing.node_spacing_s`).
        """
        chosen = self.columns(columns)
        node_tables.check_spacing(tables, self.timing.node_spacing_s, "deck-motion")
        self._nodes = node_tables.put(self._nodes, chosen, [table.nodes for table in tables])
        self._ends[chosen] = [node_tables.last_substep(t.nodes, self.timing.substeps_per_node) for t in tables]
        self._gust_nodes[chosen] = 0.0
        self._gust_ends[chosen] = node_tables.ENDLESS
        self.clocks[chosen] = 0
        self._commands[:, chosen] = 0.0

    def set_gusts(self, tables: Sequence[GustTable | None] | None, columns: ArrayLike | None = None) -> None:
        """Give each listed column its gusts, on the clock of its deck motion.

        The wind is ``WIND + g(t) GUST``, g the table's gust speed and `Par.GUST` the direction it blows in: rows of
        `parameters` that the caller sets beside `Par.WIND`.

        Args:
            tables: one a column, None for a column without gusts; None in all means that no listed column has any.
            columns: helicopters; None means all.

        Raises:
            ConfigurationError: a table's node spacing is not the batch's (`Timing.node_spacing_s`).
        """
        chosen = self.columns(columns)
        given = [None] * chosen.size if tables is None else list(tables)
        node_tables.check_spacing([table for table in given if table is not None], self.timing.node_spacing_s, "gust")
        nodes = [NO_GUST if table is None else table.nodes for table in given]
        self._gust_nodes = node_tables.put(self._gust_nodes, chosen, nodes)
        self._gust_ends[chosen] = [node_tables.last_substep(n, self.timing.substeps_per_node) for n in nodes]

    def prescribe_claw(self, nodes: ArrayLike) -> None:
        """Replace the commanded claw by a prescribed history for the whole batch.

        Args:
            nodes: (N, nodes, 9): x, y, z of the claw centre in S [m], their rates and accelerations, at the node
                spacing of the batch from the start of the deck-motion table; the last node is held.

        Raises:
            ConfigurationError: the nodes have another shape.
        """
        self._claw_nodes = history_nodes(nodes, self.n)
        self._mode[Mode.CLAW] = ClawDrive.PRESCRIBED

    def set_patch(
        self, x_m: Range, y_m: Range, factor: float, edge_m: float = DEFAULT_EDGE_M, columns: ArrayLike | None = None
    ) -> None:
        """Give the deck of the listed columns a rectangle of other tire friction; see `dynamics.patch`.

        Args:
            x_m: from and to along the track, S axes [m].
            y_m: from and to across the track [m].
            factor: friction coefficient there over that elsewhere; 1 takes an earlier patch away.
            edge_m: width inside the border over which the friction changes [m].
            columns: helicopters; None means all.

        Raises:
            ConfigurationError: the rectangle is empty or narrower than its two edges, or the factor is negative.
        """
        write_patch(self.parameters, self.columns(columns), x_m, y_m, factor, edge_m)
        self._mode[Mode.PATCH] = 1

    # --- where they are ------------------------------------------------------------------------------------

    def place(self, x: ArrayLike, y: ArrayLike, yaw: ArrayLike, columns: ArrayLike | None = None) -> Array:
        """Settle the listed columns on the deck as it stands, probe point over (x, y), and bring the claw there.

        What wheels that roll leave to a captured probe (a sloping deck) deflects it, and the probe point with it.

        Args:
            x: position of the probe point along the track [m], scalar or (n,).
            y: the same across the track [m].
            yaw: heading relative to the track [rad].
            columns: helicopters; None means all.

        Returns:
            Largest remaining acceleration of each column [m/s2 or rad/s2], (n,); see `settle`.
        """
        chosen = self.columns(columns)
        for k, helicopter in enumerate(self.helicopters):
            if k in chosen:
                self.state[:, k] = droop_state(helicopter)
        half = 0.5 * np.broadcast_to(np.asarray(yaw, dtype=np.float64), chosen.shape)
        self._commands[:, chosen] = 0.0
        self.state[State.Q11, chosen] = np.cos(half)
        self.state[State.Q14, chosen] = np.sin(half)
        return settling.place(self, chosen, np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64))

    def settle(self, columns: ArrayLike | None = None) -> Array:
        """Bring the listed columns to rest on the deck as it stands now; see `ssmash_gym.simulation.settle`.

        Returns:
            Largest remaining acceleration of each column, (n,): large where no equilibrium exists (a helicopter
            free to roll down a sloping deck).
        """
        return settling.settle(self, self.columns(columns))

    def evaluate(self, columns: ArrayLike | None = None) -> Telemetry:
        """Read the outputs of the state as it stands, without advancing; extremes are the instant's values."""
        chosen = self.columns(columns)
        decks = self.deck_rows(chosen)
        _, outputs = self.derivative(self.state[:, chosen], self.parameters[:, chosen], decks)
        for table in (self._outputs, self._highs, self._lows):
            table[:, chosen] = outputs
        return self.telemetry

    def derivative(self, state: Array, parameters: Array, decks: Array) -> tuple[Array, Array]:
        """`engine.derivative` of any columns of this layout, by the kernel that this batch has compiled already."""
        return engine.derivative(state, parameters, self._mode, decks, engine.lane_width(self.n))

    def deck_rows(self, columns: Columns) -> Array:
        """`layout.Deck` rows of the listed columns at their present time, (DECK_ROWS, n)."""
        spacing = self.timing.node_spacing_s
        decks = np.zeros((len(engine.deck_rows(self._nodes[:1], 0.0, spacing)), columns.size))
        for time in np.unique(self.clocks[columns]):
            same = np.flatnonzero(self.clocks[columns] == time)
            decks[:, same] = engine.deck_rows(self._nodes[columns[same]], time * self.timing.substep_s, spacing)
        if self._mode[Mode.CLAW] == ClawDrive.PRESCRIBED:
            write_history(self._claw_nodes[columns], self.clocks[columns], self.timing.substeps_per_node,
                          self.timing.substep_s, decks)  # fmt: skip
        else:
            write_drive(self.state[:, columns], self.parameters[:, columns], self.time_s[columns], decks)
        pieces, since = np.divmod(self.clocks[columns], self.timing.substeps_per_node)
        engine.write_wind(self.parameters[:, columns], self._gust_nodes[columns], pieces,
                          since * self.timing.substep_s, spacing, decks)  # fmt: skip
        return decks

    # --- time ------------------------------------------------------------------------------------------------

    def advance(
        self, command: ArrayLike | None = None, columns: ArrayLike | None = None, *, intervals: int = 1
    ) -> Telemetry:
        """Advance the listed columns by one control interval (or `intervals` of them) under one claw command.

        Args:
            command: (n, 2) normalised claw velocity, along and across the track; None holds the claw. Values
                beyond +-1 are the caller's fault.
            columns: helicopters; None means all.
            intervals: whole control intervals to run under the same command; extremes cover all of them.

        Returns:
            The telemetry of the whole batch; only the listed columns have changed.

        Raises:
            ValueError: a command is not finite or beyond +-1, there is no interval to run, or a table ends before
                the last one does.
        """
        if self._mode[Mode.CLAW] == ClawDrive.PRESCRIBED and self._claw_nodes.shape[1] == 2:
            raise ConfigurationError("modes.claw = 'prescribed': give the claw's history by prescribe_claw first")
        chosen = self.columns(columns)
        values = np.zeros((chosen.size, 2)) if command is None else np.asarray(command, dtype=np.float64)
        if values.shape != (chosen.size, 2) or not (np.abs(values) <= 1.0).all():
            raise ValueError(f"claw command: must be ({chosen.size}, 2) numbers within -1 to 1, got {values!r}")
        if intervals < 1:
            raise ValueError(f"intervals: must be at least 1, got {intervals}")
        pick = slice(None) if columns is None else chosen  # a slice spares the copies of a whole batch
        substeps = self.timing.substeps
        late = self.clocks[pick] + substeps * intervals > np.minimum(self._ends, self._gust_ends)[pick]
        if late.any():
            raise node_tables.ended(int(chosen[np.argmax(late)]), self._ends, self._gust_ends, self.timing.substep_s)
        parts = self._parts(values.T, chosen, intervals)
        highs, lows = [], []
        for part in parts:
            self._commands[2:, pick] = self._commands[:-2, pick]
            self._commands[:2, pick] = values.T
            engine.advance(
                self.state, self.parameters, self._commands, self._mode, self._nodes, self._claw_nodes,
                self._gust_nodes, self.clocks, chosen, part * substeps, self.timing.substep_s,
                self.timing.substeps_per_node, self._outputs, self._highs, self._lows, self.threads,
            )  # fmt: skip
            if len(parts) > 1:
                highs.append(self._highs[:, chosen])
                lows.append(self._lows[:, chosen])
        if highs:
            self._highs[:, chosen], self._lows[:, chosen] = np.max(highs, axis=0), np.min(lows, axis=0)
        return self.telemetry

    def _parts(self, command: Array, chosen: Columns, intervals: int) -> list[int]:
        """Intervals of each call: single ones while older commands, or fewer of this one, wait in the delay line."""
        history = self._commands.shape[0] // 2
        if intervals == 1 or np.array_equal(self._commands[:, chosen], np.tile(command, (history, 1))):
            return [intervals]
        singles = min(history - 1, intervals - 1)
        return [1] * singles + [intervals - singles]

    @property
    def telemetry(self) -> Telemetry:
        """Views of the batch's tables; reading a channel copies it."""
        return Telemetry(self.state, self._outputs, self._highs, self._lows)

    @property
    def diverged(self) -> NDArray[np.bool_]:
        """Columns whose state was held because the next one was not finite or absurd, (N,)."""
        return np.asarray(self.state[State.DIVERGED] > 0.5)

    # --- copies ------------------------------------------------------------------------------------------------

    def snapshot(self) -> Snapshot:
        """Copy of the complete state."""
        return Snapshot({name: getattr(self, name).copy() for name in self._SAVED}, tuple(self.helicopters))

    def restore(self, snapshot: Snapshot) -> None:
        """Return to a snapshot of this batch (or of one of the same size and layout), bit for bit.

        Raises:
            ConfigurationError: the snapshot is of another size.
        """
        if len(snapshot.helicopters) != self.n:
            raise ConfigurationError(f"snapshot of {len(snapshot.helicopters)} helicopters: must be of {self.n}")
        self.helicopters = list(snapshot.helicopters)
        for name, array in snapshot.arrays.items():
            setattr(self, name, array.copy())

    def take(self, other: Batch, source: ArrayLike, target: ArrayLike) -> None:
        """Make the `target` columns of this batch copies of the `source` columns of another, clocks and decks included.

        Raises:
            ConfigurationError: the other batch has another layout, timing, or length of command history.
        """
        here, there = self.columns(target), other.columns(source)
        if other.timing != self.timing or other._commands.shape[0] != self._commands.shape[0]:
            raise ConfigurationError("columns can only be taken from a batch of the same timing and longest delay")
        if np.any(other._mode != self._mode) or other._claw_nodes.shape[1] != self._claw_nodes.shape[1]:
            raise ConfigurationError("columns can only be taken from a batch of the same layout and modes")
        self._nodes = node_tables.take(self._nodes, here, other._nodes, there)
        self._gust_nodes = node_tables.take(self._gust_nodes, here, other._gust_nodes, there)
        for name in ("state", "parameters", "_commands", "_outputs", "_highs", "_lows"):
            getattr(self, name)[:, here] = getattr(other, name)[:, there]
        for name in ("clocks", "_ends", "_gust_ends", "_claw_nodes"):
            getattr(self, name)[here] = getattr(other, name)[there]
        for k, i in zip(here, there, strict=True):
            self.helicopters[k] = other.helicopters[i]

    def fork(self, k: int) -> Batch:
        """A new batch with every column repeated `k` times (column i becomes i k ... i k + k - 1), same state."""
        copies = np.repeat(np.arange(self.n), k)
        other = Batch(
            [self.helicopters[i] for i in copies], timing=self.timing, modes=self.modes, claw=self.claw,
            threads=self.threads, longest_delay_s=self.longest_delay_s,
        )  # fmt: skip
        other.restore(self.snapshot().of_columns(copies))
        return other


__all__ = ["Batch", "ClawLimits", "Modes", "Out", "Snapshot", "Timing"]
