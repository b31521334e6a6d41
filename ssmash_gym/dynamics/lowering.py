"""Lanes for Numba: the types, how operators and primitives are typed, and the vector instructions they become.

A lane is an LLVM vector of doubles, a mask one of bits, both of one of the `WIDTHS`. Lanes of different widths do not
mix. Operators are registered as typing templates with one lowering each, which compiles several times faster than
overloads; the templates say they are for the CPU target, so that Numba tries them before its own for the same operator.
No instruction carries a fast-math flag: nothing is contracted or re-associated, and the bits are those of the NumPy
definitions in `ssmash_gym.dynamics.primitives`.
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
from ssmash_gym.dynamics.primitives import BIAS, EXPONENT_FIELD, FRACTION, FRACTION_BITS, ONE, ROUNDER, TWO_52

DOUBLE: Final = llvm.DoubleType()
INTEGER: Final = llvm.IntType(64)


class LaneType(types.Type):
    """Doubles, worked on together."""

    def __init__(self, width: int) -> None:
        """Name the type by its width."""
        self.width = width
        super().__init__(name=f"Lane{width}")


class MaskType(types.Type):
    """Truth values of the doubles of a lane."""

    def __init__(self, width: int) -> None:
        """Name the type by its width."""
        self.width = width
        super().__init__(name=f"Mask{width}")


@register_model(LaneType)
class _LaneModel(models.PrimitiveModel):
    def __init__(self, dmm: Any, fe_type: LaneType) -> None:
        super().__init__(dmm, fe_type, llvm.VectorType(DOUBLE, fe_type.width))


@register_model(MaskType)
class _MaskModel(models.PrimitiveModel):
    def __init__(self, dmm: Any, fe_type: MaskType) -> None:
        super().__init__(dmm, fe_type, llvm.VectorType(llvm.IntType(1), fe_type.width))


# --- values ------------------------------------------------------------------------------------------------


def _vector(element: Any, like: Any) -> llvm.VectorType:
    """Vector type as wide as a value."""
    return llvm.VectorType(element, like.type.count)


def _same(vector: llvm.VectorType, value: Any) -> llvm.Constant:
    """Vector constant with one value in every lane."""
    return llvm.Constant(vector, [llvm.Constant(vector.element, value)] * vector.count)


def _spread(builder: Any, vector: llvm.VectorType, scalar: Any) -> Any:
    """Vector of one scalar, known or not."""
    if isinstance(scalar, llvm.Constant):
        return llvm.Constant(vector, [scalar] * vector.count)
    empty = llvm.Constant(vector, llvm.Undefined)
    first = builder.insert_element(empty, scalar, llvm.Constant(llvm.IntType(32), 0))
    order = llvm.Constant(llvm.VectorType(llvm.IntType(32), vector.count), [0] * vector.count)
    return builder.shuffle_vector(first, empty, order)


@lower_cast(types.Float, LaneType)
@lower_cast(types.Integer, LaneType)
def _cast_number(context: Any, builder: Any, fromty: Any, toty: Any, value: Any) -> Any:
    return _spread(builder, context.get_value_type(toty), context.cast(builder, value, fromty, types.float64))


def _is_scalar(ty: Any) -> bool:
    return isinstance(ty, types.Float | types.Integer)


# --- operators ---------------------------------------------------------------------------------------------


class _LaneTemplate(AbstractTemplate):
    """Typing of one operator or primitive; tried before Numba's own templates of the same operator.

    The signature, result first, says `LaneType` or `MaskType` for one of any width; the arguments must agree on it.
    At least one of them is a lane or a mask: numbers among themselves are Numba's business.
    """

    metadata: ClassVar[dict[str, str]] = {"target": "cpu"}
    wanted: ClassVar[tuple[Any, ...]] = ()

    def generic(self, args: tuple[Any, ...], kws: dict[str, Any]) -> Any:
        widths = {ty.width for ty in args if isinstance(ty, LaneType | MaskType)}
        if kws or len(widths) != 1 or len(args) != len(self.wanted) - 1:
            return None
        (width,) = widths
        result, *wanted = (ty(width) if isinstance(ty, type) else ty for ty in self.wanted)
        for have, want in zip(args, wanted, strict=True):
            if have is not want and not (isinstance(want, LaneType) and _is_scalar(have)):
                return None
        return signature(result, *wanted)


def _type(function: Any, *wanted: Any) -> None:
    infer_global(function)(type(f"Lane_{function.__name__}", (_LaneTemplate,), {"key": function, "wanted": wanted}))


def _lower(function: Any, *wanted: Any) -> Callable[[Any], Any]:
    """Type an operator or primitive as ``(result, *arguments)``, lower it by the decorated ``f(builder, *values)``."""

    def register(emit: Callable[..., Any]) -> Callable[..., Any]:
        def lowered(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            return emit(builder, *args)

        _type(function, *wanted)
        lower_builtin(function, *wanted[1:])(lowered)
        return emit

    return register


def _comparison(sign: str) -> Callable[..., Any]:
    return lambda builder, a, b: builder.fcmp_ordered(sign, a, b)


for _operator, _inplace, _emit in (
    (operator.add, operator.iadd, lambda builder, a, b: builder.fadd(a, b)),
    (operator.sub, operator.isub, lambda builder, a, b: builder.fsub(a, b)),
    (operator.mul, operator.imul, lambda builder, a, b: builder.fmul(a, b)),
    (operator.truediv, operator.itruediv, lambda builder, a, b: builder.fdiv(a, b)),
):
    _lower(_operator, LaneType, LaneType, LaneType)(_emit)
    _type(_inplace, LaneType, LaneType, LaneType)  # Numba lowers it as the operator itself
for _operator, _sign in ((operator.lt, "<"), (operator.le, "<="), (operator.gt, ">"), (operator.ge, ">=")):
    _lower(_operator, MaskType, LaneType, LaneType)(_comparison(_sign))
for _operator, _inplace, _emit in (
    (operator.and_, operator.iand, lambda builder, a, b: builder.and_(a, b)),
    (operator.or_, operator.ior, lambda builder, a, b: builder.or_(a, b)),
):
    _lower(_operator, MaskType, MaskType, MaskType)(_emit)
    _type(_inplace, MaskType, MaskType, MaskType)
_lower(operator.neg, LaneType, LaneType)(lambda builder, a: builder.fneg(a))
_lower(operator.pos, LaneType, LaneType)(lambda builder, a: a)
_lower(operator.invert, MaskType, MaskType)(lambda builder, a: builder.not_(a))


# --- primitives --------------------------------------------------------------------------------------------


def _intrinsic(builder: Any, name: str, *args: Any) -> Any:
    vector = args[0].type
    kind = llvm.FunctionType(vector, [vector] * len(args))
    function = cgutils.get_or_insert_function(builder.module, kind, f"llvm.{name}.v{vector.count}f64")
    return builder.call(function, args)


def _rounded_bits(builder: Any, n: Any) -> Any:
    """Bits of ``n + 1.5 * 2**52``: the whole number ``n`` is in the low ones."""
    return builder.bitcast(builder.fadd(n, _same(n.type, ROUNDER)), _vector(INTEGER, n))


@_lower(primitives.where, LaneType, MaskType, LaneType, LaneType)
def _(builder: Any, mask: Any, a: Any, b: Any) -> Any:
    return builder.select(mask, a, b)


@_lower(primitives.minimum, LaneType, LaneType, LaneType)
def _(builder: Any, a: Any, b: Any) -> Any:
    return builder.select(builder.fcmp_ordered("<", a, b), a, b)


@_lower(primitives.maximum, LaneType, LaneType, LaneType)
def _(builder: Any, a: Any, b: Any) -> Any:
    return builder.select(builder.fcmp_ordered(">", a, b), a, b)


@_lower(primitives.fabs, LaneType, LaneType)
def _(builder: Any, a: Any) -> Any:
    return _intrinsic(builder, "fabs", a)


@_lower(primitives.copysign, LaneType, LaneType, LaneType)
def _(builder: Any, a: Any, b: Any) -> Any:
    return _intrinsic(builder, "copysign", a, b)


@_lower(primitives.sqrt, LaneType, LaneType)
def _(builder: Any, a: Any) -> Any:
    return _intrinsic(builder, "sqrt", a)


@_lower(primitives.any_lane, types.boolean, MaskType)
def _(builder: Any, mask: Any) -> Any:
    word = llvm.IntType(mask.type.count)
    return builder.icmp_unsigned("!=", builder.bitcast(mask, word), llvm.Constant(word, 0))


@_lower(primitives.pow2, LaneType, LaneType)
def _(builder: Any, n: Any) -> Any:
    bits = _rounded_bits(builder, n)
    field = builder.add(bits, _same(bits.type, BIAS))
    return builder.bitcast(builder.shl(field, _same(bits.type, FRACTION_BITS)), n.type)


@_lower(primitives.exponent, LaneType, LaneType)
def _(builder: Any, a: Any) -> Any:
    bits = builder.bitcast(a, _vector(INTEGER, a))
    field = builder.and_(builder.lshr(bits, _same(bits.type, FRACTION_BITS)), _same(bits.type, EXPONENT_FIELD))
    number = builder.bitcast(builder.or_(field, _same(bits.type, TWO_52)), a.type)
    return builder.fsub(number, _same(a.type, 4503599627370496.0 + BIAS))


@_lower(primitives.mantissa, LaneType, LaneType)
def _(builder: Any, a: Any) -> Any:
    bits = builder.bitcast(a, _vector(INTEGER, a))
    fraction = builder.and_(bits, _same(bits.type, FRACTION))
    return builder.bitcast(builder.or_(fraction, _same(bits.type, ONE)), a.type)


@_lower(primitives.integer_bit, MaskType, LaneType, types.int64)
def _(builder: Any, n: Any, bit: Any) -> Any:
    bits = _rounded_bits(builder, n)
    shift = _spread(builder, bits.type, builder.sub(llvm.Constant(bit.type, 63), bit))
    return builder.icmp_signed("<", builder.shl(bits, shift), _same(bits.type, 0))


# --- what fixes the width: rows of arrays, and numbers from floats -----------------------------------------


class _WidthTemplate(AbstractTemplate):
    """Typing of a primitive of one width."""

    width: ClassVar[int]

    def generic(self, args: tuple[Any, ...], kws: dict[str, Any]) -> Any:
        return None if kws else self.typed(LaneType(self.width), *args)

    def typed(self, lane: LaneType, *args: Any) -> Any:
        raise NotImplementedError


def _fix_width(primitive: Any, *arguments: Any) -> Callable[[Any], Any]:
    """Lower all widths of a primitive by the decorated `_WidthTemplate`'s ``lowered``."""

    def register(template: Any) -> Any:
        for width, function in primitives.OF_WIDTH[primitive].items():
            infer_global(function)(type(f"{template.__name__}{width}", (template,), {"key": function, "width": width}))
            lower_builtin(function, *arguments)(template.lowered)
        return template

    return register


