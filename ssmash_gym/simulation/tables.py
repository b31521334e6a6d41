"""Node tables of what is prescribed to a batch: deck motion and gusts, on one spacing and one clock.

A store holds the tables of all columns, (N, nodes, 3 values): the values at each node, then their rates, then their
accelerations. After its last node a table stands still.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ssmash_gym.errors import ConfigurationError

Array = NDArray[np.float64]
Columns = NDArray[np.int64]
ENDLESS: Final = int(np.iinfo(np.int64).max)


class NodeTable(Protocol):
    """A baked table: nodes (n, 3 values) with `spacing_s` seconds between them."""

    @property
    def spacing_s(self) -> float:
        """Time between nodes [s]."""
        ...

    @property
    def nodes(self) -> Array:
        """Values, rates, accelerations, (n, 3 values)."""
        ...


def check_spacing(tables: Sequence[NodeTable], spacing_s: float, what: str) -> None:
    """Refuse tables of another node spacing than the batch's.

    Raises:
        ConfigurationError: a table's spacing is not `spacing_s`.
    """
    for table in tables:
        if abs(table.spacing_s - spacing_s) > 1e-9:
            raise ConfigurationError(f"{what} table: node spacing {table.spacing_s} s, must be {spacing_s} s")


def put(store: Array, columns: Columns, tables: Sequence[Array]) -> Array:
    """Write the nodes of `tables`, (n, 3 values) each, into the listed columns; returns the store, or a longer one."""
    store = lengthened(store, 1 + max((nodes.shape[0] for nodes in tables), default=1))  # a held node follows
    for k, nodes in zip(columns, tables, strict=True):
        count = nodes.shape[0]
        store[k, :count] = nodes
        _hold(store, k, count)
    return store


def take(store: Array, here: Columns, other: Array, there: Columns) -> Array:
    """Copy columns `there` of another store into columns `here`; returns the store, or a longer one."""
    count = other.shape[1]
    store = lengthened(store, count)
    store[here, :count] = other[there]
    _hold(store, here, count)
    return store


def lengthened(store: Array, nodes: int) -> Array:
    """The store with room for at least so many nodes."""
    if nodes <= store.shape[1]:
        return store
    longer = np.zeros((store.shape[0], nodes, store.shape[2]))
    count = store.shape[1]
    longer[:, :count] = store
    _hold(longer, np.arange(store.shape[0]), count)
    return longer


def _hold(store: Array, columns: Columns | int, count: int) -> None:
    """Let the tables of the columns stand still after their first `count` nodes."""
    values = store.shape[2] // 3
    store[columns, count:] = 0.0
    store[columns, count:, :values] = store[columns, count - 1 : count, :values]


def last_substep(nodes: Array, substeps_per_node: int) -> int:
    """Last substep that a table covers; a table that stands still from its start covers all."""
    values = nodes.shape[1] // 3
    still = not np.any(nodes[:, values:]) and np.all(nodes[:, :values] == nodes[0, :values])
    return ENDLESS if still else (nodes.shape[0] - 1) * substeps_per_node


def ended(column: int, deck: Columns, gusts: Columns, substep_s: float) -> ValueError:
    """Make the error of a helicopter whose tables are at their end.

    Args:
        column: which helicopter.
        deck: last substeps that the tables of deck motion cover, (N,).
        gusts: the same of the gust tables, (N,).
        substep_s: length of a substep [s].
    """
    end, what = min((int(deck[column]), "deck motion"), (int(gusts[column]), "gust table"))
    return ValueError(f"the {what} of helicopter {column} ends at {end * substep_s:g} s; bake a longer table")


def listed(columns: ArrayLike) -> Columns:
    """Columns given as indices, or as a mask of all, as an index array.

    Raises:
        ValueError: one is listed twice.
    """
    chosen = np.atleast_1d(np.asarray(columns))
    if chosen.dtype == np.bool_:
        return np.flatnonzero(chosen)
    rising = bool((chosen[1:] > chosen[:-1]).all())  # the usual case
    if not rising and np.unique(chosen).size < chosen.size:
        raise ValueError(f"columns {chosen.tolist()}: a helicopter must not be listed twice")
    return chosen.astype(np.int64)
