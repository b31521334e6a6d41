"""Lanes for Numba: the types, how operators and primitives are typed, and the vector instructions they become.

A lane is an LLVM vector of `WIDTH` doubles, a mask one of `WIDTH` bits. Operators are registered as typing templates
with one lowering each, which compiles several times faster than overloads; the templates say they are for the CPU
target, so that Numba tries them before its own for the same operator. No instruction carries a fast-math flag: nothing
is contracted or re-associated, and the bits are those of the NumPy definitions in `ssmash_gym.dynamics.primitives`.
"""

# Numba is typed in part only.
# mypy: disable-error-code="misc, no-untyped-call, untyped-decorator"
from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any, ClassVar, Final

from llvmlite import ir as llvm
from numba.core import cgutils, types
from numba.core.datamodel import models
from numba.core.extending import lower_builtin, lower_cast, register_model
from numba.core.typing.templates import AbstractTemplate, infer_global, signature

from ssmash_gym.dynamics import primitives
from ssmash_gym.dynamics.primitives import BIAS, EXPONENT_FIELD, FRACTION, FRACTION_BITS, ONE, ROUNDER, TWO_52, WIDTH

DOUBLES: Final = llvm.VectorType(llvm.DoubleType(), WIDTH)
INTEGERS: Final = llvm.VectorType(llvm.IntType(64), WIDTH)
BITS: Final = llvm.VectorType(llvm.IntType(1), WIDTH)


class LaneType(types.Type):
    """`WIDTH` doubles, worked on together."""

    def __init__(self) -> None:
        """Name the type by its width."""
        super().__init__(name=f"Lane{WIDTH}")


class MaskType(types.Type):
    """`WIDTH` truth values."""

    def __init__(self) -> None:
        """Name the type by its width."""
        super().__init__(name=f"Mask{WIDTH}")


LANE: Final = LaneType()
MASK: Final = MaskType()


@register_model(LaneType)
class _LaneModel(models.PrimitiveModel):
    def __init__(self, dmm: Any, fe_type: Any) -> None:
        super().__init__(dmm, fe_type, DOUBLES)


@register_model(MaskType)
class _MaskModel(models.PrimitiveModel):
    def __init__(self, dmm: Any, fe_type: Any) -> None:
        super().__init__(dmm, fe_type, BITS)


# --- values ------------------------------------------------------------------------------------------------


def _same(vector: llvm.VectorType, value: Any) -> llvm.Constant:
    """Vector constant with one value in every lane."""
    return llvm.Constant(vector, [llvm.Constant(vector.element, value)] * WIDTH)


def _spread(builder: Any, vector: llvm.VectorType, scalar: Any) -> Any:
    """Vector of one scalar, known or not."""
    if isinstance(scalar, llvm.Constant):
        return llvm.Constant(vector, [scalar] * WIDTH)
    empty = llvm.Constant(vector, llvm.Undefined)
    first = builder.insert_element(empty, scalar, llvm.Constant(llvm.IntType(32), 0))
    order = llvm.Constant(llvm.VectorType(llvm.IntType(32), WIDTH), [0] * WIDTH)
    return builder.shuffle_vector(first, empty, order)


@lower_cast(types.Float, LaneType)
@lower_cast(types.Integer, LaneType)
def _cast_number(context: Any, builder: Any, fromty: Any, toty: Any, value: Any) -> Any:
    return _spread(builder, DOUBLES, context.cast(builder, value, fromty, types.float64))


def _is_number(ty: Any) -> bool:
    return ty is LANE or isinstance(ty, types.Float | types.Integer)


# --- operators ---------------------------------------------------------------------------------------------


class _LaneTemplate(AbstractTemplate):
    """Typing of one operator or primitive; tried before Numba's own templates of the same operator."""

    metadata: ClassVar[dict[str, str]] = {"target": "cpu"}
    signatures: ClassVar[tuple[Any, ...]] = ()

    def generic(self, args: tuple[Any, ...], kws: dict[str, Any]) -> Any:
        if kws:
            return None
        for result, *wanted in self.signatures:
            if len(args) == len(wanted) and all(
                _is_number(have) if want is LANE else have is want for have, want in zip(args, wanted, strict=True)
            ):
                return signature(result, *wanted)
        return None