def _is_block(ty: Any) -> bool:
    return isinstance(ty, types.Array) and ty.ndim == 2 and ty.layout == "C" and ty.dtype == types.float64


def _is_row(ty: Any) -> bool:
    return isinstance(ty, types.Integer | types.IntEnumMember)


def _row_pointer(context: Any, builder: Any, block_type: Any, block: Any, row: Any, vector: llvm.VectorType) -> Any:
    data = context.make_array(block_type)(context, builder, block).data
    offset = builder.mul(row, llvm.Constant(row.type, vector.count))
    return builder.bitcast(builder.gep(data, [offset]), vector.as_pointer())


@_fix_width(primitives.load, types.Array, types.intp)
class _Load(_WidthTemplate):
    def typed(self, lane: LaneType, block: Any, row: Any) -> Any:
        return signature(lane, block, types.intp) if _is_block(block) and _is_row(row) else None

    @staticmethod
    def lowered(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        block, row = args
        vector = context.get_value_type(sig.return_type)
        return builder.load(_row_pointer(context, builder, sig.args[0], block, row, vector), align=8)


@_fix_width(primitives.store, types.Array, types.intp, LaneType)
class _Store(_WidthTemplate):
    def typed(self, lane: LaneType, block: Any, row: Any, value: Any) -> Any:
        if _is_block(block) and block.mutable and _is_row(row) and (value is lane or _is_scalar(value)):
            return signature(types.none, block, types.intp, lane)
        return None

    @staticmethod
    def lowered(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        block, row, value = args
        builder.store(value, _row_pointer(context, builder, sig.args[0], block, row, value.type), align=8)
        return context.get_dummy_value()


@_fix_width(primitives.splat, LaneType)
class _Splat(_WidthTemplate):
    def typed(self, lane: LaneType, value: Any) -> Any:
        return signature(lane, lane) if value is lane or _is_scalar(value) else None

    @staticmethod
    def lowered(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return args[0]  # the cast to a lane has done it
