"""Names of a law as variables of C: constants where they can be, else variables that are assigned again."""

import ast
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from layflat.export.c_source.c_types import (
    INT_TYPE,
    Items,
    Number,
    Record,
    Type,
    is_array,
    item_type,
    join_types,
    leaf_count,
)
from layflat.export.c_source.calls import Calls
from layflat.export.c_source.sources import law_source, scope
from layflat.export.c_source.storage import Into
from layflat.export.c_source.values import (
    Computed,
    Known,
    Parts,
    Stored,
    Value,
    is_plain_tuple,
    item_of,
    items_of,
    width,
)


@dataclass
class Facts:
    """Facts about a function that one pass over it finds, and the next one needs."""

    changing: dict[str, Type] = field(default_factory=dict)  # names that are assigned again, with their types
    outliving: set[str] = field(default_factory=set)  # names that are read behind the block that assigns them
    slots: set[str] = field(default_factory=set)  # names of slots of which items are assigned
    called: set[str] = field(default_factory=set)  # functions of C that it calls
    mode: str = "none"  # "value", "array", "several": how it returns its results
    results: tuple[Type, ...] = ()
    result_names: tuple[str, ...] = ()
    direct: tuple[str, ...] = ()  # names that stand for results, and are written where these go


class Variables(Calls):
    """Variables of a function.

    Args:
        program: the program that the function is a part of.
        law: the function of the law.
        facts: facts of the pass before.
    """

    def __init__(self, program: Any, law: Callable[..., Any], facts: Facts) -> None:
        super().__init__(program, law_source(law))
        self.outside, self.module, self.facts = scope(law), law.__module__, facts
        self.found = Facts(dict(facts.changing), set(facts.outliving), set(facts.slots), set(facts.called))
        self.scopes: list[dict[str, Value]] = [{}]
        self.kinds = dict[str, Type]()  # of the names so far
        self.names.taken |= facts.called
        self.name_by_value = dict[int, str]()  # names that stand for values, by the values' identities
        self.direct: dict[str, Stored] = {}  # places of results by the names that stand for them
        self.reads, self.binds = Counter[str](), Counter[str]()

    def scope_of(self, name: str) -> dict[str, Value] | None:
        """Return the innermost scope that has a name; None if none has it."""
        return next((scope for scope in reversed(self.scopes) if name in scope), None)

    def read(self, name: str) -> Value:
        """Return the value of a name, of the function or from outside."""
        scope = self.scope_of(name)
        self.reads[name] += 1
        if scope is not None:
            self.name_by_value[id(scope[name])] = name
            return scope[name]
        if name in self.kinds:
            self.found.outliving.add(name)
            self.found.changing[name] = self.kinds[name]
            kind = self.kinds[name]
            return Computed(name, kind) if isinstance(kind, Number) else Stored(name, kind)
        if name not in self.outside:
            self.fail(f"{name!r} has no value here", "give it one before it is read")
        value = self.outside[name]
        return Known(value, self.program.constant_name(self.module, name, value))

    def bind(self, name: str, value: Value) -> None:
        """Bind a name to a value from here on."""
        if name == "_":
            return
        if not isinstance(value, Known) or isinstance(value.value, bool | int | float):
            self.kinds[name] = self.kind_of(value)
        self.binds[name] += 1
        if name in self.facts.changing:
            self.assign(name, value)
            return
        if name in self.direct:
            self.scopes[-1][name] = self.written_result(self.direct[name], value)
            return
        scope = self.scope_of(name)
        if scope is not None:
            before = scope[name]
            numbers = all(isinstance(one, Computed) and isinstance(one.kind, Number) for one in (before, value))
            if scope is not self.scopes[-1] or numbers:
                self.note_change(name, before)
                self.note_change(name, value)
        self.scopes[-1][name] = self.constant(name, value)

    def note_change(self, name: str, value: Value) -> None:
        """Note that a name is assigned again, for the next pass."""
        kind = self.kind_of(value)
        joined = join_types(self.found.changing.get(name, kind), kind)
        if joined is None:
            self.fail(f"{name!r} changes its type", "use another name for the other value")
        self.found.changing[name] = joined

    def assign(self, name: str, value: Value) -> None:
        """Assign a variable that is assigned again, declared here if it is new."""
        self.note_change(name, value)
        kind, scope = self.facts.changing[name], self.scope_of(name)
        if scope is None:
            self.scopes[-1][name] = self._changing(name, value, kind)
            return
        place = scope[name]
        if isinstance(value, Parts) and isinstance(place, Stored) and place.text in self.texts(value):
            value = self.hold(value, f"next_{name}", kind)
        self.store(place, value, getattr(place, "text", ""))

    def _changing(self, name: str, value: Value, kind: Type) -> Value:
        """Declare a variable that is assigned again, with its first value."""
        if isinstance(kind, Number):
            if (
                isinstance(value, Computed)
                and value.text in self.unbound
                and value.kind == kind
                and not self.is_constant(value.text)
            ):
                self.unbound.discard(value.text)
                return value
            text = self.names.fresh(name)
            self.emit(f"{self.declarator(kind, text)} = {self.number(value, kind).text};", text)
            return Computed(text, kind)
        if (
            isinstance(value, Stored)
            and value.text in self.unbound
            and value.kind == kind
            and not self.is_constant(value.text)
        ):
            self.unbound.discard(value.text)
            return Stored(value.text, kind, constant=False, grouped=value.grouped)
        return self.copy_of(name, value, kind)

    def is_constant(self, text: str) -> bool:
        """Return whether a variable was declared as a constant."""
        return any(line.about == text and line.text.startswith("const ") for line in self.lines)

    def declared(self, name: str, kind: Type) -> Value:
        """Declare a variable without a value."""
        text = self.names.fresh(name)
        self.emit(f"{self.declarator(kind, text)};", text)
        if isinstance(kind, Number):
            return Computed(text, kind)
        return Stored(text, kind, constant=False, grouped=not isinstance(kind, Record) and not is_array(kind))

    def copy_of(self, name: str, value: Value, kind: Type) -> Stored:
        """Declare a variable that holds a copy of a struct or array.

        Args:
            name: its name.
            value: the struct or array.
            kind: its type.
        """
        text = self.names.fresh(name)
        grouped = not isinstance(kind, Record) and not is_array(kind)
        start = self.initializer(value, kind)
        if start is None:
            self.emit(f"{self.declarator(kind, text)};", text)
            self.store(Stored(text, kind, constant=False, grouped=grouped), value, text)
        else:
            self.emit_start(f"{self.declarator(kind, text)} = ", start, ";", text)
        return Stored(text, kind, constant=False, grouped=grouped)

    def constant(self, name: str, value: Value) -> Value:
        """Return the value that a name stands for, in a constant of C with this name where it is not simple."""
        if name in self.facts.slots:
            return self.slots_of(name, value)
        if isinstance(value, Known):
            return value
        if isinstance(value, Computed):
            if value.text in self.unbound:
                self.unbound.discard(value.text)
                return value
            text = self.names.fresh(name)
            self.emit(f"const {self.declarator(value.kind, text)} = {value.text};", text)
            return Computed(text, value.kind) if isinstance(value.kind, Number) else Stored(text, value.kind)
        if isinstance(value, Stored):
            return self.alias(name, value)
        return self.constant_parts(name, value)

    def slots_of(self, name: str, value: Value) -> Stored:
        """Return slots of which items are assigned: an array of their own."""
        if isinstance(value, Stored) and value.text in self.unbound and not self.is_constant(value.text):
            self.unbound.discard(value.text)
            return Stored(value.text, value.kind, constant=False, grouped=value.grouped)
        kind = self.kind_of(value)
        if not is_array(kind):
            self.fail(f"items of {name!r} are of several types", "use slots of items of one type")
        return self.copy_of(name, value, kind)

    def alias(self, name: str, value: Stored) -> Value:
        """Return a struct or array under another name: a pointer to it, or a copy if it may change."""
        if value.text in self.unbound:
            self.unbound.discard(value.text)
            return value
        kind = value.kind
        if leaf_count(kind) == 0 or (value.constant and value.text.isidentifier()):
            return value
        if not value.constant:
            copy = self.copy_of(name, value, kind)
            return Stored(copy.text, kind, grouped=copy.grouped)
        if is_array(kind) and not value.grouped and isinstance(item_type(kind), Number | Record):
            text = self.names.fresh(name)
            self.emit(f"const {self.c_type(item_type(kind))} *{text} = {value.text};", text)
            return Stored(text, kind, in_struct=value.in_struct)
        if is_array(kind) and not value.grouped:
            return value
        text = self.names.fresh(name)
        self.emit(f"const {self.c_type(kind)} *{text} = {value.address};", text)
        return Stored(text, kind, pointer=True, grouped=value.grouped)

    def constant_parts(self, name: str, value: Parts) -> Value:
        """Return a tuple in parts under a name: a struct or array if its items are numbers, else each by itself."""
        if all(isinstance(item, Known) and not isinstance(item.value, bool | int | float) for item in value.items):
            return value
        kind = self.kind_of(value)
        if leaf_count(kind) == 0:
            return value
        listed = value.abreast or isinstance(kind, Items)
        if listed and is_array(kind) and isinstance(item_type(kind), Number) and len(value.items) > 1:
            held = self.hold(value, name)
            self.unbound.discard(held.text)
            return held
        if (isinstance(kind, Record) and width(value) == 1) or (value.cls is not None and is_array(kind)):
            held = self.hold(value, name)
            self.unbound.discard(held.text)
            return held
        fields = value.cls._fields if value.cls is not None else range(1, len(value.items) + 1)  # type: ignore[attr-defined]
        items = tuple(self.constant(f"{name}_{label}", item) for label, item in zip(fields, value.items, strict=True))
        return Parts(items, value.cls, value.abreast)

    def pairs(self, target: ast.expr, value: Value) -> list[tuple[ast.expr, Value]]:
        """Return the targets of an assignment with their values."""
        if not isinstance(target, ast.Tuple | ast.List):
            return [(target, value)]
        value = self.hold_parts(value, "item")
        if not is_plain_tuple(value) and not isinstance(self.kind_of(value), Record):
            self.fail("a number is assigned to several names", "assign a tuple with as many items")
        items = items_of(value)
        if len(items) != len(target.elts) or any(isinstance(one, ast.Starred) for one in target.elts):
            self.fail(f"{len(items)} items are assigned to {len(target.elts)} names", "use one name per item")
        return [pair for one, item in zip(target.elts, items, strict=True) for pair in self.pairs(one, item)]

    def place_for(self, name: str) -> Into:
        """Return the place for a result that a name is to stand for."""
        return Into("unused" if name == "_" else name, self.direct.get(name))

    def items_at(self, node: ast.Subscript) -> Value:
        """Return the item of slots that is assigned; note that the slots change."""
        base = self.value(node.value)
        if isinstance(node.value, ast.Name):
            self.note_slots(node.value.id)
        index = self.value(node.slice)
        if not isinstance(base, Stored):
            base = self.hold(base, "slots")
        at = index.value if isinstance(index, Known) else self.number(index, INT_TYPE).text
        return item_of(base, at)

    def note_slots(self, name: str) -> None:
        """Note that items of slots are assigned."""
        if name in self.parameters:
            self.changed.add(name)
        else:
            self.found.slots.add(name)

    def written_result(self, place: Stored, value: Value) -> Value:
        """Write a result where it goes, and return it as it can be read there."""
        raise NotImplementedError

    parameters: dict[str, Any]
    changed: set[str]
