"""Results of functions: one by value, arrays and several results through pointers."""

import ast
from collections.abc import Callable
from typing import Any

from layflat.export.c_source.c_types import Abreast, Items, Number, Type, is_array, join_types, leaf_count
from layflat.export.c_source.statements import Statements, label_of
from layflat.export.c_source.storage import NO_PLACE, Into
from layflat.export.c_source.values import Computed, Known, Level, Parts, Stored, Value, is_plain_tuple, items_of
from layflat.export.c_source.variables import Facts


class ResultStatements(Statements):
    """Results of a function."""

    outputs: tuple[Stored, ...] = ()  # places for several results, or an array
    hints: tuple[str, ...] = ()  # names for them, from the function that calls this one

    def __init__(self, program: Any, law: Callable[..., Any], facts: Facts) -> None:
        super().__init__(program, law, facts)
        self.returned: list[tuple[Value, ast.expr]] = []

    def add_return(self, node: ast.Return) -> None:
        """Return results: one by value, several and arrays through pointers."""
        if node.value is None:
            self.fail("a law returns nothing", "return numbers or named tuples")
        mode = self.facts.mode
        if mode == "several" and len(displayed(node.value)) == len(self.outputs):
            values = []
            for one, place in zip(displayed(node.value), self.outputs, strict=True):
                values.append(self.value(one, (Into("", place),)))
            value: Value = Parts(tuple(values))
        else:
            value = self.value(node.value, tuple(Into("", place) for place in self.outputs) or (NO_PLACE,))
        self.returned.append((value, node.value))
        if mode == "value":
            self.return_value(value, self.facts.results[0])
        elif mode == "array":
            self.store(self.outputs[0], value)
        elif mode == "several":
            for place, item in zip(self.outputs, items_of(value), strict=True):
                self.write_result(place, item)
        if mode in ("array", "several") and self.depth > 1:
            self.emit("return;")
        self.ended = True

    def write_result(self, place: Stored, value: Value) -> None:
        """Write one of several results."""
        same = isinstance(value, Computed | Stored) and value.text in (place.text, f"*{place.text}")
        if leaf_count(place.kind) == 0 or same:
            return
        if isinstance(place.kind, Number):
            self.emit(f"*{place.text} = {self.number(value, place.kind).text};")
            return
        start = self.initializer(value, place.kind) if isinstance(value, Parts | Known) and place.pointer else None
        if start is None:
            self.store(place, value)
        elif isinstance(start, str):
            self.emit(f"*{place.text} = {start};")
        else:
            self.emit_start(f"*{place.text} = ({self.c_type(place.kind)})", start, ";")

    def return_value(self, value: Value, kind: Type) -> None:
        """Return a number or a struct."""
        if isinstance(kind, Number):
            self.emit(f"return {self.number(value, kind).text};")
        elif isinstance(value, Computed | Stored) and value.kind == kind:
            self.emit(f"return {f'*{value.text}' if isinstance(value, Stored) and value.pointer else value.text};")
        else:
            start = self.initializer(value, kind)
            if isinstance(start, str):
                self.emit(f"return {start};")
            elif start is None:
                held = self.hold(value, "result", kind)
                self.emit(f"return {held.text};")
            else:
                self.emit_start(f"return ({self.c_type(kind)})", start, ";")

    def note_results(self) -> None:
        """Note how the function returns, for the next pass."""
        kinds: tuple[Type, ...] | None = None
        several = any(isinstance(value, Parts | Known) and is_plain_tuple(value) for value, _ in self.returned)
        for value, _ in self.returned:
            kind = self.kind_of(value)
            if isinstance(kind, Items) and (several or not is_array(kind)):
                several, these = True, kind.items
            else:
                these = (kind,)
            kinds = these if kinds is None else self.joined_results(kinds, these)
        self.found.results = kinds or ()
        if kinds is None:
            self.found.mode = "none"
        elif several:
            self.found.mode = "several"
            self.found.result_names, self.found.direct = self.labels(kinds)
        elif isinstance(kinds[0], Items | Abreast):
            self.found.mode, self.found.result_names = "array", ("result",)
        else:
            self.found.mode = "value"

    def joined_results(self, before: tuple[Type, ...], these: tuple[Type, ...]) -> tuple[Type, ...]:
        """Return the types of results that several statements return."""
        joined = tuple(join_types(a, b) for a, b in zip(before, these, strict=False))
        if len(before) != len(these) or None in joined:
            self.fail("results differ in their types", "return the same types everywhere")
        return joined  # type: ignore[return-value]

    def labels(self, kinds: tuple[Type, ...]) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Return names for several results, and those of them that stand for nothing else in the function."""
        count = len(kinds)
        displays = [displayed(node) for _, node in self.returned if len(displayed(node)) == count]
        hints = self.hints if len(self.hints) == count else ("",) * count
        own, names, direct = set(self.kinds) | set(self.parameters), [], []
        for i, kind in enumerate(kinds):
            node = displays[-1][i] if displays else None
            label = node.id if isinstance(node, ast.Name) else "" if hints[i] == "unused" else hints[i].strip("_")
            label = label or label_of(node) or f"result_{i + 1}"
            if isinstance(node, ast.Name) and len(self.returned) == 1 and self.is_result_alone(node.id, kind):
                direct.append(label)
            elif label in own:
                label = f"{label}_out"
            names.append(label)
        return tuple(names), tuple(direct)

    def is_result_alone(self, name: str, kind: Type) -> bool:
        """Return whether a name is bound once, for a result, so that it can be written where that goes."""
        once = self.binds[name] == 1 and name not in self.parameters and name in self.scopes[0]
        changes = name in self.found.changing or name in self.found.slots
        same = name in self.kinds and self.kinds[name] == kind and leaf_count(kind) > 0
        return once and not changes and same and (not isinstance(kind, Number) or self.reads[name] == 1)

    def written_result(self, place: Stored, value: Value) -> Value:
        """Write a result where it goes, and return it as it can be read there."""
        self.write_result(place, value)
        if isinstance(value, Stored):
            self.unbound.discard(value.text)
        if isinstance(place.kind, Number):
            return Computed(f"*{place.text}", place.kind, Level.UNARY)
        return Stored(place.text, place.kind, pointer=place.pointer, grouped=place.grouped)


def displayed(node: ast.expr) -> list[ast.expr]:
    """Return the expressions of the items of a tuple; none of any other expression, and of items with a star."""
    items = node.elts if isinstance(node, ast.Tuple) else []
    return [] if any(isinstance(one, ast.Starred) for one in items) else items
