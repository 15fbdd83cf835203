"""Lanes for the compiler: their type, an LLVM vector, and the result types of operations on them."""

# mypy: disable-error-code="attr-defined,import-untyped,no-untyped-call,untyped-decorator"
# The compiler's own modules are untyped.

import math
import operator
from collections.abc import Iterable
from functools import cache
from hashlib import sha256
from typing import Any

from llvmlite import ir
from numba import typeof, types
from numba.extending import models, register_model, typeof_impl

from layflat import lanes, registers
from layflat.jit.internals import is_for_host, register_typing

INDEX_TYPE = ir.IntType(32)

ARITHMETIC_INSTRUCTIONS = {operator.add: "fadd", operator.sub: "fsub", operator.mul: "fmul", operator.truediv: "fdiv"}
COMPARISON_SIGNS = {operator.lt: "<", operator.le: "<=", operator.gt: ">", operator.ge: ">=", operator.eq: "=="}
LOGIC_INSTRUCTIONS = {operator.and_: "and_", operator.or_: "or_"}
EXTREME_SIGNS = {min: "<", max: ">"}
EPSILON = {types.float64: 2.0**-52, types.float32: 2.0**-23}
BIT_WIDTHS = {types.float64: 64, types.float32: 32, types.boolean: 1}
INTRINSIC_NAMES = {abs: "fabs", math.sqrt: "sqrt", math.floor: "floor"}


class LanesType(types.Type):
    """Type of `count` floats, or booleans, side by side; `number` is the type of the floats, or of those compared."""

    def __init__(self, leaf: types.Type, count: int, number: types.Type | None = None) -> None:
        self.leaf, self.count, self.number = leaf, count, number or leaf
        super().__init__(name=f"Lanes({leaf} x {count}, {self.number})")


@register_model(LanesType)
class _Vector(models.PrimitiveModel):
    """Data model of lanes: an LLVM vector."""

    def __init__(self, manager: Any, lanes: LanesType) -> None:
        leaf = manager.lookup(lanes.leaf).get_value_type()
        super().__init__(manager, lanes, ir.VectorType(leaf, lanes.count))
        # A list aligns its items to 16 bytes at most; a vector would want more, but not in a packed structure.
        self._stored = ir.LiteralStructType([self.get_value_type()], packed=True)

    def get_data_type(self) -> Any:
        return self._stored

    def as_data(self, builder: Any, value: Any) -> Any:
        return builder.insert_value(ir.Constant(self._stored, ir.Undefined), value, 0)

    def from_data(self, builder: Any, value: Any) -> Any:
        return builder.extract_value(value, 0)


class LikeType(types.Opaque):
    """Type of a `Like`: the type of the tuple, and the maximum size of lanes, bytes."""

    def __init__(self, value: types.Type, max_bytes: int) -> None:
        self.value, self.max_bytes = value, max_bytes
        # The whole name would be part of those of functions.
        super().__init__(name=f"Like({sha256(str(value).encode()).hexdigest()[:16]}, {max_bytes})")

    @property
    def key(self) -> Any:
        """Key that identifies the type."""
        return self.value, self.max_bytes


register_model(LikeType)(models.OpaqueModel)


@typeof_impl.register(lanes.Like)
@cache
def _like_type(like: lanes.Like, _: Any) -> LikeType:
    return LikeType(typeof(like.value), like.max_bytes)


def _value(like: Any) -> Any:
    return like.value if isinstance(like, LikeType) else like


def width_in(context: Any, number: Any, block: Any = None) -> int:
    """Return `layflat.lanes.width` in code of a target; other targets than this computer read one lane of a block.

    Args:
        context: context of the compiler.
        number: type of a number, of lanes or of a `Like`.
        block: type of the array that is read; None: `number` decides.
    """
    if block is None:
        return getattr(number, "count", 1)
    if not is_for_host(context):
        return 1
    return registers.host_width(
        BIT_WIDTHS[block.dtype] // 8, getattr(number, "max_bytes", registers.MAX_REGISTER_BYTES)
    )


def number_in(kind: Any) -> Any:
    """Return the type of the numbers in lanes, or of a plain float or boolean; float64 for any other type."""
    return kind.number if isinstance(kind, LanesType) else kind if kind in BIT_WIDTHS else types.float64


def lanes_type(count: int, number: Any) -> Any:
    """Return the type of `count` numbers side by side; one is a plain number, except in single precision.

    Next to any literal, the compiler would convert a single one to double precision.
    """
    return LanesType(number, count) if count > 1 or number == types.float32 else number


def joined_type(first: Any, second: Any) -> Any:
    """Return the type of `join(first, second)`."""
    if isinstance(first, types.BaseTuple):
        return tuple_like(first, [joined_type(a, b) for a, b in zip(first.types, second.types, strict=True)])
    return LanesType(number_in(first), 2 * getattr(first, "count", 1))


def register_lanes(count: int) -> int:
    """Return the number of lanes for `count` numbers: the next power of two, as registers have."""
    return 1 << (count - 1).bit_length()


def abreast_type(item: Any, count: int) -> Any:
    """Return the type of `count` items of one type side by side; single numbers have spare lanes (`register_lanes`)."""
    if isinstance(item, types.BaseTuple):
        return tuple_like(item, [abreast_type(leaf, count) for leaf in item.types])
    return lanes_type(count * item.count if isinstance(item, LanesType) else register_lanes(count), number_in(item))


