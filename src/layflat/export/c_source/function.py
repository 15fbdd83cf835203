"""Functions of C from laws: statement by statement, for the types of their arguments."""

import ast
from collections.abc import Callable
from typing import Any, NamedTuple

from layflat.export.c_source.c_types import Number, Record, Type, is_array, leaf_count
from layflat.export.c_source.lines import Line, read_names, without_unread
from layflat.export.c_source.results import ResultStatements
from layflat.export.c_source.values import Computed, Known, Parts, Stored, Value
from layflat.export.c_source.variables import Facts

MAX_PASSES = 12


class Spread(NamedTuple):
    """Type of an argument whose parts are passed one by one: structs side by side."""

    items: tuple[Type, ...]


class Same(NamedTuple):
    """Argument that is known when the law is translated, and not passed."""

    value: Any


ArgumentType = Type | Spread | Same


class Parameter(NamedTuple):
    """Parameter of a function in C."""

    name: str
    kind: Type
    changed: bool = False  # whether the function writes it
    read: bool = True  # whether its code names it; others are left out


class CFunction(NamedTuple):
    """Function of C."""

    name: str
    module: str
    comment: str
    parameters: tuple[tuple[Parameter, ...], ...]  # by argument of the law
    mode: str  # "value": it returns its result; "array", "several": it writes them
    results: tuple[Parameter, ...]
    lines: tuple[Line, ...]
    called: frozenset[str]  # names of the functions that it calls

    @property
    def kind(self) -> Type:
        """Type of its only result."""
        return self.results[0].kind


class Body(ResultStatements):
    """Statements of a function, in one pass over it."""

    def __init__(self, program: Any, law: Callable[..., Any], facts: Facts) -> None:
        super().__init__(program, law, facts)
        self.parameters: dict[str, tuple[Parameter, ...]] = {}
        self.changed = set[str]()

    def take(self, names: list[str], kinds: list[ArgumentType]) -> None:
        """Bind the parameters' names to the arguments."""
        for name, kind in zip(names, kinds, strict=True):
            if isinstance(kind, Same):
                self.parameters[name], self.scopes[0][name] = (), Known(kind.value)
            elif isinstance(kind, Spread):
                parts = tuple(Parameter(self.names.fresh(f"{name}_{i + 1}"), one) for i, one in enumerate(kind.items))
                self.parameters[name] = parts
                self.scopes[0][name] = Parts(
                    tuple(Stored(one.name, one.kind, pointer=True) for one in parts), abreast=True
                )
            elif leaf_count(kind) == 0:
                self.parameters[name], self.scopes[0][name] = (), Stored("", kind)
            else:
                parameter = Parameter(self.names.fresh(name), kind)
                self.parameters[name] = (parameter,)
                self.scopes[0][name] = self._argument(name, parameter.name, kind)
            if not isinstance(kind, Same | Spread):
                self.kinds[name] = kind

    def _argument(self, name: str, text: str, kind: Type) -> Value:
        """Return the value of a parameter."""
        if isinstance(kind, Number):
            if self.facts.changing.get(name, kind) != kind:
                return self._changing(name, Computed(text, kind), self.facts.changing[name])
            return Computed(text, kind)
        grouped = not isinstance(kind, Record) and not is_array(kind)
        return Stored(text, kind, pointer=not is_array(kind), constant=True, grouped=grouped)

    def prepare_results(self) -> None:
        """Name the places for the results, as the pass before found them."""
        names = [self.names.fresh(name) for name in self.facts.result_names]
        if self.facts.mode in ("array", "several"):
            pairs = zip(names, self.facts.results, strict=True)
            self.outputs = tuple(Stored(name, kind, pointer=not is_array(kind), constant=False) for name, kind in pairs)
            places = dict(zip(self.facts.result_names, self.outputs, strict=True))
            self.direct = {name: places[name] for name in self.facts.direct}


def translate(
    program: Any,
    law: Callable[..., Any],
    name: str,
    names: list[str],
    kinds: list[ArgumentType],
    hints: tuple[str, ...],
) -> CFunction:
    """Return the function of C of a law for the types of its arguments.

    Args:
        program: the program that the function is a part of.
        law: Python's function of the law.
        name: its name in C.
        names: names of its parameters.
        kinds: types of its arguments.
        hints: names for its results.

    Raises:
        KindError: a construct has no counterpart in C.
    """
    facts = Facts()
    for _ in range(MAX_PASSES):
        body = Body(program, law, facts)
        body.hints = hints
        body.take(names, kinds)
        body.prepare_results()
        body.statements(body.source.tree.body)
        body.note_results()
        if body.found == facts:
            break
        facts = body.found
    else:
        body.fail(f"types of {law.__name__!r} are not clear", "give each name values of one type")
    lines = without_unread(body.lines)
    read = {word for line in lines if not line.comment for word in read_names(line.text)}
    parameters = tuple(
        tuple(one._replace(changed=name in body.changed, read=one.name in read) for one in body.parameters[name])
        for name in names
    )
    results = tuple(Parameter(place.text, place.kind, changed=True) for place in body.outputs)
    if facts.mode == "value":
        results = (Parameter("", facts.results[0]),)
    comment = ast.get_docstring(body.source.tree) or ""
    called = frozenset(facts.called & read)
    return CFunction(name, law.__module__, comment, parameters, facts.mode, results, tuple(lines), called)
