"""Lanes: every operator and primitive gives the bits of its NumPy definition; what is not a kernel is refused."""

from __future__ import annotations

import types
from enum import IntEnum
from typing import Any

import numba
import numpy as np
import pytest
from numba.core.errors import TypingError

from ssmash_gym.dynamics import channels, lane, layout
from ssmash_gym.dynamics.lane import (
    WIDTH,
    WIDTHS,
    any_lane,
    copysign,
    exponent,
    fabs,
    integer_bit,
    kernel,
    load,
    mantissa,
    maximum,
    minimum,
    of_width,
    pow2,
    splat,
    sqrt,
    store,
    uncompiled,
    where,
)

SPECIAL = np.array([0.0, -0.0, 1.0, -1.0, 5e-324, -1e-310, 2.2e-308, 1.7e308, -1.7e308, np.inf, -np.inf, np.nan])

compiled_only = pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="needs compiled kernels")


class Rows(IntEnum):
    """Rows of a table."""

    FIRST = 0
    THIRD = 2


class Others(IntEnum):
    """Rows of another table."""

    SECOND = 1


def block(values: np.ndarray) -> np.ndarray:
    """Values in rows of the widest lanes, the first repeated to fill them."""
    return np.ascontiguousarray(np.resize(values, (-(-values.size // max(WIDTHS)), max(WIDTHS))))


def pairs() -> tuple[np.ndarray, np.ndarray]:
    """All pairs of special values, and random ones over many magnitudes."""
    rng = np.random.default_rng(3)
    wide = rng.normal(size=(2, 400)) * 10.0 ** rng.uniform(-160, 150, (2, 400))
    near = rng.integers(-3, 4, (2, 400)).astype(float)
    a, b = (np.concatenate([part.ravel(), wide[k], near[k]]) for k, part in enumerate(np.meshgrid(SPECIAL, SPECIAL)))
    return block(a), block(b)


def same_bits(a: np.ndarray, b: np.ndarray) -> bool:
    """The same bits, any not-a-number being as good as another."""
    return bool(np.all((a.view(np.int64) == b.view(np.int64)) | (np.isnan(a) & np.isnan(b))))


def run_both(body: Any, *arguments: np.ndarray, rows: int, width: int = WIDTH) -> tuple[np.ndarray, np.ndarray]:
    """What a kernel ``body(*arguments, out)`` writes, `rows` for each of theirs: compiled for a width, and not."""
    tables = [table.reshape(-1, width) for table in arguments]
    results = []
    for form in (of_width(body, width), uncompiled(body)):
        out = np.zeros((rows * tables[0].shape[0], width))
        with np.errstate(all="ignore"):
            form(*tables, out)
        results.append(out)
    return results[0], results[1]


@kernel
def arithmetic(a: Any, b: Any, out: Any) -> None:
    for i in range(a.shape[0]):
        x = load(a, i)
        y = load(b, i)
        k = 12 * i
        store(out, k, x + y)
        store(out, k + 1, x - y)
        store(out, k + 2, x * y)
        store(out, k + 3, x / y)
        store(out, k + 4, -x)
        store(out, k + 5, 2 * x + 1)
        store(out, k + 6, (0.1 + x) * 3.0)
        store(out, k + 7, 1.0 / x - y / 3.0)
        store(out, k + 8, x * y + x)
        store(out, k + 9, (x + y) - x)
        total = splat(0.5)
        total += x
        total *= y
        total -= x
        total /= 7
        store(out, k + 10, total)
        store(out, k + 11, +x)


@kernel
def choices(a: Any, b: Any, out: Any) -> None:
    for i in range(a.shape[0]):
        x = load(a, i)
        y = load(b, i)
        k = 10 * i
        store(out, k, where(x < y, x, y))
        store(out, k + 1, where(x <= y, x, 2.0))
        store(out, k + 2, where(x > y, 1.0, 0))
        store(out, k + 3, where((x >= y) & (x > 0.0), x, 0.0))
        store(out, k + 4, where(~(x < y) | (1.0 > y), x, y))  # noqa: SIM300 - the float on the left is the point
        store(out, k + 5, minimum(x, y))
        store(out, k + 6, maximum(x, y))
        store(out, k + 7, minimum(maximum(x, -1.0), 1.0))
        store(out, k + 8, fabs(x))
        store(out, k + 9, copysign(x, y))


@kernel
def roots_and_bits(a: Any, whole: Any, out: Any) -> None:
    for i in range(a.shape[0]):
        x = load(a, i)
        n = load(whole, i)
        k = 7 * i
        store(out, k, sqrt(fabs(x)))
        store(out, k + 1, exponent(x))
        store(out, k + 2, mantissa(x))
        store(out, k + 3, pow2(n))
        store(out, k + 4, where(integer_bit(n, 0), 1.0, 0.0))
        store(out, k + 5, where(integer_bit(n, i % 12), 1.0, 0.0))
        store(out, k + 6, splat(1.0 / 3.0))


@kernel
def swap(pair: Any) -> Any:
    (a, b), mask = pair
    return (b, a), ~mask


@kernel
def tuples(a: Any, b: Any, out: Any) -> None:
    for i in range(a.shape[0]):
        vector = (load(a, i), load(b, i), splat(2.0))
        total = splat(0.0)
        for k in range(3):
            total = total + vector[k]
        (x, y), mask = swap((vector[:2], vector[0] > vector[1]))
        store(out, 3 * i, total)
        store(out, 3 * i + 1, where(mask, x, y))
        if any_lane(mask):
            store(out, 3 * i + 2, 1.0)


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("body, rows", [(arithmetic, 12), (choices, 10), (tuples, 3)])
def test_operators_give_the_bits_of_numpy(body: Any, rows: int, width: int) -> None:
    compiled, plain = run_both(body, *pairs(), rows=rows, width=width)
    assert same_bits(compiled, plain)
    assert np.unique(plain[np.isfinite(plain)]).size > 50


@pytest.mark.parametrize("width", WIDTHS)
def test_roots_and_bit_primitives_give_the_bits_of_numpy(width: int) -> None:
    a, _ = pairs()
    whole = block(np.resize(np.arange(-1022.0, 1024.0), a.size))
    compiled, plain = run_both(roots_and_bits, a, whole, rows=7, width=width)
    assert same_bits(compiled, plain)
    a, whole = a.reshape(-1, width), whole.reshape(-1, width)
    normal = np.isfinite(a) & (np.abs(a) >= 2.3e-308)
    m, e = np.frexp(np.abs(a[normal]))
    by_row = plain.reshape(-1, 7, width)
    np.testing.assert_array_equal(by_row[:, 1][normal], e - 1.0)
    np.testing.assert_array_equal(by_row[:, 2][normal], 2.0 * m)
    np.testing.assert_array_equal(by_row[:, 3], np.exp2(whole))
    np.testing.assert_array_equal(by_row[:, 4], whole % 2)


def test_minimum_and_maximum_return_the_second_of_equals_and_of_not_numbers() -> None:
    low, high = np.array([np.nan, 1.0, 0.0, -0.0]), np.array([1.0, np.nan, -0.0, 0.0])
    for choose in (minimum, maximum):
        assert same_bits(choose(low, high), high)


def test_a_loaded_row_does_not_follow_the_table() -> None:
    table = np.ones((2, WIDTH))
    row = load(table, 0)
    store(table, 0, 5.0)
    np.testing.assert_array_equal(row, 1.0)
    np.testing.assert_array_equal(table[0], 5.0)


@kernel
def one_row(table: Any, row: int) -> Any:
    return load(table, row) * 2.0


@kernel
def named_rows(table: Any, base: int, out: Any) -> None:
    store(out, 0, one_row(table, Rows.THIRD))
    store(out, 1, one_row(table, base + Others.SECOND))
    store(out, 2, one_row(table, 3))
    store(out, Rows.THIRD + 1, load(table, channels.StaOut.TIRE_TWIST))
    store(out, layout.Sta.IXZ + 1, load(table, base + channels.Out.PROBE_FY))
    if base == Others.SECOND:
        store(out, 5, load(table, Rows["THIRD"]))


@compiled_only
def test_rows_by_name_are_plain_integers_and_cost_one_version() -> None:
    table = np.arange(20.0 * WIDTH).reshape(20, WIDTH)
    out, plain = np.zeros((6, WIDTH)), np.zeros((6, WIDTH))
    named_rows(table, 1, out)
    uncompiled(named_rows)(table, 1, plain)
    np.testing.assert_array_equal(out, plain)
    wanted = [2 * table[2], 2 * table[2], 2 * table[3], table[6], table[2], table[2]]
    np.testing.assert_array_equal(out, wanted)
    assert len(one_row.inner.signatures) == 1


@compiled_only
def test_a_name_cannot_change_from_float_to_lane() -> None:
    @kernel
    def confused(table: Any) -> None:
        total = 0.0
        for k in range(2):
            total = total + load(table, k)
        store(table, 0, total)

    with pytest.raises(TypingError):
        confused(np.zeros((2, WIDTH)))


@compiled_only
@pytest.mark.parametrize(
    "table", [np.zeros((4, WIDTH), np.float32), np.zeros(4), np.zeros((WIDTH, 4)).T], ids=["single", "flat", "turned"]
)
def test_only_tables_of_contiguous_doubles_are_loaded(table: np.ndarray) -> None:
    @kernel
    def touch(rows: Any) -> None:
        store(rows, 0, load(rows, 1))

    with pytest.raises(TypingError):
        touch(table)


@compiled_only
def test_a_kernel_hands_out_no_array() -> None:
    @kernel
    def leak(table: Any) -> Any:
        return (1, table)

    with pytest.raises(TypingError, match="kernel leak returns an array"):
        leak(np.zeros((4, WIDTH)))


@compiled_only
@pytest.mark.parametrize("width", [WIDTH, max(WIDTHS)])
def test_no_instruction_may_be_fused_or_reordered(width: int) -> None:
    run_both(arithmetic, *pairs(), rows=12, width=width)
    (code,) = of_width(arithmetic, width).inspect_llvm().values()
    assert f"fmul <{width} x double>" in code
    for flag in (" fast ", "reassoc", "contract", "nnan", "arcp", "fmuladd", "llvm.fma"):
        assert flag not in code
    (assembly,) = of_width(arithmetic, width).inspect_asm().values()
    assert "vfmadd" not in assembly and "fmla" not in assembly


@compiled_only
@pytest.mark.parametrize("width", [WIDTH, max(WIDTHS)])
def test_the_stack_begins_at_a_cache_line(width: int) -> None:
    run_both(arithmetic, *pairs(), rows=12, width=width)
    (code,) = of_width(arithmetic, width).inspect_llvm().values()
    assert "alignstack=64" in code


@compiled_only
def test_tables_of_a_kernel_are_not_reference_counted() -> None:
    named_rows(np.zeros((20, WIDTH)), 1, np.zeros((6, WIDTH)))
    assert all("NRT_incref" not in code for code in named_rows.inspect_llvm().values())


@kernel
def twice(x: Any) -> Any:
    return x + x


@compiled_only
def test_uncompiled_twins_follow_calls_and_are_made_once() -> None:
    inner = twice

    @kernel
    def outer(x: Any) -> Any:
        return inner(twice(x))

    twin = uncompiled(outer)
    assert isinstance(twin, types.FunctionType)
    assert twin(1.5) == 6.0
    np.testing.assert_array_equal(twin(np.arange(3.0)), [0.0, 4.0, 8.0])
    assert twin.__globals__["twice"] is uncompiled(twice)
    assert uncompiled(outer) is twin


def test_primitives_take_single_floats() -> None:
    assert lane.where(np.True_, 1.0, 2.0) == 1.0
    assert float(pow2(-3.0)) == 0.125
    assert float(mantissa(-12.0)) == 1.5
    assert float(exponent(-12.0)) == 3.0
    assert bool(integer_bit(-1.0, 7))


def test_twins_of_a_width_follow_calls_and_are_made_once() -> None:
    inner = twice

    @kernel
    def outer(table: Any) -> None:
        store(table, 0, inner(twice(load(table, 1))))

    for width in WIDTHS:
        table = np.array([np.zeros(width), np.arange(1.0, width + 1.0)])
        of_width(outer, width)(table)
        np.testing.assert_array_equal(table[0], 4.0 * table[1])
        assert of_width(outer, width) is of_width(outer, width)
    assert of_width(outer, WIDTH) is outer


@compiled_only
def test_a_twin_has_a_twin_in_plain_python() -> None:
    table = np.ones((20, 8))
    out, plain = np.zeros((6, 8)), np.zeros((6, 8))
    wide = of_width(named_rows, 8)
    wide(table, 1, out)
    uncompiled(wide)(table, 1, plain)
    np.testing.assert_array_equal(out, plain)
    assert wide.py_func.__globals__["one_row"] is of_width(one_row, 8)
    assert len(of_width(one_row, 8).inner.signatures) == 1


@compiled_only
def test_widths_do_not_mix() -> None:
    wide_load = lane.OF_WIDTH[load][8]

    @kernel
    def mixed(table: Any) -> None:
        store(table, 0, load(table, 0) + wide_load(table, 1))

    @kernel
    def cut(table: Any) -> None:
        store(table, 0, wide_load(table, 1))

    for confused in (mixed, cut):
        with pytest.raises(TypingError):
            confused(np.zeros((4, 8)))


def test_a_wrong_width_is_named() -> None:
    with pytest.raises(ValueError, match="lane width 3: must be one of 1, 2, 4, 8"):
        of_width(twice, 3)
