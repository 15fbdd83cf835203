"""Lanes for the compiler: their type, held in an LLVM vector, and the types that operations on them give."""

# mypy: disable-error-code="attr-defined,import-untyped,no-untyped-call"
# The compiler's own modules are untyped.

import math
import operator
from collections.abc import Callable, Iterable
from functools import cache
from hashlib import sha256
from typing import Any

from llvmlite import ir
from numba.core import types
from numba.core.cpu import CPUContext
from numba.core.datamodel import models
from numba.core.extending import register_model
from numba.core.typing import Context, signature
from numba.core.typing.templates import AbstractTemplate, infer_global
from numba.core.typing.typeof import typeof

from layflat import lanes

INDEX = ir.IntType(32)

ARITHMETIC = {operator.add: "fadd", operator.sub: "fsub", operator.mul: "fmul", operator.truediv: "fdiv"}
COMPARISONS = {operator.lt: "<", operator.le: "<=", operator.gt: ">", operator.ge: ">=", operator.eq: "=="}
LOGIC = {operator.and_: "and_", operator.or_: "or_"}
EXTREMES = {min: "<", max: ">"}
EPSILON = {types.float64: 2.0**-52, types.float32: 2.0**-23}
BITS = {types.float64: 64, types.float32: 32, types.boolean: 1}
INTRINSICS = {abs: "fabs", math.sqrt: "sqrt", math.floor: "floor"}


class LanesType(types.Type):
    """`count` floats, or as many booleans, side by side; `number` is the kind of floats, or of those compared."""

    def __init__(self, leaf: types.Type, count: int, number: types.Type | None = None) -> None:
        self.leaf, self.count, self.number = leaf, count, number or leaf
        super().__init__(name=f"Lanes({leaf} x {count}, {self.number})")


@register_model(LanesType)
class _Vector(models.PrimitiveModel):
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
    """A `Like`: of which only the type of the tuple counts, and how wide lanes may be."""

    def __init__(self, value: types.Type, most: int) -> None:
        self.value, self.most = value, most
        # The whole name would be part of those of functions.
        super().__init__(name=f"Like({sha256(str(value).encode()).hexdigest()[:16]}, {most})")

    @property
    def key(self) -> Any:
        """Key that tells it from others."""
        return self.value, self.most


register_model(LikeType)(models.OpaqueModel)


@cache
def _like_type(like: lanes.Like) -> LikeType:
    return LikeType(typeof(like.value), like.most)


lanes.Like._numba_type_ = property(_like_type)  # as the compiler asks for it


def _value(like: Any) -> Any:
    return like.value if isinstance(like, LikeType) else like