def packed_type(items: Any) -> Any:
    """Return the type of items of one type when packed: a tuple of one item, with all abreast.

    Items of lanes stay as they are, even of one lane.
    """
    of_lanes = isinstance(first_leaf(items), LanesType)
    return items if of_lanes else types.UniTuple(abreast_type(items.dtype, items.count), 1)


def first_leaf(kind: Any) -> Any:
    """Return the type of the first leaf of a nested tuple."""
    return first_leaf(kind.types[0]) if isinstance(kind, types.BaseTuple) else kind


def part_type(joined: Any, count: int) -> Any:
    """Return the type of each of `count` parts, of `size_of_part` lanes each; of a tuple, leaf by leaf."""
    if isinstance(joined, types.BaseTuple):
        return tuple_like(joined, [part_type(leaf, count) for leaf in joined.types])
    return lanes_type(size_of_part(getattr(joined, "count", 1), count), number_in(joined))


def size_of_part(lanes: int, count: int) -> int:
    """Return the number of lanes in each of `count` parts: 1 where the lanes are numbers with spare lanes behind."""
    return 1 if lanes == register_lanes(count) else lanes // count


def half_type(joined: Any) -> Any:
    """Return the type of either of `halves(joined)`; numbers keep theirs."""
    if isinstance(joined, types.BaseTuple):
        return tuple_like(joined, [half_type(leaf) for leaf in joined.types])
    if not isinstance(joined, LanesType):
        return joined
    return lanes_type(joined.count // 2, joined.number)


def spread_type(kind: Any, lanes: Any) -> Any:
    """Return a type with every number in it broadcast to lanes."""
    if isinstance(kind, types.BaseTuple):
        return tuple_like(kind, [spread_type(leaf, lanes) for leaf in kind.types])
    return lanes


def tuple_like(like: Any, items: list[Any]) -> Any:
    """Return the type of a tuple of items of some types, named as another one."""
    return types.BaseTuple.from_types(items, getattr(like, "instance_class", None))


def _common_lanes(args: Iterable[Any]) -> Any:
    """Return the type of the lanes of floats among the arguments; None unless there is one, and the rest numbers."""
    lanes = {arg for arg in args if isinstance(arg, LanesType) and arg.leaf == arg.number}
    sound = len(lanes) == 1 and all(arg in lanes or isinstance(arg, types.Number) for arg in args)
    return lanes.pop() if sound else None


def _same_signature(*args: Any) -> Any:
    """Return the signature of an operation that returns lanes of its arguments' type; None where it does not apply."""
    lanes = _common_lanes(args)
    return lanes and lanes(*[lanes] * len(args))


def _comparison_signature(*args: Any) -> Any:
    """Return the signature of a comparison, which returns lanes of booleans; None where it does not apply."""
    lanes = _common_lanes(args)
    return lanes and LanesType(types.boolean, lanes.count, lanes.number)(lanes, lanes)


def _logic_signature(first: Any, second: Any) -> Any:
    """Return the signature of `and` and `or` of two equal types of lanes of booleans; None for all others."""
    sound = isinstance(first, LanesType) and first == second and first.leaf == types.boolean
    return first(first, second) if sound else None


def _select_signature(condition: Any, yes: Any, no: Any) -> Any:
    """Return the signature of `select`: a condition of lanes or a boolean, between two values of lanes or numbers.

    The result has the lanes of the condition, else those of the values; without any it is in double precision.
    """
    lanes = _common_lanes((yes, no)) or types.float64
    if isinstance(condition, LanesType):
        lanes = LanesType(condition.number, condition.count)
    return lanes(condition, lanes, lanes)


def _parts(joined: Any, count: int) -> Any:
    return types.UniTuple(part_type(joined, count), count)


def _read_lanes_type(context: Any, like: Any, block: Any, *beside: Any) -> Any:
    """Return the type of `like` in lanes: as many as `beside`, where passed, else as the target reads of a block."""
    count = width_in(context, *(beside or (like, block)))
    return spread_type(_value(like), lanes_type(count, block.dtype))


register_typing((*ARITHMETIC_INSTRUCTIONS, *EXTREME_SIGNS, *INTRINSIC_NAMES, operator.neg), _same_signature)
register_typing(COMPARISON_SIGNS, _comparison_signature)
register_typing(LOGIC_INSTRUCTIONS, _logic_signature)
register_typing([lanes.select], _select_signature)
register_typing([lanes.select_leaves], lambda _condition, yes, no: yes if yes == no else None)
register_typing([lanes.epsilon], lambda _: types.float64)
register_typing([lanes.anywhere], lambda _: types.boolean)
register_typing([lanes.join], joined_type)
register_typing([lanes.halves], lambda joined: types.UniTuple(half_type(joined), 2))
register_typing([lanes.abreast], lambda items: abreast_type(items.dtype, items.count))
register_typing([lanes.apart], lambda joined, like: _parts(joined, like.count))
register_typing([lanes.packed], packed_type)
register_typing([lanes.unpacked], lambda few, like: _parts(few.dtype, like.count) if few.count < like.count else few)
register_typing([lanes.sums_up_to, lanes.sums_from], lambda joined, _: joined)
register_typing([lanes.write_row], lambda rows, _i, _j, values: types.none(rows, types.intp, types.intp, values))
register_typing([lanes.read_numbers], lambda like, _: _value(like))
register_typing([lanes.in_lanes], spread_type)
register_typing([lanes.write_numbers, lanes.write_lanes], lambda _place, _values: types.none)
register_typing([lanes.width], lambda *_: types.intp)
register_typing([lanes.read_lanes], _read_lanes_type, in_context=True)
