"""Lanes for the compiler: the LLVM instructions of each operation."""

# mypy: disable-error-code="attr-defined,import-untyped,no-untyped-call,untyped-decorator"
# The compiler's own modules are untyped.

import operator
from collections.abc import Callable, Mapping
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import lower_builtin, lower_cast

from layflat import lanes
from layflat.jit.lanes.typing import (
    ARITHMETIC_INSTRUCTIONS,
    COMPARISON_SIGNS,
    EPSILON,
    EXTREME_SIGNS,
    INDEX_TYPE,
    INTRINSIC_NAMES,
    LOGIC_INSTRUCTIONS,
    LanesType,
    half_type,
    number_in,
    part_type,
    size_of_part,
    width_in,
)


@lower_cast(types.Number, LanesType)
def _broadcast(context: Any, builder: Any, number: Any, lanes: Any, value: Any) -> Any:
    """Emit a cast of a number to lanes that all hold it."""
    value = context.cast(builder, value, number, lanes.leaf)
    vector = ir.VectorType(value.type, lanes.count)
    single = builder.insert_element(ir.Constant(vector, ir.Undefined), value, ir.Constant(INDEX_TYPE, 0))
    return builder.shuffle_vector(single, single, ir.Constant(ir.VectorType(INDEX_TYPE, lanes.count), None))


def _lower_functions(functions: Mapping[Any, str], count: int, emit: Callable[..., Any]) -> None:
    """Register `emit(builder, name, *args)` as the builder of each function's instructions, with `count` arguments."""
    for function, name in functions.items():

        def lower(context: Any, builder: Any, sig: Any, args: Any, name: str = name) -> Any:  # noqa: ARG001
            return emit(builder, name, *args)

        lower_builtin(function, *[LanesType] * count)(lower)


def _instruction(builder: Any, name: str, *args: Any) -> Any:
    return getattr(builder, name)(*args)


def _negated(builder: Any, _name: str, value: Any) -> Any:
    """Emit -0.0 less the value: the compiler for CUDA devices has no instruction for negation."""
    return builder.fsub(ir.Constant(value.type, [-0.0] * value.type.count), value)


def _comparison(builder: Any, sign: str, first: Any, second: Any) -> Any:
    return builder.fcmp_ordered(sign, first, second)


def _extreme(builder: Any, sign: str, first: Any, second: Any) -> Any:
    """Emit min ("<") or max (">"): the first operand where both are equal or one is NaN, as numba does it."""
    return builder.select(builder.fcmp_ordered(sign, second, first), second, first)


def _call_intrinsic(builder: Any, name: str, value: Any) -> Any:
    """Emit a mathematical function of lanes: a vector intrinsic, or on CUDA a library call for each lane."""
    if "nvptx" not in builder.module.triple:
        return _call(builder, f"llvm.{name}.v{value.type.count}{value.type.element.intrinsic_name}", value)
    # CUDA devices have them in a library, for single numbers.
    suffix = "f" if isinstance(value.type.element, ir.FloatType) else ""
    for i in range(value.type.count):
        index = ir.Constant(INDEX_TYPE, i)
        result = _call(builder, f"__nv_{name}{suffix}", builder.extract_element(value, index))
        value = builder.insert_element(value, result, index)
    return value


def _call(builder: Any, name: str, value: Any) -> Any:
    """Emit the call of an external function of one value, which returns the same type."""
    function = ir.FunctionType(value.type, [value.type])
    return builder.call(cgutils.get_or_insert_function(builder.module, function, name), [value])


_lower_functions({**ARITHMETIC_INSTRUCTIONS, **LOGIC_INSTRUCTIONS}, 2, _instruction)
_lower_functions({operator.neg: ""}, 1, _negated)
_lower_functions(COMPARISON_SIGNS, 2, _comparison)
_lower_functions(EXTREME_SIGNS, 2, _extreme)
_lower_functions(INTRINSIC_NAMES, 1, _call_intrinsic)


@lower_builtin(lanes.select, types.Any, types.Any, types.Any)
def _select(context: Any, builder: Any, sig: Any, args: Any) -> Any:  # noqa: ARG001
    return builder.select(*args)