def width_in(context: Any, number: Any, block: Any = None) -> int:
    """Return `width` in code of a compiler's context: other targets than this machine read one lane of a block."""
    if block is None:
        return getattr(number, "count", 1)
    if not isinstance(context, (Context, CPUContext)):
        return 1
    return lanes.host_width(BITS[block.dtype] // 8, getattr(number, "most", lanes.WIDEST))


def number_in(kind: Any) -> Any:
    """Type of the numbers that lanes hold, or of a plain number."""
    return kind.number if isinstance(kind, LanesType) else kind if kind in BITS else types.float64


def lanes_type(count: int, number: Any) -> Any:
    """Type of so many numbers side by side; one is a plain number.

    Not in single precision: next to any literal, the compiler would make a double of it.
    """
    return LanesType(number, count) if count > 1 or number == types.float32 else number


def joined_type(first: Any, second: Any) -> Any:
    """Type of `join(first, second)`."""
    if isinstance(first, types.BaseTuple):
        return _tuple_like(first, [joined_type(a, b) for a, b in zip(first.types, second.types, strict=True)])
    return LanesType(number_in(first), 2 * getattr(first, "count", 1))


def room(count: int) -> int:
    """Lanes for so many numbers side by side: registers hold powers of two, and what they do not fill costs nothing."""
    return 1 << (count - 1).bit_length()


def abreast_type(item: Any, count: int) -> Any:
    """Type of so many items of one type side by side; single numbers have some lanes to spare (see `room`)."""
    if isinstance(item, types.BaseTuple):
        return _tuple_like(item, [abreast_type(leaf, count) for leaf in item.types])
    return lanes_type(count * item.count if isinstance(item, LanesType) else room(count), number_in(item))


def packed_type(items: Any) -> Any:
    """Type of some items of one type when packed: lanes stay as they are, one lane too."""
    of_lanes = isinstance(first_leaf(items), LanesType)
    return items if of_lanes else types.UniTuple(abreast_type(items.dtype, items.count), 1)


def first_leaf(kind: Any) -> Any:
    """Type of the first leaf of a nested tuple."""
    return first_leaf(kind.types[0]) if isinstance(kind, types.BaseTuple) else kind


def _unpacked(few: Any, like: Any) -> Any:
    return signature(_parts(few.dtype, like.count) if few.count < like.count else few, few, like)


def part_type(joined: Any, count: int) -> Any:
    """Type of each of so many parts of lanes."""
    if isinstance(joined, types.BaseTuple):
        return _tuple_like(joined, [part_type(leaf, count) for leaf in joined.types])
    return lanes_type(size_of_part(getattr(joined, "count", 1), count), number_in(joined))


def size_of_part(lanes: int, count: int) -> int:
    """Lanes of each of so many parts."""
    return 1 if lanes == room(count) else lanes // count


def half_type(joined: Any) -> Any:
    """Type of either of `halves(joined)`."""
    if isinstance(joined, types.BaseTuple):
        return _tuple_like(joined, [half_type(leaf) for leaf in joined.types])
    if not isinstance(joined, LanesType):
        return joined
    return lanes_type(joined.count // 2, joined.number)


def spread_type(kind: Any, lanes: Any) -> Any:
    """A type with every number in it spread over lanes."""
    if isinstance(kind, types.BaseTuple):
        return _tuple_like(kind, [spread_type(leaf, lanes) for leaf in kind.types])
    return lanes


def _tuple_like(like: Any, items: list[Any]) -> Any:
    return types.BaseTuple.from_types(items, getattr(like, "instance_class", None))


def _numbers(args: Iterable[Any]) -> Any:
    # The lanes of floats among the arguments, if there are any and the rest are numbers.
    lanes = {arg for arg in args if isinstance(arg, LanesType) and arg.leaf == arg.number}
    sound = len(lanes) == 1 and all(arg in lanes or isinstance(arg, types.Number) for arg in args)
    return lanes.pop() if sound else None


def _same(*args: Any) -> Any:
    lanes = _numbers(args)
    return lanes and signature(lanes, *[lanes] * len(args))


def _compared(*args: Any) -> Any:
    lanes = _numbers(args)
    return lanes and signature(LanesType(types.boolean, lanes.count, lanes.number), lanes, lanes)


def _combined(first: Any, second: Any) -> Any:
    sound = isinstance(first, LanesType) and first == second and first.leaf == types.boolean
    return signature(first, first, second) if sound else None


def _selected(condition: Any, yes: Any, no: Any) -> Any:
    lanes = _numbers((yes, no)) or types.float64
    if isinstance(condition, LanesType):
        lanes = LanesType(condition.number, condition.count)
    return signature(lanes, condition, lanes, lanes)


def _parts(joined: Any, count: int) -> Any:
    return types.UniTuple(part_type(joined, count), count)


def _typed(functions: Iterable[Any], rule: Callable[..., Any]) -> None:
    # Let the compiler ask `rule` for the signature of these functions; None: not for lanes.
    for function in functions:

        class Rule(AbstractTemplate):
            key = function

            def generic(self, args: Any, kws: Any) -> Any:  # noqa: ARG002  (the compiler's own interface)
                return rule(*args)

        infer_global(function)(Rule)


_typed((*ARITHMETIC, *EXTREMES, *INTRINSICS, operator.neg), _same)
_typed(COMPARISONS, _compared)
_typed(LOGIC, _combined)
_typed([lanes.select], _selected)
_typed([lanes.epsilon], lambda number: signature(types.float64, number))
_typed([lanes.anywhere], lambda number: signature(types.boolean, number))
_typed([lanes.join], lambda first, second: signature(joined_type(first, second), first, second))
_typed([lanes.halves], lambda joined: signature(types.UniTuple(half_type(joined), 2), joined))
_typed([lanes.abreast], lambda items: signature(abreast_type(items.dtype, items.count), items))
_typed([lanes.apart], lambda joined, like: signature(_parts(joined, like.count), joined, like))
_typed([lanes.packed], lambda items: signature(packed_type(items), items))
_typed([lanes.unpacked], _unpacked)
_typed([lanes.sums_up_to, lanes.sums_from], lambda joined, like: signature(joined, joined, like))
_typed([lanes.write_row], lambda rows, _i, _j, values: signature(types.none, rows, types.intp, types.intp, values))
_typed([lanes.read_numbers], lambda like, numbers: signature(_value(like), like, numbers))
_typed([lanes.write_numbers], lambda numbers, values: signature(types.none, numbers, values))
_typed([lanes.in_lanes], lambda value, like: signature(spread_type(value, like), value, like))
_typed([lanes.write_lanes], lambda block, values: signature(types.none, block, values))


@infer_global(lanes.width)
class _Width(AbstractTemplate):
    key = lanes.width

    def generic(self, args: Any, kws: Any) -> Any:  # noqa: ARG002  (the compiler's own interface)
        return signature(types.intp, *args)


@infer_global(lanes.read_lanes)
class _ReadLanes(AbstractTemplate):
    key = lanes.read_lanes

    def generic(self, args: Any, kws: Any) -> Any:  # noqa: ARG002
        like, block, *beside = args
        count = width_in(self.context, *(beside or (like, block)))
        return signature(spread_type(_value(like), lanes_type(count, block.dtype)), *args)
