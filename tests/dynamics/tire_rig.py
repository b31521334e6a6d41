"""One tire on a rig: its kernel on rows of inputs, for the tire tests."""

from __future__ import annotations

from typing import Any

from ssmash_gym.dynamics.lane import kernel, load, store
from ssmash_gym.dynamics.layout import Tir
from ssmash_gym.dynamics.tire import tire
from ssmash_gym.dynamics.vectors import load3, store3


@kernel
def many(p: Any, x: Any, out: Any, model: int, friction: int, contact: int) -> None:
    """`tire` on the inputs in the 17 rows of `x`, its 17 results to `out`."""
    F, M, rates, reads = tire(
        p, 0, model, friction, contact, load3(x, 0), load(x, 3), load3(x, 4), load3(x, 7), load3(x, 10),
        load(x, 13), load(x, 14), load(x, 15), load(x, 16), load(p, Tir.MU),
    )  # fmt: skip
    store3(out, 0, F)
    store3(out, 3, M)
    store3(out, 6, rates)
    F_z, F_y, F_x, dz, d_y, d_x, psi, use = reads
    store3(out, 9, (F_z, F_y, F_x))
    store3(out, 12, (dz, d_y, d_x))
    store(out, 15, psi)
    store(out, 16, use)
