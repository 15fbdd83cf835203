"""Lanes for the compiler: the LLVM instructions of each operation."""

# mypy: disable-error-code="attr-defined,import-untyped,no-untyped-call,untyped-decorator"
# The compiler's own modules are untyped.

import operator
from collections.abc import Callable, Mapping
from itertools import count
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.extending import lower_cast
from numba.core.imputils import lower_builtin
from numba.np.arrayobj import make_array

from layflat import lanes
from layflat.lanes.typing import (
    ARITHMETIC,
    BITS,
    COMPARISONS,
    EPSILON,
    EXTREMES,
    INDEX,
    INTRINSICS,
    LOGIC,
    LanesType,
    half_type,
    number_in,
    part_type,
    size_of_part,
    width_in,
)


@lower_cast(types.Number, LanesType)
def _spread(context: Any, builder: Any, number: Any, lanes: Any, value: Any) -> Any:
    value = context.cast(builder, value, number, lanes.leaf)
    vector = ir.VectorType(value.type, lanes.count)
    single = builder.insert_element(ir.Constant(vector, ir.Undefined), value, ir.Constant(INDEX, 0))
    return builder.shuffle_vector(single, single, ir.Constant(ir.VectorType(INDEX, lanes.count), None))


def _lowered(functions: Mapping[Any, str], count: int, emit: Callable[..., Any]) -> None:
    # Let `emit` build the functions' instructions from the name of each and its `count` arguments.
    for function, name in functions.items():

        def lower(context: Any, builder: Any, sig: Any, args: Any, name: str = name) -> Any:  # noqa: ARG001
            return emit(builder, name, *args)

        lower_builtin(function, *[LanesType] * count)(lower)


def _instruction(builder: Any, name: str, *args: Any) -> Any:
    return getattr(builder, name)(*args)


def _negated(builder: Any, _name: str, value: Any) -> Any:
    # The compiler for CUDA devices has no instruction for it.
    return builder.fsub(ir.Constant(value.type, [-0.0] * value.type.count), value)


def _comparison(builder: Any, sign: str, first: Any, second: Any) -> Any:
    return builder.fcmp_ordered(sign, first, second)


def _extreme(builder: Any, sign: str, first: Any, second: Any) -> Any:
    # As the compiler's own min and max of two numbers do it, so that both treat nan and -0 alike.
    return builder.select(builder.fcmp_ordered(sign, second, first), second, first)


def _intrinsic(builder: Any, name: str, value: Any) -> Any:
    if "nvptx" not in builder.module.triple:
        return _call(builder, f"llvm.{name}.v{value.type.count}{value.type.element.intrinsic_name}", value)
    # CUDA devices have them in a library, for single numbers.
    suffix = "f" if isinstance(value.type.element, ir.FloatType) else ""
    for i in range(value.type.count):
        place = ir.Constant(INDEX, i)
        found = _call(builder, f"__nv_{name}{suffix}", builder.extract_element(value, place))
        value = builder.insert_element(value, found, place)
    return value


def _call(builder: Any, name: str, value: Any) -> Any:
    function = ir.FunctionType(value.type, [value.type])
    return builder.call(cgutils.get_or_insert_function(builder.module, function, name), [value])


_lowered(ARITHMETIC, 2, _instruction)
_lowered(LOGIC, 2, _instruction)
_lowered({operator.neg: ""}, 1, _negated)
_lowered(COMPARISONS, 2, _comparison)
_lowered(EXTREMES, 2, _extreme)
_lowered(INTRINSICS, 1, _intrinsic)


@lower_builtin(lanes.select, types.Any, types.Any, types.Any)
def _select(context: Any, builder: Any, sig: Any, args: Any) -> Any:  # noqa: ARG001
    return builder.select(*args)


@lower_builtin(lanes.epsilon, types.Float)
@lower_builtin(lanes.epsilon, LanesType)
def _epsilon(context: Any, builder: Any, sig: Any, args: Any) -> Any:  # noqa: ARG001
    return context.get_constant(sig.return_type, EPSILON[number_in(sig.args[0])])


@lower_builtin(lanes.anywhere, types.Float)
@lower_builtin(lanes.anywhere, LanesType)
def _anywhere(context: Any, builder: Any, sig: Any, args: Any) -> Any:  # noqa: ARG001
    (number,) = args
    some = builder.fcmp_unordered("!=", number, ir.Constant(number.type, None))
    if not isinstance(some.type, ir.VectorType):
        return some
    bits = builder.bitcast(some, ir.IntType(some.type.count))
    return builder.icmp_unsigned("!=", bits, ir.Constant(bits.type, 0))


def _shuffled(builder: Any, first: Any, second: Any, start: int, count: int) -> Any:
    # `count` of the lanes of first and second together, from the one numbered `start`.
    picked = ir.Constant(ir.VectorType(INDEX, count), list(range(start, start + count)))
    return builder.shuffle_vector(first, second, picked)


