"""Values of a law's expressions while it is translated: known now, computed in C, stored in C, or still in parts."""

from dataclasses import dataclass, replace
from enum import IntEnum
from typing import Any

from layflat.export.c_source.c_types import (
    REAL_TYPE,
    Abreast,
    Items,
    Number,
    Record,
    Type,
    is_array,
    item_type,
    leaf_count,
    parts_of,
)


class Level(IntEnum):
    """Binding strength of an operator of C, from the loosest on."""

    TERNARY = 0
    OR = 1
    AND = 2
    COMPARISON = 3
    SUM = 4
    PRODUCT = 5
    UNARY = 6
    PRIMARY = 7


@dataclass(frozen=True)
class Known:
    """Value that is known when the law is translated: a constant, a function, a class, None or a tuple of these."""

    value: Any
    text: str = ""  # C's expression of it where it has a name
    level: int = Level.PRIMARY


@dataclass(frozen=True)
class Computed:
    """Number, or struct, that an expression of C computes."""

    text: str
    kind: Type
    level: int = Level.PRIMARY


@dataclass(frozen=True)
class Stored:
    """Struct or array in C's memory."""

    text: str
    kind: Type
    pointer: bool = False  # whether the text is a pointer to a struct
    constant: bool = True  # whether nothing changes it any more
    in_struct: bool = False  # whether it is a field of a struct, where a tuple of tuples is an array of structs
    grouped: bool = False  # whether the tuple is a struct of its items
    borrowed: bool = False  # whether slots copy it, and may be read where it is but not written

    @property
    def address(self) -> str:
        """Expression that passes it to a function."""
        return self.text if self.pointer or (is_array(self.kind) and not self.grouped) else f"&{self.text}"


@dataclass(frozen=True)
class Parts:
    """Tuple, or numbers side by side, whose items are values of their own."""

    items: "tuple[Value, ...]"
    cls: type | None = None  # of a named tuple
    abreast: bool = False


Value = Known | Computed | Stored | Parts


def type_of(value: Value, literal: Number = REAL_TYPE) -> Type:
    """Return the type of a value.

    Args:
        value: the value.
        literal: type of a float that is known.

    Raises:
        TypeError: it is no number and no tuple of numbers.
    """
    if isinstance(value, Known):
        return _known_type(value.value, literal)
    if not isinstance(value, Parts):
        return value.kind
    items = tuple(type_of(item, literal) for item in value.items)
    if value.abreast:
        return Abreast(items[0], len(items))
    return record_type(value.cls, items) if value.cls is not None else Items(items)


def record_type(cls: type, fields: tuple[Type, ...]) -> Type:
    """Return the type of a named tuple; of one whose fields are all so many side by side, named tuples side by side."""
    counts = {kind.count if isinstance(kind, Abreast) else 0 for kind in fields if leaf_count(kind)}
    if len(counts) == 1 and counts != {0}:
        items = tuple(kind.item if isinstance(kind, Abreast) else kind for kind in fields)
        return Abreast(record_type(cls, items), counts.pop())
    return Record(cls, fields)


def _known_type(value: Any, literal: Number) -> Type:
    from layflat.export.c_source.c_types import BOOL_TYPE, INT_TYPE  # noqa: PLC0415

    if isinstance(value, bool):
        return BOOL_TYPE
    if isinstance(value, int):
        return INT_TYPE
    if isinstance(value, float):
        return literal
    if isinstance(value, tuple):
        items = tuple(_known_type(item, literal) for item in value)
        return Record(type(value), items) if hasattr(value, "_fields") else Items(items)
    raise TypeError(f"{value!r} is no number")


def field_of(value: Value, name: str) -> Value:
    """Return a field of a named tuple; of those side by side, the fields side by side.

    Raises:
        AttributeError: there is no such field.
    """
    if isinstance(value, Known):
        return Known(getattr(value.value, name), f"{value.text}.{name}" if value.text else "")
    if isinstance(value, Parts) and value.cls is not None:
        return value.items[_index(value.cls, name)]
    kind = value.kind if isinstance(value, Computed | Stored) else None
    if not isinstance(kind, Record) and width(value) > 1:
        return side_by_side([field_of(lane(value, i), name) for i in range(width(value))])
    if not isinstance(kind, Record):
        raise AttributeError(name)
    i = _index(kind.cls, name)
    sign = "->" if isinstance(value, Stored) and value.pointer else "."
    return member(value, f"{value.text}{sign}{c_field(name)}", kind.fields[i])  # type: ignore[union-attr]


