"""Kernels: the decorator, the primitives by one name, and the twins of every kernel.

A kernel is a function of *numbers*: lanes when compiled (`WIDTH` doubles worked on together), NumPy arrays of shape
``(W,)`` or single floats when not. The same source gives the same bits both ways. With the environment variable
``NUMBA_DISABLE_JIT=1`` every kernel is plain Python. Twins are made from one kernel and all that it calls:
`uncompiled` gives its plain Python beside the compiled kernel, `of_width` the kernel on lanes of another width.
"""

# Numba is typed in part only.
# mypy: disable-error-code="attr-defined"
from __future__ import annotations

import functools
from collections.abc import Callable
from types import CellType, CodeType, FunctionType
from typing import Any

import numba
from numba.core.dispatcher import Dispatcher

from ssmash_gym.dynamics.compiler import KernelDispatcher
from ssmash_gym.dynamics.primitives import (
    OF_WIDTH,
    WIDTH,
    WIDTHS,
    any_lane,
    copysign,
    exponent,
    fabs,
    integer_bit,
    load,
    mantissa,
    maximum,
    minimum,
    pow2,
    splat,
    sqrt,
    store,
    where,
)

__all__ = [
    "WIDTH",
    "any_lane",
    "copysign",
    "exponent",
    "fabs",
    "integer_bit",
    "kernel",
    "load",
    "mantissa",
    "maximum",
    "minimum",
    "of_width",
    "pow2",
    "splat",
    "sqrt",
    "store",
    "uncompiled",
    "where",
]


def kernel(function: Callable[..., Any]) -> Any:
    """Compile a function of numbers, of tuples of them, of arrays and of plain integers.

    No fast-math flag is set: the bits are those of the uncompiled function. The compiled function does not hold the
    interpreter lock. With ``NUMBA_DISABLE_JIT=1`` the function is returned as it is.
    """
    if numba.config.DISABLE_JIT:
        return function
    return KernelDispatcher(function)


@functools.cache
def uncompiled(compiled: Any) -> Callable[..., Any]:
    """Plain Python of a kernel, in which every kernel it calls is plain Python too.

    Kernels are followed through the global and enclosing names that the function uses (``from ... import name``; not
    through attributes of modules). The twin works on NumPy arrays of shape ``(W,)`` for any ``W``, and on floats.
    A plain function is rebuilt in the same way.
    """
    return _rebuilt(compiled, lambda value: uncompiled(value) if isinstance(value, Dispatcher) else value)


@functools.cache
def of_width(compiled: Any, width: int) -> Any:
    """Twin of a kernel, compiled for lanes of another width; the bits are the same, only the speed is not.

    All tables that it loads rows from or stores rows to must have ``width`` columns. Kernels are followed as by
    `uncompiled`. The kernel itself for `WIDTH`; a plain function (``NUMBA_DISABLE_JIT=1``) works for all widths.

    Raises:
        ValueError: there are no lanes of this width.
    """
    if width not in WIDTHS:
        raise ValueError(f"lane width {width}: must be one of {', '.join(map(str, WIDTHS))}")
    if width == WIDTH or not isinstance(compiled, Dispatcher):
        return compiled

    def replace(value: Any) -> Any:
        if isinstance(value, FunctionType) and value in OF_WIDTH:
            return OF_WIDTH[value][width]
        return of_width(value, width) if isinstance(value, Dispatcher) else value

    twin = _rebuilt(compiled, replace)
    twin.__qualname__ += f"_{width}"  # names the machine code, in memory and on disk
    return KernelDispatcher(twin)


def _rebuilt(compiled: Any, replace: Callable[[Any], Any]) -> FunctionType:
    """Plain Python function of a kernel, every global and enclosing value that it uses replaced."""
    function: FunctionType = compiled.py_func if isinstance(compiled, Dispatcher) else compiled
    names = _names(function.__code__) & function.__globals__.keys()
    namespace = dict(function.__globals__)
    namespace.update({name: replace(namespace[name]) for name in names})
    closure = tuple(CellType(replace(cell.cell_contents)) for cell in function.__closure__ or ())
    twin = FunctionType(function.__code__, namespace, function.__name__, function.__defaults__, closure)
    twin.__kwdefaults__ = function.__kwdefaults__
    functools.update_wrapper(twin, function)
    return twin


def _names(code: CodeType) -> set[str]:
    """Global names used by a function and by the functions defined inside it."""
    names = set(code.co_names)
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            names |= _names(constant)
    return names
