"""Variables of a function in C: declared, filled, copied and passed."""

import ast
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple, NoReturn

from layflat.errors import KindError
from layflat.export.c_source.c_types import (
    BOOL_TYPE,
    CONDITION_TYPES,
    DOUBLE_TYPE,
    INT_TYPE,
    REAL_TYPE,
    Abreast,
    Number,
    Record,
    Type,
    is_array,
    item_type,
    leaf_count,
    parts_of,
)
from layflat.export.c_source.lines import Line, read_names
from layflat.export.c_source.names import Names
from layflat.export.c_source.sources import LawSource
from layflat.export.c_source.values import (
    Computed,
    Known,
    Level,
    Parts,
    Stored,
    Value,
    c_field,
    field_of,
    item_of,
    items_of,
    lane,
    type_of,
)
from layflat.export.numbers import c_number

MAX_LISTED = 4  # items of an array that are written one by one; more are copied in a loop
LINE_LENGTH = 100  # columns up to which a struct's fields stand in one line


class Into(NamedTuple):
    """Place for a result: the name of a variable to declare, or one that is there."""

    name: str
    place: Stored | None = None


NO_PLACE = Into("")


class Storage:
    """Variables and lines of a function.

    Args:
        program: the program that the function is a part of.
        source: source of the law.
    """

    def __init__(self, program: Any, source: LawSource) -> None:
        self.program, self.source, self.names = program, source, Names()
        self.lines: list[Line] = []
        self.node: ast.AST = source.tree  # that is translated now
        self.depth = 1
        self.unbound = set[str]()  # variables in C that no name in the law stands for yet
        self.literal: Number = REAL_TYPE if program.precision == "double" else DOUBLE_TYPE

    def fail(self, what: str, right: str) -> NoReturn:
        """Raise KindError for a construct that has no counterpart in C: the one that is translated now."""
        line = self.source.first_line + getattr(self.node, "lineno", 1) - 1
        raise KindError(what, where=f"{self.source.file}:{line}", right=right)

    def kind_of(self, value: Value) -> Type:
        """Return the type of a value; raise KindError if it is no number and no tuple of numbers."""
        try:
            return type_of(value, self.literal)
        except TypeError:
            self.fail(f"{getattr(value, 'value', value)!r} is used as a number", "use numbers and named tuples")

    # Lines

    def emit(self, text: str, about: str = "") -> None:
        """Add a line, which may be there for a variable alone."""
        self.lines.append(Line(text, self.depth, about))

    @contextmanager
    def block(self, head: str, about: str = "") -> Iterator[None]:
        """Put the lines that are added meanwhile into braces behind a head."""
        self.emit(f"{head} {{", about)
        self.depth += 1
        yield
        self.depth -= 1
        self.emit("}", about)

    @contextmanager
    def counting(self, count: int | str, about: str = "") -> Iterator[str]:
        """Put the lines that are added meanwhile into a loop; yield the name of its counter."""
        with (
            self.names.counter() as counter,
            self.block(f"for (int {counter} = 0; {counter} < {count}; {counter}++)", about),
        ):
            yield counter

    # Numbers

    def number(self, value: Value, kind: Type) -> Computed:
        """Return a value as an expression of a number's type; raise KindError if it is no number."""
        if isinstance(value, Known) and isinstance(value.value, bool | int | float):
            return self._known_number(value, kind)
        if not isinstance(value, Computed) or not isinstance(value.kind, Number):
            self.fail("a tuple is used as a number", "take one of its items")
        if value.kind == kind or self.c_type(value.kind) == self.c_type(kind):
            return Computed(value.text, kind, value.level)
        if kind in CONDITION_TYPES:
            return Computed(
                f"{self.paren(value, Level.COMPARISON + 1)} != {self.zero(value.kind)}", BOOL_TYPE, Level.COMPARISON
            )
        if value.kind in CONDITION_TYPES:
            one, zero = (self._known_number(Known(number), kind).text for number in (1, 0))
            return Computed(f"{self.paren(value, Level.TERNARY + 1)} ? {one} : {zero}", kind, Level.TERNARY)
        return Computed(f"({self.c_type(kind)}){self.paren(value, Level.UNARY)}", kind, Level.UNARY)

    def zero(self, kind: Type) -> str:
        """Return zero as a literal of a number's type."""
        return self._known_number(Known(0), kind).text

    def _known_number(self, value: Known, kind: Type) -> Computed:
        if kind == INT_TYPE:
            text = self.program.constant_text(value, kind) or str(int(value.value))
        elif kind in CONDITION_TYPES:
            text = "true" if value.value else "false"
        else:
            real = self.c_type(kind)
            named = self.program.constant_text(value, kind)
            if named:
                return Computed(named, kind, value.level)
            text = c_number(float(value.value), real)
        return Computed(text, kind, Level.UNARY if text.startswith("-") else Level.PRIMARY)

    def paren(self, value: Value, level: int) -> str:
        """Return the expression of a value, in parentheses if it binds less than a level."""
        assert not isinstance(value, Parts)
        text = value.text
        return f"({text})" if getattr(value, "level", Level.PRIMARY) < level else text

    # Declarations

    def c_type(self, kind: Type) -> str:
        """Return C's type of a number or struct."""
        return str(self.program.c_type(kind))

    def declarator(self, kind: Type, name: str, *, grouped: bool = False) -> str:
        """Return the declaration of a variable without its value.

        Args:
            kind: its type.
            name: its name.
            grouped: whether a tuple is a struct of its items.
        """
        sizes = ""
        while is_array(kind) and not grouped:
            sizes += f"[{len(parts_of(kind))}]"
            kind = item_type(kind)
        return f"{self.c_type(kind)} {name}{sizes}"

    def variable(self, into: Into, kind: Type, default: str) -> Stored:
        """Return the place for a result: the one that there is, or a variable that is declared here.

        Args:
            into: the place, or the name of the variable.
            kind: type of the result.
            default: name of the variable if it has none.
        """
        place = into.place
        if place is not None and place.kind == kind and not (place.in_struct and _is_nested(kind)):
            return place
        name = self.names.fresh(into.name or default)
        self.emit(f"{self.declarator(kind, name)};", name)
        self.unbound.add(name)
        return Stored(name, kind, grouped=not isinstance(kind, Number | Record) and not is_array(kind))

    def hold(self, value: Value, name: str, kind: Type | None = None) -> Stored:
        """Return a struct or array in memory with a value, declared here if need be.

        Args:
            value: the value.
            name: name of the variable, if one is declared.
            kind: its type, if another than the value's.
        """
        kind = self.kind_of(value) if kind is None else kind
        if isinstance(value, Stored) and value.kind == kind and not (value.in_struct and _is_nested(kind)):
            return value
        if isinstance(value, Known) and (text := self.constant_struct(value, kind)):
            return Stored(text, kind)
        name = self.names.fresh(name)
        start = self.initializer(value, kind)
        if start is None:
            self.emit(f"{self.declarator(kind, name)};", name)
            place = Stored(name, kind, constant=False)
            self.store(place, value, about=name)
        else:
            self.emit_start(f"const {self.declarator(kind, name)} = ", start, ";", name)
        self.unbound.add(name)
        return Stored(name, kind, grouped=not isinstance(kind, Record) and not is_array(kind))

    def emit_start(self, head: str, start: "str | list[tuple[str, Any]]", end: str, about: str = "") -> None:
        """Add a declaration or return of a struct, its fields one a line where they are too long for one line.

        Args:
            head: text before the initializer.
            start: the initializer.
            end: text behind it.
            about: variable for which alone the lines are there.
        """
        flat = flat_text(start)
        if isinstance(start, str) or len(head) + len(flat) + 4 * self.depth <= LINE_LENGTH:
            self.emit(f"{head}{flat}{end}", about)
            return
        self.emit(f"{head}{{", about)
        self.depth += 1
        for name, part in start:
            self.emit_start(name, part, ",", about)
        self.depth -= 1
        self.emit(f"}}{end}", about)

    def initializer(self, value: Value, kind: Type) -> "str | list[tuple[str, Any]] | None":
        """Return the initializer of a value: text, or parts with labels; None for an array that has to be filled."""
        if isinstance(kind, Number):
            return self.number(value, kind).text
        if isinstance(value, Known) and (text := self.constant_struct(value, kind)):
            return text
        same = isinstance(value, Computed | Stored) and value.kind == kind
        if same and not is_array(kind):
            assert isinstance(value, Computed | Stored)
            return f"*{value.text}" if isinstance(value, Stored) and value.pointer else value.text
        if isinstance(kind, Record):
            named = [(name, part) for name, part in zip(kind.cls._fields, kind.fields, strict=True)]  # type: ignore[attr-defined]
            parts = [
                (f".{c_field(name)} = ", self.initializer(field_of(value, name), part))
                for name, part in named
                if leaf_count(part)
            ]
        elif is_array(kind) and len(parts_of(kind)) > MAX_LISTED and not isinstance(value, Parts):
            return None
        else:
            items = [lane(value, i) for i in range(kind.count)] if isinstance(kind, Abreast) else items_of(value)
            parts = [("", self.initializer(item, part)) for item, part in zip(items, parts_of(kind), strict=True)]
        return None if any(part is None for _, part in parts) else parts

    def constant_struct(self, value: Known, kind: Type) -> str:
        """Return the name of a constant struct; "" where there is none."""
        is_struct = isinstance(kind, Record) and isinstance(value.value, tuple) and self.kind_of(value) == kind
        return str(self.program.constant_text(value, kind)) if is_struct else ""

    # Copies

    def store(self, place: Value, value: Value, about: str = "") -> None:
        """Add the lines that copy a value into a variable, a field or an item.

        Args:
            place: the place.
            value: the value.
            about: variable for which alone this is done.
        """
        assert isinstance(place, Computed | Stored)
        kind = place.kind
        if isinstance(kind, Number):
            self.emit(f"{place.text} = {self.number(value, kind).text};", about)
        elif leaf_count(kind) == 0 or (isinstance(value, Stored) and value.text == place.text):
            return
        elif not is_array(kind) and isinstance(value, Computed | Stored) and value.kind == kind:
            left = f"*{place.text}" if isinstance(place, Stored) and place.pointer else place.text
            right = f"*{value.text}" if isinstance(value, Stored) and value.pointer else value.text
            self.emit(f"{left} = {right};", about)
        elif isinstance(kind, Record):
            for name in kind.cls._fields:  # type: ignore[attr-defined]
                self.store(field_of(place, name), field_of(value, name), about)
        elif is_array(kind) and len(parts_of(kind)) > 1 and isinstance(value, Stored) and value.kind == kind:
            with self.counting(len(parts_of(kind)), about) as i:
                self.store(item_of(place, i), item_of(value, i), about)
        else:
            for at in range(len(parts_of(kind))):
                part = lane(value, at) if isinstance(kind, Abreast) else item_of(value, at)
                self.store(item_of(place, at), part, about)

    def texts(self, value: Value) -> set[str]:
        """Return the names of variables that a value reads."""
        if isinstance(value, Known):
            return set()
        if isinstance(value, Parts):
            return {name for item in value.items for name in self.texts(item)}
        return read_names(value.text)


def _is_nested(kind: Type) -> bool:
    """Return whether a type is a tuple of tuples, whose form inside a struct is another one."""
    return is_array(kind) and not isinstance(item_type(kind), Number | Record)


def flat_text(start: "str | list[tuple[str, Any]]") -> str:
    """Return an initializer in one line."""
    if isinstance(start, str):
        return start
    return f"{{{', '.join(f'{name}{flat_text(part)}' for name, part in start)}}}"