class _OperatorTemplate(_LaneTemplate):
    """The same for an operator, which must see a lane or a mask: numbers among themselves are Numba's business."""

    def generic(self, args: tuple[Any, ...], kws: dict[str, Any]) -> Any:
        if LANE in args or MASK in args:
            return super().generic(args, kws)
        return None


def _type(function: Any, *signatures: tuple[Any, ...], base: type[_LaneTemplate] = _LaneTemplate) -> None:
    infer_global(function)(type(f"Lane_{function.__name__}", (base,), {"key": function, "signatures": signatures}))


def _lower(function: Any, *signature_: Any) -> Callable[[Any], Any]:
    """Type a primitive as ``(result, *arguments)`` and lower it by the decorated ``f(builder, *values)``."""

    def register(emit: Callable[..., Any]) -> Callable[..., Any]:
        def lowered(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            return emit(builder, *args)

        _type(function, signature_)
        lower_builtin(function, *signature_[1:])(lowered)
        return emit

    return register


def _lower_operator(function: Any, emit: Callable[..., Any], *signature_: Any) -> None:
    def lowered(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return emit(builder, *args)

    _type(function, signature_, base=_OperatorTemplate)
    lower_builtin(function, *signature_[1:])(lowered)


def _comparison(sign: str) -> Callable[..., Any]:
    return lambda builder, a, b: builder.fcmp_ordered(sign, a, b)


for _operator, _inplace, _emit in (
    (operator.add, operator.iadd, lambda builder, a, b: builder.fadd(a, b)),
    (operator.sub, operator.isub, lambda builder, a, b: builder.fsub(a, b)),
    (operator.mul, operator.imul, lambda builder, a, b: builder.fmul(a, b)),
    (operator.truediv, operator.itruediv, lambda builder, a, b: builder.fdiv(a, b)),
):
    _lower_operator(_operator, _emit, LANE, LANE, LANE)
    _type(_inplace, (LANE, LANE, LANE), base=_OperatorTemplate)  # Numba lowers it as the operator itself
for _operator, _sign in ((operator.lt, "<"), (operator.le, "<="), (operator.gt, ">"), (operator.ge, ">=")):
    _lower_operator(_operator, _comparison(_sign), MASK, LANE, LANE)
for _operator, _inplace, _emit in (
    (operator.and_, operator.iand, lambda builder, a, b: builder.and_(a, b)),
    (operator.or_, operator.ior, lambda builder, a, b: builder.or_(a, b)),
):
    _lower_operator(_operator, _emit, MASK, MASK, MASK)
    _type(_inplace, (MASK, MASK, MASK), base=_OperatorTemplate)
_lower_operator(operator.neg, lambda builder, a: builder.fneg(a), LANE, LANE)
_lower_operator(operator.pos, lambda builder, a: a, LANE, LANE)
_lower_operator(operator.invert, lambda builder, a: builder.not_(a), MASK, MASK)


# --- primitives --------------------------------------------------------------------------------------------


def _intrinsic(builder: Any, name: str, *args: Any) -> Any:
    kind = llvm.FunctionType(DOUBLES, [DOUBLES] * len(args))
    function = cgutils.get_or_insert_function(builder.module, kind, f"llvm.{name}.v{WIDTH}f64")
    return builder.call(function, args)


def _rounded_bits(builder: Any, n: Any) -> Any:
    """Bits of ``n + 1.5 * 2**52``: the whole number ``n`` is in the low ones."""
    return builder.bitcast(builder.fadd(n, _same(DOUBLES, ROUNDER)), INTEGERS)


@_lower(primitives.splat, LANE, LANE)
def _(builder: Any, value: Any) -> Any:
    return value  # the cast to a lane has done it


@_lower(primitives.where, LANE, MASK, LANE, LANE)
def _(builder: Any, mask: Any, a: Any, b: Any) -> Any:
    return builder.select(mask, a, b)


@_lower(primitives.minimum, LANE, LANE, LANE)
def _(builder: Any, a: Any, b: Any) -> Any:
    return builder.select(builder.fcmp_ordered("<", a, b), a, b)


@_lower(primitives.maximum, LANE, LANE, LANE)
def _(builder: Any, a: Any, b: Any) -> Any:
    return builder.select(builder.fcmp_ordered(">", a, b), a, b)


@_lower(primitives.fabs, LANE, LANE)
def _(builder: Any, a: Any) -> Any:
    return _intrinsic(builder, "fabs", a)


@_lower(primitives.copysign, LANE, LANE, LANE)
def _(builder: Any, a: Any, b: Any) -> Any:
    return _intrinsic(builder, "copysign", a, b)


@_lower(primitives.sqrt, LANE, LANE)
def _(builder: Any, a: Any) -> Any:
    return _intrinsic(builder, "sqrt", a)


@_lower(primitives.any_lane, types.boolean, MASK)
def _(builder: Any, mask: Any) -> Any:
    word = llvm.IntType(WIDTH)
    return builder.icmp_unsigned("!=", builder.bitcast(mask, word), llvm.Constant(word, 0))


@_lower(primitives.pow2, LANE, LANE)
def _(builder: Any, n: Any) -> Any:
    field = builder.add(_rounded_bits(builder, n), _same(INTEGERS, BIAS))
    return builder.bitcast(builder.shl(field, _same(INTEGERS, FRACTION_BITS)), DOUBLES)


@_lower(primitives.exponent, LANE, LANE)
def _(builder: Any, a: Any) -> Any:
    field = builder.lshr(builder.bitcast(a, INTEGERS), _same(INTEGERS, FRACTION_BITS))
    field = builder.and_(field, _same(INTEGERS, EXPONENT_FIELD))
    number = builder.bitcast(builder.or_(field, _same(INTEGERS, TWO_52)), DOUBLES)
    return builder.fsub(number, _same(DOUBLES, 4503599627370496.0 + BIAS))


@_lower(primitives.mantissa, LANE, LANE)
def _(builder: Any, a: Any) -> Any:
    fraction = builder.and_(builder.bitcast(a, INTEGERS), _same(INTEGERS, FRACTION))
    return builder.bitcast(builder.or_(fraction, _same(INTEGERS, ONE)), DOUBLES)


@_lower(primitives.integer_bit, MASK, LANE, types.int64)
def _(builder: Any, n: Any, bit: Any) -> Any:
    shift = _spread(builder, INTEGERS, builder.sub(llvm.Constant(bit.type, 63), bit))
    return builder.icmp_signed("<", builder.shl(_rounded_bits(builder, n), shift), _same(INTEGERS, 0))


# --- rows of arrays ----------------------------------------------------------------------------------------


def _is_block(ty: Any) -> bool:
    return isinstance(ty, types.Array) and ty.ndim == 2 and ty.layout == "C" and ty.dtype == types.float64


def _is_row(ty: Any) -> bool:
    return isinstance(ty, types.Integer | types.IntEnumMember)


@infer_global(primitives.load)
class _LoadTemplate(AbstractTemplate):
    key = primitives.load

    def generic(self, args: tuple[Any, ...], kws: dict[str, Any]) -> Any:
        if len(args) == 2 and not kws and _is_block(args[0]) and _is_row(args[1]):
            return signature(LANE, args[0], types.intp)
        return None


@infer_global(primitives.store)
class _StoreTemplate(AbstractTemplate):
    key = primitives.store

    def generic(self, args: tuple[Any, ...], kws: dict[str, Any]) -> Any:
        if len(args) == 3 and not kws and _is_block(args[0]) and args[0].mutable:
            row, value = args[1:]
            return signature(types.none, args[0], types.intp, LANE) if _is_row(row) and _is_number(value) else None
        return None


def _row_pointer(context: Any, builder: Any, block_type: Any, block: Any, row: Any) -> Any:
    data = context.make_array(block_type)(context, builder, block).data
    offset = builder.mul(row, llvm.Constant(row.type, WIDTH))
    return builder.bitcast(builder.gep(data, [offset]), DOUBLES.as_pointer())


@lower_builtin(primitives.load, types.Array, types.intp)
def _load(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return builder.load(_row_pointer(context, builder, sig.args[0], *args), align=8)


@lower_builtin(primitives.store, types.Array, types.intp, LaneType)
def _store(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    block, row, value = args
    builder.store(value, _row_pointer(context, builder, sig.args[0], block, row), align=8)
    return context.get_dummy_value()