def _taken(builder: Any, kind: Any, value: Any, start: int) -> Any:
    # Those of some lanes that make up lanes of a kind, or a number, from the one numbered `start`.
    if isinstance(kind, LanesType):
        return _shuffled(builder, value, value, start, kind.count)
    return builder.extract_element(value, ir.Constant(INDEX, start))


@lower_builtin(lanes.join, types.Any, types.Any)
def _join(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return _join_leaf(context, builder, sig.return_type, sig.args, args)


def _join_leaf(context: Any, builder: Any, joined: Any, kinds: Any, values: Any) -> Any:
    if isinstance(joined, types.BaseTuple):
        items = zip(*[cgutils.unpack_tuple(builder, value) for value in values], strict=True)
        leaves = [
            _join_leaf(context, builder, leaf, [kind.types[i] for kind in kinds], pair)
            for i, (leaf, pair) in enumerate(zip(joined.types, items, strict=True))
        ]
        return context.make_tuple(builder, joined, leaves)
    half = LanesType(joined.leaf, joined.count // 2)
    first, second = (context.cast(builder, value, kind, half) for kind, value in zip(kinds, values, strict=True))
    return _shuffled(builder, first, second, 0, joined.count)


@lower_builtin(lanes.halves, types.Any)
def _halves(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    parts = [_half_leaf(context, builder, sig.args[0], args[0], which) for which in (0, 1)]
    return context.make_tuple(builder, sig.return_type, parts)


def _half_leaf(context: Any, builder: Any, joined: Any, value: Any, which: int) -> Any:
    if isinstance(joined, types.BaseTuple):
        items = zip(joined.types, cgutils.unpack_tuple(builder, value), strict=True)
        leaves = [_half_leaf(context, builder, kind, item, which) for kind, item in items]
        return context.make_tuple(builder, half_type(joined), leaves)
    if not isinstance(joined, LanesType):
        return value
    return _taken(builder, half_type(joined), value, which * joined.count // 2)


@lower_builtin(lanes.abreast, types.UniTuple)
def _abreast(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return _abreast_leaf(context, builder, sig.return_type, cgutils.unpack_tuple(builder, args[0]))


def _abreast_leaf(context: Any, builder: Any, joined: Any, items: Any) -> Any:
    if isinstance(joined, types.BaseTuple):
        leaves = zip(*[cgutils.unpack_tuple(builder, item) for item in items], strict=True)
        made = [_abreast_leaf(context, builder, *leaf) for leaf in zip(joined.types, leaves, strict=True)]
        return context.make_tuple(builder, joined, made)
    if len(items) == 1:
        return items[0]
    numbers = [number for item in items for number in _numbers_in(builder, item)]
    numbers += numbers[-1:] * (joined.count - len(numbers))
    vector = ir.Constant(ir.VectorType(numbers[0].type, len(numbers)), ir.Undefined)
    for i, number in enumerate(numbers):
        vector = builder.insert_element(vector, number, ir.Constant(INDEX, i))
    return vector


def _numbers_in(builder: Any, value: Any) -> Any:
    if not isinstance(value.type, ir.VectorType):
        return [value]
    return [builder.extract_element(value, ir.Constant(INDEX, i)) for i in range(value.type.count)]


@lower_builtin(lanes.apart, types.Any, types.BaseTuple)
def _apart(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    count = sig.return_type.count
    parts = [_part_leaf(context, builder, sig.args[0], args[0], i, count) for i in range(count)]
    return context.make_tuple(builder, sig.return_type, parts)


def _part_leaf(context: Any, builder: Any, joined: Any, value: Any, which: int, count: int) -> Any:
    if isinstance(joined, types.BaseTuple):
        items = zip(joined.types, cgutils.unpack_tuple(builder, value), strict=True)
        leaves = [_part_leaf(context, builder, kind, item, which, count) for kind, item in items]
        return context.make_tuple(builder, part_type(joined, count), leaves)
    if count == 1:
        return value
    return _taken(builder, part_type(joined, count), value, which * size_of_part(joined.count, count))


@lower_builtin(lanes.packed, types.UniTuple)
def _packed(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    items, few = sig.args[0], sig.return_type
    if few == items:
        return args[0]
    together = _abreast_leaf(context, builder, few.dtype, cgutils.unpack_tuple(builder, args[0]))
    return context.make_tuple(builder, few, [together])


@lower_builtin(lanes.unpacked, types.UniTuple, types.BaseTuple)
def _unpacked(context: Any, builder: Any, sig: Any, args: Any) -> Any:
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


def _summed_leaf(context: Any, builder: Any, kind: Any, value: Any, items: int, way: int) -> Any:
    if isinstance(kind, types.BaseTuple):
        leaves = zip(kind.types, cgutils.unpack_tuple(builder, value), strict=True)
        return context.make_tuple(builder, kind, [_summed_leaf(context, builder, *leaf, items, way) for leaf in leaves])
    if items == 1:
        return value
    # What is added where there is nothing to add leaves every bit as it is.
    nothing, size, step = ir.Constant(value.type, [-0.0] * kind.count), size_of_part(kind.count, items), 1
    while step < items:
        wanted = [lane - way * step * size for lane in range(kind.count)]
        places = [lane if 0 <= lane < items * size else kind.count for lane in wanted]
        picked = ir.Constant(ir.VectorType(INDEX, kind.count), places)
        value, step = builder.fadd(value, builder.shuffle_vector(value, nothing, picked)), 2 * step
    return value


@lower_builtin(lanes.write_row, types.Array, types.Integer, types.Integer, types.BaseTuple)
def _write_row(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    # Unrolled: to index a tuple with a variable would compile to a jump table.
    rows = make_array(sig.args[0])(context, builder, args[0])
    for column, value in enumerate(cgutils.unpack_tuple(builder, args[3])):
        place = [args[1], args[2], context.get_constant(types.intp, column)]
        builder.store(value, cgutils.get_item_pointer(context, builder, sig.args[0], rows, place))
    return context.get_dummy_value()


@lower_builtin(lanes.in_lanes, types.Any, LanesType)
@lower_builtin(lanes.in_lanes, types.Any, types.Float)
def _in_lanes(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return _spread_leaf(context, builder, sig.args[0], sig.return_type, args[0])


def _spread_leaf(context: Any, builder: Any, kind: Any, spread: Any, value: Any) -> Any:
    if not isinstance(kind, types.BaseTuple):
        return context.cast(builder, value, kind, spread)
    items = zip(kind.types, spread.types, cgutils.unpack_tuple(builder, value), strict=True)
    return context.make_tuple(builder, spread, [_spread_leaf(context, builder, *item) for item in items])


def _row(context: Any, builder: Any, block: Any, array: Any, row: int, lanes: Any) -> Any:
    # Pointer to a row of a block (columns side by side in memory), as one vector.
    place = [context.get_constant(types.intp, row), context.get_constant(types.intp, 0)]
    pointer = cgutils.get_item_pointer(context, builder, block, array, place)
    return builder.bitcast(pointer, context.get_value_type(lanes).as_pointer())


@lower_builtin(lanes.width, types.Any)
@lower_builtin(lanes.width, types.Any, types.Array)
def _width(context: Any, builder: Any, sig: Any, args: Any) -> Any:  # noqa: ARG001
    return context.get_constant(sig.return_type, width_in(context, *sig.args))


def _aligned(kind: Any) -> int:
    # Rows of a block begin wherever a number may, bytes.
    return int(BITS[number_in(kind)]) // 8


def _read(context: Any, builder: Any, kind: Any, place: Callable[[int, Any], Any]) -> Any:
    # A value of some kind, its leaves loaded in order from where `place` says the leaf of a number and a kind stands.
    leaves = count()

    def read(kind: Any) -> Any:
        if isinstance(kind, types.BaseTuple):
            return context.make_tuple(builder, kind, [read(leaf) for leaf in kind.types])
        return builder.load(place(next(leaves), kind), align=_aligned(kind))

    return read(kind)


def _write(builder: Any, kind: Any, value: Any, place: Callable[[int, Any], Any]) -> None:
    leaves = count()

    def write(kind: Any, value: Any) -> None:
        if isinstance(kind, types.BaseTuple):
            for leaf, item in zip(kind.types, cgutils.unpack_tuple(builder, value), strict=True):
                write(leaf, item)
        else:
            builder.store(value, place(next(leaves), kind), align=_aligned(kind))

    write(kind, value)


def _rows(context: Any, builder: Any, block: Any, value: Any) -> Callable[[int, Any], Any]:
    array = make_array(block)(context, builder, value)
    return lambda row, lanes: _row(context, builder, block, array, row, lanes)


def _items(context: Any, builder: Any, kind: Any, value: Any) -> Callable[[int, Any], Any]:
    array = make_array(kind)(context, builder, value)
    return lambda i, _: cgutils.get_item_pointer(context, builder, kind, array, [context.get_constant(types.intp, i)])


@lower_builtin(lanes.read_lanes, types.Any, types.Array)
@lower_builtin(lanes.read_lanes, types.Any, types.Array, types.Any)
def _read_lanes(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return _read(context, builder, sig.return_type, _rows(context, builder, sig.args[1], args[1]))


@lower_builtin(lanes.write_lanes, types.Array, types.Any)
def _write_lanes(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    _write(builder, sig.args[1], args[1], _rows(context, builder, sig.args[0], args[0]))
    return context.get_dummy_value()


@lower_builtin(lanes.read_numbers, types.Any, types.Array)
def _read_numbers(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return _read(context, builder, sig.return_type, _items(context, builder, sig.args[1], args[1]))


@lower_builtin(lanes.write_numbers, types.Array, types.Any)
def _write_numbers(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    _write(builder, sig.args[1], args[1], _items(context, builder, sig.args[0], args[0]))
    return context.get_dummy_value()
