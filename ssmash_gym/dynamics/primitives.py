"""The few operations on numbers that have two definitions: this one in NumPy, and one in vector instructions.

Every function here is a *primitive*: its Python body is the NumPy definition, for arrays of shape ``(W,)`` as well
as for single numbers, and `ssmash_gym.dynamics.lowering` gives the same name a compiled form on lanes. Both give the
same bits: each primitive is one exactly rounded IEEE-754 operation, a comparison, a selection or bit arithmetic.
Everything above (`ssmash_gym.dynamics.maths` and the kernels) is written once, on top of these and of the operators
``+ - * /``, unary ``-``, ``< <= > >=`` on numbers and ``& | ~`` on masks.
"""

from __future__ import annotations

from types import FunctionType
from typing import Any, Final

import numpy as np

__all__ = [
    "OF_WIDTH",
    "WIDTH",
    "WIDTHS",
    "any_lane",
    "copysign",
    "exponent",
    "fabs",
    "integer_bit",
    "load",
    "mantissa",
    "maximum",
    "minimum",
    "pow2",
    "splat",
    "sqrt",
    "store",
    "where",
]


WIDTH: Final = 4  # numbers in a lane
WIDTHS: Final = (1, 2, 4, 8)  # of all lanes there are

ROUNDER: Final = 6755399441055744.0  # 1.5 * 2**52: adding it leaves the nearest integer in the low bits
BIAS: Final = 1023  # of the exponent field
FRACTION_BITS: Final = 52
FRACTION: Final = (1 << FRACTION_BITS) - 1
EXPONENT_FIELD: Final = 0x7FF
ONE: Final = 0x3FF0000000000000  # bits of 1.0
TWO_52: Final = 0x4330000000000000  # bits of 2**52


def load(block: Any, row: int) -> Any:
    """Number in row ``row`` of a C-contiguous float64 array ``(rows, WIDTH)``; a copy, not a view."""
    return block[row].copy()


def store(block: Any, row: int, value: Any) -> None:
    """Write a number (or one float for all) to row ``row`` of a C-contiguous float64 array ``(rows, WIDTH)``."""
    block[row] = value


def splat(value: float) -> Any:
    """Number that is ``value`` in every lane."""
    return np.float64(value)


def _copies(primitive: Any) -> dict[int, FunctionType]:
    """The primitive for each width: itself for `WIDTH`, a copy with a name of its own for every other."""
    names = {width: f"{primitive.__name__}_{width}" for width in WIDTHS if width != WIDTH}
    copies = {width: FunctionType(primitive.__code__, globals(), name) for width, name in names.items()}
    globals().update({copy.__name__: copy for copy in copies.values()})  # Numba looks for them here
    return {WIDTH: primitive, **copies}


# What makes a lane of something else, or of a float: nothing but these fixes the width of compiled lanes.
OF_WIDTH: Final = {primitive: _copies(primitive) for primitive in (load, store, splat)}


def where(mask: Any, a: Any, b: Any) -> Any:
    """``a`` where the mask holds, else ``b``. Both are computed in any case."""
    return np.where(mask, a, b)[()]


def minimum(a: Any, b: Any) -> Any:
    """``a`` where ``a < b``, else ``b``: ``b`` where one is not a number or both are zero."""
    return np.where(np.less(a, b), a, b)[()]


def maximum(a: Any, b: Any) -> Any:
    """``a`` where ``a > b``, else ``b``: ``b`` where one is not a number or both are zero."""
    return np.where(np.greater(a, b), a, b)[()]


def fabs(a: Any) -> Any:
    """Magnitude (clears the sign bit)."""
    return np.fabs(a)


def copysign(a: Any, b: Any) -> Any:
    """Magnitude of ``a`` with the sign bit of ``b``."""
    return np.copysign(a, b)


def sqrt(a: Any) -> Any:
    """Exactly rounded square root; the caller guards against negative numbers."""
    return np.sqrt(a)


def any_lane(mask: Any) -> bool:
    """Whether the mask holds in any lane; only for skipping rare work, never for choosing a result."""
    return bool(np.any(mask))


def pow2(n: Any) -> Any:
    """``2**n`` of a whole number ``-1022 <= n <= 1023``."""
    return ((np.add(n, ROUNDER).view(np.int64) + BIAS) << FRACTION_BITS).view(np.float64)


def integer_bit(n: Any, bit: int) -> Any:
    """Mask: bit ``bit`` (two's complement, 0 the lowest) of a whole number ``|n| < 2**51`` is set."""
    return (np.add(n, ROUNDER).view(np.int64) << (63 - bit)) < 0


def exponent(a: Any) -> Any:
    """``floor(log2 |a|)`` of a normal number, as a number (-1023 for zero and subnormals)."""
    field = (np.asarray(a, dtype=np.float64).view(np.int64) >> FRACTION_BITS) & EXPONENT_FIELD
    return ((field | TWO_52).view(np.float64) - (4503599627370496.0 + BIAS))[()]


def mantissa(a: Any) -> Any:
    """``|a| / 2**exponent(a)`` of a normal number, in [1, 2)."""
    bits = np.asarray(a, dtype=np.float64).view(np.int64)
    return ((bits & FRACTION) | ONE).view(np.float64)[()]
