"""Types of the numbers and tuples in a law, as the compiler infers them, and their structs in C.

A law in single precision computes with two types of floats: numbers that come from a struct or an array round to single
precision, and literals and the cycle's time stay in double precision until they meet one of these.
"""

from dataclasses import dataclass
from typing import Any

from layflat.lanes import Lanes


@dataclass(frozen=True)
class Number:
    """Type of a number."""

    name: str
    rank: int  # a number of higher rank takes in one of lower rank


@dataclass(frozen=True)
class Record:
    """Type of a named tuple."""

    cls: type
    fields: "tuple[Type, ...]"


@dataclass(frozen=True)
class Items:
    """Type of a plain tuple, or of slots."""

    items: "tuple[Type, ...]"


@dataclass(frozen=True)
class Abreast:
    """Type of numbers or named tuples side by side, which a law treats as one."""

    item: "Type"
    count: int


Type = Number | Record | Items | Abreast

BOOL_TYPE, INT_TYPE, DOUBLE_TYPE, REAL_TYPE = (
    Number("bool", 0),
    Number("int", 1),
    Number("double", 2),
    Number("real", 3),
)
REAL_BOOL_TYPE = Number("real bool", 0)  # condition on numbers of single precision, which are what it selects, too
CONDITION_TYPES = BOOL_TYPE, REAL_BOOL_TYPE


class LeafOfType:
    """Leaf of a tuple that stands for a number of a C type other than the precision's own."""

    def __init__(self, c_type: str) -> None:
        self.c_type = c_type


def type_of_tuple(value: Any) -> Type:
    """Return the type of a nested tuple of numbers that a struct holds: floats of the precision."""
    if not isinstance(value, tuple):
        return REAL_TYPE
    if isinstance(value, Lanes):
        return Abreast(REAL_TYPE, len(value))
    items = tuple(map(type_of_tuple, value))
    return Record(type(value), items) if hasattr(value, "_fields") else Items(items)


def leaf_count(kind: Type) -> int:
    """Return the number of numbers in a value of a type."""
    if isinstance(kind, Number):
        return 1
    if isinstance(kind, Abreast):
        return kind.count * leaf_count(kind.item)
    return sum(map(leaf_count, parts_of(kind)))


def parts_of(kind: Type) -> tuple[Type, ...]:
    """Return the types of the items of a tuple."""
    if isinstance(kind, Abreast):
        return (kind.item,) * kind.count
    return kind.fields if isinstance(kind, Record) else kind.items if isinstance(kind, Items) else ()


def is_array(kind: Type) -> bool:
    """Return whether a type is an array in C: items of one type that hold numbers."""
    if isinstance(kind, Abreast):
        return True
    return isinstance(kind, Items) and len(set(kind.items)) == 1 and leaf_count(kind.items[0]) > 0


def item_type(kind: Type) -> Type:
    """Return the type of an array's items."""
    return parts_of(kind)[0]


def join_types(first: Type, second: Type) -> Type | None:
    """Return the type that holds values of both types; None where there is none."""
    if first == second:
        return first
    if isinstance(first, Number) and isinstance(second, Number):
        return max(first, second, key=lambda kind: kind.rank)
    if isinstance(first, Record) and isinstance(second, Record) and first.cls is second.cls:
        fields = _join_parts(first, second)
        return None if fields is None else Record(first.cls, fields)
    if isinstance(first, Items) and isinstance(second, Items) and len(first.items) == len(second.items):
        items = _join_parts(first, second)
        return None if items is None else Items(items)
    return None


def _join_parts(first: Type, second: Type) -> tuple[Type, ...] | None:
    joined = tuple(join_types(a, b) for a, b in zip(parts_of(first), parts_of(second), strict=True))
    return None if None in joined else joined  # type: ignore[return-value]


def skeleton(kind: Type) -> Any:
    """Return a nested tuple with the structure of a type, from which its struct is laid out."""
    if isinstance(kind, Number):
        return 0.0 if kind == REAL_TYPE else LeafOfType(kind.name.removeprefix("real "))
    if isinstance(kind, Record):
        return kind.cls(*map(skeleton, kind.fields))
    return tuple(map(skeleton, parts_of(kind)))