@lower_builtin(lanes.select_leaves, types.Any, types.Any, types.Any)
def _select_leaves(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return _selected(context, builder, sig.return_type, *args)


def _selected(context: Any, builder: Any, kind: Any, condition: Any, yes: Any, no: Any) -> Any:
    """Emit the choice between two values of a type, leaf by leaf."""
    if not isinstance(kind, types.BaseTuple):
        return builder.select(condition, yes, no)
    items = zip(kind.types, cgutils.unpack_tuple(builder, yes), cgutils.unpack_tuple(builder, no), strict=True)
    return context.make_tuple(
        builder, kind, [_selected(context, builder, part, condition, a, b) for part, a, b in items]
    )


@lower_builtin(lanes.epsilon, types.Float)
@lower_builtin(lanes.epsilon, LanesType)
def _epsilon(context: Any, builder: Any, sig: Any, args: Any) -> Any:  # noqa: ARG001
    return context.get_constant(sig.return_type, EPSILON[number_in(sig.args[0])])


@lower_builtin(lanes.anywhere, types.Float)
@lower_builtin(lanes.anywhere, LanesType)
def _anywhere(context: Any, builder: Any, sig: Any, args: Any) -> Any:  # noqa: ARG001
    """Emit whether any lane, or the number, is not zero; NaN counts as not zero."""
    (number,) = args
    some = builder.fcmp_unordered("!=", number, ir.Constant(number.type, None))
    if not isinstance(some.type, ir.VectorType):
        return some
    bits = builder.bitcast(some, ir.IntType(some.type.count))
    return builder.icmp_unsigned("!=", bits, ir.Constant(bits.type, 0))


def _slice_lanes(builder: Any, first: Any, second: Any, start: int, count: int) -> Any:
    """Emit `count` lanes, from number `start` on, of the lanes of two vectors one after the other."""
    picked = ir.Constant(ir.VectorType(INDEX_TYPE, count), list(range(start, start + count)))
    return builder.shuffle_vector(first, second, picked)


def _extract(builder: Any, kind: Any, value: Any, start: int) -> Any:
    """Emit the lanes of a kind, or a number, out of some lanes, from the one numbered `start`."""
    if isinstance(kind, LanesType):
        return _slice_lanes(builder, value, value, start, kind.count)
    return builder.extract_element(value, ir.Constant(INDEX_TYPE, start))


@lower_builtin(lanes.join, types.Any, types.Any)
def _join(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return _join_leaf(context, builder, sig.return_type, sig.args, args)


def _join_leaf(context: Any, builder: Any, joined: Any, kinds: Any, values: Any) -> Any:
    """Emit the lanes that hold those of two values of half the count, for each leaf of a tuple."""
    if isinstance(joined, types.BaseTuple):
        items = zip(*[cgutils.unpack_tuple(builder, value) for value in values], strict=True)
        leaves = [
            _join_leaf(context, builder, leaf, [kind.types[i] for kind in kinds], pair)
            for i, (leaf, pair) in enumerate(zip(joined.types, items, strict=True))
        ]
        return context.make_tuple(builder, joined, leaves)
    half = LanesType(joined.leaf, joined.count // 2)
    first, second = (context.cast(builder, value, kind, half) for kind, value in zip(kinds, values, strict=True))
    return _slice_lanes(builder, first, second, 0, joined.count)


@lower_builtin(lanes.halves, types.Any)
def _halves(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    """Emit the tuple of both halves of lanes, leaf by leaf."""
    parts = [_half_leaf(context, builder, sig.args[0], args[0], which) for which in (0, 1)]
    return context.make_tuple(builder, sig.return_type, parts)


def _half_leaf(context: Any, builder: Any, joined: Any, value: Any, which: int) -> Any:
    """Emit the first (0) or second (1) half of lanes, for each leaf of a tuple; numbers stay."""
    if isinstance(joined, types.BaseTuple):
        items = zip(joined.types, cgutils.unpack_tuple(builder, value), strict=True)
        leaves = [_half_leaf(context, builder, kind, item, which) for kind, item in items]
        return context.make_tuple(builder, half_type(joined), leaves)
    if not isinstance(joined, LanesType):
        return value
    return _extract(builder, half_type(joined), value, which * joined.count // 2)


@lower_builtin(lanes.abreast, types.UniTuple)
def _abreast(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return _abreast_leaf(context, builder, sig.return_type, cgutils.unpack_tuple(builder, args[0]))


def _abreast_leaf(context: Any, builder: Any, joined: Any, items: Any) -> Any:
    """Emit the lanes of all items side by side, filled up with the last number, for each leaf; a single item stays."""
    if isinstance(joined, types.BaseTuple):
        leaves = zip(*[cgutils.unpack_tuple(builder, item) for item in items], strict=True)
        joined_leaves = [_abreast_leaf(context, builder, *leaf) for leaf in zip(joined.types, leaves, strict=True)]
        return context.make_tuple(builder, joined, joined_leaves)
    if len(items) == 1:
        return items[0]
    numbers = [number for item in items for number in _numbers_in(builder, item)]
    numbers += numbers[-1:] * (joined.count - len(numbers))
    vector = ir.Constant(ir.VectorType(numbers[0].type, len(numbers)), ir.Undefined)
    for i, number in enumerate(numbers):
        vector = builder.insert_element(vector, number, ir.Constant(INDEX_TYPE, i))
    return vector


def _numbers_in(builder: Any, value: Any) -> Any:
    """Return the numbers of a vector, or the only number, as a list."""
    if not isinstance(value.type, ir.VectorType):
        return [value]
    return [builder.extract_element(value, ir.Constant(INDEX_TYPE, i)) for i in range(value.type.count)]


@lower_builtin(lanes.apart, types.Any, types.BaseTuple)
def _apart(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    """Emit `lanes.apart`: the tuple of the items that `lanes.abreast` put side by side."""
    count = sig.return_type.count
    parts = [_part_leaf(context, builder, sig.args[0], args[0], i, count) for i in range(count)]
    return context.make_tuple(builder, sig.return_type, parts)


def _part_leaf(context: Any, builder: Any, joined: Any, value: Any, which: int, count: int) -> Any:
    """Emit part number `which` of `count` parts of lanes, for each leaf of a tuple."""
    if isinstance(joined, types.BaseTuple):
        items = zip(joined.types, cgutils.unpack_tuple(builder, value), strict=True)
        leaves = [_part_leaf(context, builder, kind, item, which, count) for kind, item in items]
        return context.make_tuple(builder, part_type(joined, count), leaves)
    if count == 1:
        return value
    return _extract(builder, part_type(joined, count), value, which * size_of_part(joined.count, count))


@lower_builtin(lanes.packed, types.UniTuple)
def _packed(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    """Emit `lanes.packed`: single numbers of a tuple side by side in lanes, as one item; tuples of lanes stay."""
    items, few = sig.args[0], sig.return_type
    if few == items:
        return args[0]
    together = _abreast_leaf(context, builder, few.dtype, cgutils.unpack_tuple(builder, args[0]))
    return context.make_tuple(builder, few, [together])


@lower_builtin(lanes.unpacked, types.UniTuple, types.BaseTuple)
def _unpacked(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    """Emit `lanes.unpacked`: as many items as `like` has out of a packed one."""
    few, like = sig.args
    if few == sig.return_type:
        return args[0]
    (together,) = cgutils.unpack_tuple(builder, args[0])
    parts = [_part_leaf(context, builder, few.dtype, together, i, like.count) for i in range(like.count)]
    return context.make_tuple(builder, sig.return_type, parts)


@lower_builtin(lanes.sums_up_to, types.Any, types.BaseTuple)
def _sums_up_to(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return _summed_leaf(context, builder, sig.args[0], args[0], len(sig.args[1]), 1)


@lower_builtin(lanes.sums_from, types.Any, types.BaseTuple)
def _sums_from(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return _summed_leaf(context, builder, sig.args[0], args[0], len(sig.args[1]), -1)


def _summed_leaf(context: Any, builder: Any, kind: Any, value: Any, items: int, direction: int) -> Any:
    """Emit the running sums of items side by side in lanes, from the first (1) or the last (-1), for each leaf."""
    if isinstance(kind, types.BaseTuple):
        leaves = zip(kind.types, cgutils.unpack_tuple(builder, value), strict=True)
        return context.make_tuple(
            builder, kind, [_summed_leaf(context, builder, *leaf, items, direction) for leaf in leaves]
        )
    if items == 1:
        return value
    # Adding -0.0 where there is nothing to add keeps every bit.
    nothing, size, step = ir.Constant(value.type, [-0.0] * kind.count), size_of_part(kind.count, items), 1
    while step < items:
        shifted = [lane - direction * step * size for lane in range(kind.count)]
        places = [lane if 0 <= lane < items * size else kind.count for lane in shifted]
        picked = ir.Constant(ir.VectorType(INDEX_TYPE, kind.count), places)
        value, step = builder.fadd(value, builder.shuffle_vector(value, nothing, picked)), 2 * step
    return value


@lower_builtin(lanes.in_lanes, types.Any, LanesType)
@lower_builtin(lanes.in_lanes, types.Any, types.Float)
def _in_lanes(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return _spread_leaf(context, builder, sig.args[0], sig.return_type, args[0])


def _spread_leaf(context: Any, builder: Any, kind: Any, spread: Any, value: Any) -> Any:
    """Emit a cast of each number of a tuple to lanes that all hold it."""
    if not isinstance(kind, types.BaseTuple):
        return context.cast(builder, value, kind, spread)
    items = zip(kind.types, spread.types, cgutils.unpack_tuple(builder, value), strict=True)
    return context.make_tuple(builder, spread, [_spread_leaf(context, builder, *item) for item in items])


@lower_builtin(lanes.width, types.Any)
@lower_builtin(lanes.width, types.Any, types.Array)
def _width(context: Any, builder: Any, sig: Any, args: Any) -> Any:  # noqa: ARG001
    return context.get_constant(sig.return_type, width_in(context, *sig.args))
