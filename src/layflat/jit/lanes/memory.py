"""Lanes for the compiler: reading and writing rows of numbers, lane by lane or as whole vectors."""

# mypy: disable-error-code="attr-defined,import-untyped,no-untyped-call,untyped-decorator"
# The compiler's own modules are untyped.

from collections.abc import Callable
from itertools import count
from typing import Any

from numba import types
from numba.core import cgutils
from numba.extending import lower_builtin

from layflat import lanes
from layflat.jit.lanes.typing import BIT_WIDTHS, number_in


@lower_builtin(lanes.write_row, types.Array, types.Integer, types.Integer, types.BaseTuple)
def _write_row(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    """Emit the storing of a tuple in a row of a 3D array; unrolled, since a variable index would be a jump table."""
    rows = context.make_array(sig.args[0])(context, builder, args[0])
    for column, value in enumerate(cgutils.unpack_tuple(builder, args[3])):
        place = [args[1], args[2], context.get_constant(types.intp, column)]
        builder.store(value, cgutils.get_item_pointer(context, builder, sig.args[0], rows, place))
    return context.get_dummy_value()


def _row_pointer(context: Any, builder: Any, block: Any, array: Any, row: int, lanes: Any) -> Any:
    """Emit the pointer to a row of a block (columns side by side in memory), as one vector."""
    place = [context.get_constant(types.intp, row), context.get_constant(types.intp, 0)]
    pointer = cgutils.get_item_pointer(context, builder, block, array, place)
    return builder.bitcast(pointer, context.get_value_type(lanes).as_pointer())


def _alignment(kind: Any) -> int:
    """Return the alignment of a row in bytes: that of one number, since rows begin wherever a number may."""
    return int(BIT_WIDTHS[number_in(kind)]) // 8


def _load_leaves(context: Any, builder: Any, kind: Any, place: Callable[[int, Any], Any], stored: Any = None) -> Any:
    """Emit a value whose leaves are loaded from the pointers that `place(index, type)` returns.

    `stored` is the type of number in memory; None: that of the leaves.
    """
    leaves = count()

    def read(kind: Any) -> Any:
        if isinstance(kind, types.BaseTuple):
            return context.make_tuple(builder, kind, [read(leaf) for leaf in kind.types])
        number = builder.load(place(next(leaves), kind), align=_alignment(stored or kind))
        return number if stored is None else context.cast(builder, number, stored, kind)

    return read(kind)


def _store_leaves(
    context: Any, builder: Any, kind: Any, value: Any, place: Callable[[int, Any], Any], stored: Any = None
) -> None:
    """Emit the storing of a value's leaves at the pointers that `place(index, type)` returns; `stored` as above."""
    leaves = count()

    def write(kind: Any, value: Any) -> None:
        if isinstance(kind, types.BaseTuple):
            for leaf, item in zip(kind.types, cgutils.unpack_tuple(builder, value), strict=True):
                write(leaf, item)
        else:
            number = value if stored is None else context.cast(builder, value, kind, stored)
            builder.store(number, place(next(leaves), kind), align=_alignment(stored or kind))

    write(kind, value)


def _rows(context: Any, builder: Any, block: Any, value: Any) -> Callable[[int, Any], Any]:
    """Return the function that emits the pointer to a row of a block as one vector of a type of lanes."""
    array = context.make_array(block)(context, builder, value)
    return lambda row, lanes: _row_pointer(context, builder, block, array, row, lanes)


def _items(context: Any, builder: Any, kind: Any, value: Any) -> Callable[[int, Any], Any]:
    """Return the function that emits the pointer to element i of a 1D array."""
    array = context.make_array(kind)(context, builder, value)
    return lambda i, _: cgutils.get_item_pointer(context, builder, kind, array, [context.get_constant(types.intp, i)])


@lower_builtin(lanes.read_lanes, types.Any, types.Array)
@lower_builtin(lanes.read_lanes, types.Any, types.Array, types.Any)
def _read_lanes(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return _load_leaves(context, builder, sig.return_type, _rows(context, builder, sig.args[1], args[1]))


@lower_builtin(lanes.write_lanes, types.Array, types.Any)
def _write_lanes(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    """Emit the storing of each leaf, a vector, in a row of a block."""
    _store_leaves(context, builder, sig.args[1], args[1], _rows(context, builder, sig.args[0], args[0]))
    return context.get_dummy_value()


@lower_builtin(lanes.read_numbers, types.Any, types.Array)
def _read_numbers(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    """Emit a value whose leaves are elements of a 1D array, from the first on, in the precision of the value."""
    kind = sig.args[1]
    return _load_leaves(context, builder, sig.return_type, _items(context, builder, kind, args[1]), kind.dtype)


@lower_builtin(lanes.write_numbers, types.Array, types.Any)
def _write_numbers(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    """Emit the storing of each leaf, a number, in an element of a 1D array, from the first on, in its precision."""
    kind, values = sig.args
    _store_leaves(context, builder, values, args[1], _items(context, builder, kind, args[0]), kind.dtype)
    return context.get_dummy_value()
