"""A program of C: the functions of a law and of all laws that it calls."""

import ast
from collections.abc import Callable
from typing import Any

from layflat.export.c_source.c_types import Items, Number, Record, is_array, leaf_count
from layflat.export.c_source.definitions import Definitions
from layflat.export.c_source.function import ArgumentType, Body, CFunction, Parameter, Same, Spread, translate
from layflat.export.c_source.names import usable_name
from layflat.export.c_source.sources import law_source
from layflat.export.c_source.storage import NO_PLACE, Into
from layflat.export.c_source.values import Computed, Known, Parts, Stored, Value, item_of, lane, width
from layflat.export.c_source.variables import Facts
from layflat.jit import ByKind, Law


class Program(Definitions):
    """Functions, constants and structs of C.

    Args:
        api: interface whose structs the program shares.
        precision: "double" or "single".
    """

    def __init__(self, api: Any, precision: str) -> None:
        super().__init__(api, precision)
        self.functions: dict[Any, CFunction] = {}  # by law and types, each after those that it calls
        self._names: dict[str, list[Any]] = {}
        self._open = list[Any]()

    def call(
        self, body: Any, law: Callable[..., Any], args: list[Value], named: dict[str, Value], into: tuple[Into, ...]
    ) -> Value:
        """Return the result of a law that a function calls.

        Args:
            body: the function.
            law: Python's function of the law.
            args: arguments in order.
            named: arguments by name.
            into: places for the results.
        """
        names, values = self._bound(body, law, args, named)
        inlined = self._inlined(body, law, names, values, into)
        if inlined is not None:
            return inlined
        function = self._function(body, law, names, values, tuple(one.name for one in into))
        passed = [
            text
            for value, parameters in zip(values, function.parameters, strict=True)
            for text in self._passed(body, value, parameters)
        ]
        body.found.called.add(function.name)
        if function.mode == "value":
            kind = function.kind
            return Computed(f"{function.name}({', '.join(passed)})", kind) if leaf_count(kind) else Stored("", kind)
        outputs = []
        for i, result in enumerate(function.results):
            place = into[i] if len(into) == len(function.results) else NO_PLACE
            outputs.append(self._output(body, place, result))
        body.emit(
            f"{function.name}({', '.join((*passed, *(place.address for place in outputs if leaf_count(place.kind))))});"
        )
        values = [
            Computed(place.text, place.kind) if isinstance(place.kind, Number) and not place.pointer else place
            for place in outputs
        ]
        return Parts(tuple(values)) if function.mode == "several" else values[0] if values else Known(None)

    def _output(self, body: Any, into: Into, result: Parameter) -> Stored:
        """Return the place for one of several results."""
        if leaf_count(result.kind) == 0:
            return Stored("", result.kind)
        place: Stored = body.variable(into, result.kind, result.name.removesuffix("_out"))
        return place

    def _bound(
        self, body: Any, law: Callable[..., Any], args: list[Value], named: dict[str, Value]
    ) -> tuple[list[str], list[Value]]:
        """Return the parameters' names of a law and their arguments."""
        tree = law_source(law).tree
        if tree.args.vararg or tree.args.kwarg or tree.args.kwonlyargs:
            body.fail(f"{law.__name__!r} takes any number of arguments", "name each parameter")
        names = [one.arg for one in (*tree.args.posonlyargs, *tree.args.args)]
        given = dict(zip(names, args, strict=False)) | named
        defaults = law.__defaults__ or ()
        given = {
            name: Known(value) for name, value in zip(names[len(names) - len(defaults) :], defaults, strict=True)
        } | given
        if len(args) > len(names) or set(given) != set(names):
            body.fail(f"{law.__name__!r} takes {len(names)} arguments", f"give {', '.join(names)}")
        return names, [given[name] for name in names]

    def _function(
        self, body: Any, law: Callable[..., Any], names: list[str], values: list[Value], hints: tuple[str, ...]
    ) -> CFunction:
        """Return the function of C of a law for arguments of these types; `hints` are names for its results."""
        kinds = [argument_type(body, value) for value in values]
        key = law, tuple(kinds)
        if key not in self.functions:
            if key in self._open:
                body.fail(f"{law.__name__!r} calls itself", "use a loop")
            self._open.append(key)
            function = translate(self, law, self._function_name(law, key), names, kinds, hints)
            self._open.remove(key)
            self.functions[key] = function
        return self.functions[key]

    def _function_name(self, law: Callable[..., Any], key: Any) -> str:
        """Return the name of a function: the law's, with that of its module or a number if it is taken."""
        plain = usable_name(law.__name__)
        laws = self._names.setdefault(plain, [])
        if key not in laws:
            laws.append(key)
        if laws.index(key) and laws[0][0] is not law:
            plain = usable_name(f"{law.__module__.rpartition('.')[2]}_{plain}")
            laws = self._names.setdefault(plain, [])
            if key not in laws:
                laws.append(key)
        number = laws.index(key)
        return f"{plain}_{number + 1}" if number else plain

    def _passed(self, body: Any, value: Value, parameters: tuple[Parameter, ...]) -> list[str]:
        """Return the arguments of C for an argument of a law."""
        texts = []
        for i, parameter in enumerate(parameters):
            part = lane(value, i) if len(parameters) > 1 else value
            if not parameter.read:
                continue
            if isinstance(parameter.kind, Number):
                texts.append(body.number(part, parameter.kind).text)
                continue
            held: Stored = (
                self._changed(body, part, parameter)
                if parameter.changed
                else body.hold(part, parameter.name, parameter.kind)
            )
            texts.append(held.address)
        return texts

    def _changed(self, body: Any, value: Value, parameter: Parameter) -> Stored:
        """Return slots that a function changes; note that those of the function that calls it change, too."""
        name = body.name_by_value.get(id(value), "")
        if name:
            body.note_slots(name)
        if isinstance(value, Stored) and not value.borrowed and (not value.constant or name in body.parameters):
            return value
        copy: Stored = body.copy_of(parameter.name, value, parameter.kind)
        return copy

    def _inlined(
        self, body: Any, law: Callable[..., Any], names: list[str], values: list[Value], into: tuple[Into, ...]
    ) -> Value | None:
        """Return the result of a composition that only arranges numbers side by side; None for any other law."""
        source = law_source(law)
        first, *rest = [one for one in source.tree.body if not _is_docstring(one)]
        joins = {"join", "halves", "abreast", "apart"} & set(law.__code__.co_names)
        many = any(width(value) > 1 for value in values)
        if rest or not isinstance(first, ast.Return) or first.value is None or not (joins or many):
            return self._inlined_pair(body, law, names, values, into, joins)
        return self._evaluated(body, law, names, values, [first], into)

    def _inlined_pair(
        self,
        body: Any,
        law: Callable[..., Any],
        names: list[str],
        values: list[Value],
        into: tuple[Into, ...],
        joins: set[str],
    ) -> Value | None:
        """Return the result of a composition that takes numbers apart and returns them; None for any other law."""
        tree = [one for one in law_source(law).tree.body if not _is_docstring(one)]
        is_pair = len(tree) == 2 and isinstance(tree[0], ast.Assign) and isinstance(tree[1], ast.Return)
        if not joins or not is_pair or len(names) != 1:
            return None
        return self._evaluated(body, law, names, values, tree, into)

    def _evaluated(
        self,
        body: Any,
        law: Callable[..., Any],
        names: list[str],
        values: list[Value],
        nodes: list[ast.stmt],
        into: tuple[Into, ...],
    ) -> Value:
        """Return the result of statements inside another function."""
        inner = Body(self, law, Facts())
        inner.lines, inner.names, inner.unbound, inner.depth = body.lines, body.names, body.unbound, body.depth
        inner.found = body.found
        inner.parameters = {}
        inner.scopes[0].update(zip(names, values, strict=True))
        for one in nodes[:-1]:
            assert isinstance(one, ast.Assign)
            for target, value in inner.pairs(one.targets[0], inner.value(one.value)):
                inner.scopes[0][target.id] = value  # type: ignore[attr-defined]
        last = nodes[-1]
        assert isinstance(last, ast.Return)
        assert last.value is not None
        return inner.value(last.value, into)

    def looped_call(self, body: Any, law: Any, args: list[Value], count: int, into: tuple[Into, ...]) -> Value | None:
        """Return the results of a law for the items of tuples, computed in a loop; None where that can't be.

        Args:
            body: the function that calls it.
            law: the law.
            args: its arguments: arrays, and values for all calls.
            count: number of the arrays' items.
            into: places for the results.
        """

        def arguments_at(index: int | str) -> list[Value]:
            return [
                item_of(arg, index) if isinstance(arg, Stored) and isinstance(arg.kind, Items) else arg for arg in args
            ]

        found = law
        while isinstance(found, ByKind):
            kind = body.kind_of(arguments_at(0)[0])
            found = found.kinds.get(kind.cls) if isinstance(kind, Record) else None
        if not isinstance(found, Law):
            return None
        names, values = self._bound(body, found.py_func, arguments_at(0), {})
        function = self._function(body, found.py_func, names, values, ())
        if function.mode == "array" or (function.mode == "value" and not leaf_count(function.kind)):
            return None
        arrays: list[Stored] = []
        for i, result in enumerate(function.results):
            place = into[i] if len(into) == len(function.results) else NO_PLACE
            default = result.name.removesuffix("_out") or function.name
            kind = Items((result.kind,) * count)
            arrays.append(body.variable(place, kind, default) if leaf_count(kind) else Stored("", kind))
        first = arrays[0]
        alone = function.mode == "value" and isinstance(first, Stored) and first.text in body.unbound
        with body.counting(count, first.text if alone else "") as at_item:
            items = [item_of(place, at_item) for place in arrays]
            places = tuple(Into("", pointer_to(one)) for one in items) if function.mode == "several" else (NO_PLACE,)
            returned = self.call(body, found.py_func, arguments_at(at_item), {}, places)
            if function.mode == "value":
                body.store(items[0], returned, first.text if alone else "")
        return arrays[0] if function.mode == "value" else Parts(tuple(arrays))


def pointer_to(value: Value) -> Stored | None:
    """Return the place of an item of an array, as a result is written there; None if it holds no numbers."""
    if not isinstance(value, Computed | Stored) or leaf_count(value.kind) == 0:
        return None
    return (
        value
        if isinstance(value, Stored) and is_array(value.kind)
        else Stored(f"&{value.text}", value.kind, pointer=True)
    )


def argument_type(body: Any, value: Value) -> ArgumentType:
    """Return the type for which a law is translated of an argument."""
    if isinstance(value, Known):
        tuple_or_number = isinstance(value.value, bool | int | float | tuple)
        return body.kind_of(value) if tuple_or_number else Same(value.value)
    if isinstance(value, Parts) and value.abreast and not isinstance(body.kind_of(value.items[0]), Number):
        return Spread(tuple(body.kind_of(item) for item in value.items))
    return body.kind_of(value)  # type: ignore[no-any-return]


def _is_docstring(node: ast.stmt) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