def c_field(name: str) -> str:
    """Return the name of a field in C."""
    from layflat.export.layout import c_name  # noqa: PLC0415

    return c_name(name)


def _index(cls: Any, name: str) -> int:
    if name not in cls._fields:
        raise AttributeError(name)
    return int(cls._fields.index(name))


def member(value: Value, text: str, kind: Type) -> Value:
    """Return a part of a stored value: a number is an expression of C.

    Args:
        value: the value.
        text: expression of the part.
        kind: its type.
    """
    if isinstance(kind, Number):
        return Computed(text, kind)
    constant = value.constant if isinstance(value, Stored) else True
    is_item = isinstance(value, Stored) and isinstance(value.kind, Items)
    in_struct = not is_item or (isinstance(value, Stored) and value.in_struct)
    grouped = isinstance(kind, Items) and (not is_array(kind) or (is_item and in_struct))
    return Stored(text, kind, constant=constant, in_struct=in_struct, grouped=grouped)


def item_of(value: Value, index: int | str) -> Value:
    """Return an item of a tuple.

    Args:
        value: the tuple.
        index: number, or C's expression of it.

    Raises:
        IndexError: there is no such item, or the number has to be known.
    """
    if isinstance(value, Known):
        if not isinstance(index, int):
            raise IndexError
        return Known(value.value[index])
    if isinstance(value, Parts):
        if not isinstance(index, int):
            raise IndexError
        return value.items[index]
    parts = parts_of(value.kind)
    if isinstance(index, int):
        index = range(len(parts))[index]
    if isinstance(value.kind, Record):
        return field_of(value, value.kind.cls._fields[index])  # type: ignore[attr-defined]
    if is_array(value.kind) and not (isinstance(value, Stored) and value.grouped):
        return member(value, f"{value.text}[{index}]", item_type(value.kind))
    if not isinstance(index, int):
        raise IndexError
    sign = "->" if isinstance(value, Stored) and value.pointer else "."
    return member(value, f"{value.text}{sign}item_{index}", parts[index])


def items_of(value: Value) -> list[Value]:
    """Return the items of a tuple; TypeError if it is none."""
    return [item_of(value, i) for i in range(length(value))]


def length(value: Value) -> int:
    """Return the number of items of a tuple; TypeError if it is none."""
    if isinstance(value, Known):
        return len(value.value)
    if isinstance(value, Parts) and not value.abreast:
        return len(value.items)
    if isinstance(value, Computed | Stored) and isinstance(value.kind, Record | Items):
        return len(parts_of(value.kind))
    raise TypeError("is no tuple")


def is_plain_tuple(value: Value) -> bool:
    """Return whether a value is a tuple without names."""
    if isinstance(value, Known):
        return type(value.value) is tuple
    if isinstance(value, Parts):
        return value.cls is None and not value.abreast
    return isinstance(value.kind, Items)


def width(value: Value) -> int:
    """Return how many numbers stand side by side in each leaf of a value; 1 where none do."""
    if isinstance(value, Known):
        return 1
    if isinstance(value, Parts):
        if value.abreast:
            return len(value.items)
        return max(map(width, value.items), default=1)
    return _type_width(value.kind)


def _type_width(kind: Type) -> int:
    if isinstance(kind, Abreast):
        return kind.count
    return max(map(_type_width, parts_of(kind)), default=1)


def lane(value: Value, i: int) -> Value:
    """Return number i of those side by side in each leaf; a value with one of each is returned as it is."""
    if width(value) == 1:
        return value
    if isinstance(value, Parts):
        if value.abreast:
            return value.items[i]
        return replace(value, items=tuple(lane(item, i) for item in value.items))
    kind = value.kind  # type: ignore[union-attr]
    if isinstance(kind, Abreast):
        return member(value, f"{value.text}[{i}]", kind.item)
    items = tuple(lane(item, i) for item in items_of(value))
    return Parts(items, kind.cls if isinstance(kind, Record) else None)


def side_by_side(items: list[Value]) -> Value:
    """Return values side by side; plain tuples item by item, and a single one as it is."""
    if len(items) == 1:
        return items[0]
    if is_plain_tuple(items[0]):
        return Parts(tuple(side_by_side([item_of(one, i) for one in items]) for i in range(length(items[0]))))
    return Parts(tuple(items), abreast=True)


def is_empty(value: Value) -> bool:
    """Return whether a tuple holds no numbers."""
    return not isinstance(value, Known) and leaf_count(type_of(value)) == 0
