"""Functions of C that are seen from outside: they call the law of an entry, and write its results where they go."""

from typing import Any

from layflat.export.c_source.c_types import INT_TYPE, REAL_TYPE, is_array, item_type, type_of_tuple
from layflat.export.c_source.function import Body
from layflat.export.c_source.lines import read_names, render, without_unread
from layflat.export.c_source.program import Program
from layflat.export.c_source.storage import Into
from layflat.export.c_source.values import Computed, Known, Stored, Value, field_of, is_plain_tuple, items_of
from layflat.export.c_source.variables import Facts
from layflat.export.entries import Argument, ArmReport, Entry
from layflat.jit import ByKind


def entry_lines(program: Program, entry: Entry, prototype: list[str], *, rows: bool = False) -> list[str]:
    """Return the lines of an entry's function.

    Args:
        program: the program, to which the law is added.
        entry: the entry.
        prototype: lines of the function's declaration.
        rows: whether it takes the addresses of rows of numbers, called NAME_row, in place of structs.

    Raises:
        KindError: a construct of the law has no counterpart in C.
    """
    body = Body(program, _python_function(entry), Facts())
    inputs: list[Value] = []
    places: list[tuple[Argument, Stored]] = []
    for argument in entry.arguments:
        body.names.taken.add(argument.name)
        if argument.like is None:
            kind = INT_TYPE if argument.number == "int32_t" else REAL_TYPE
            inputs.append(body.number(Computed(argument.name, kind), kind if kind == INT_TYPE else body.literal))
            continue
        place = _stored(argument)
        if rows:
            items = item_type(place.kind) if is_array(place.kind) else place.kind
            const = "" if argument.output else "const "
            body.emit(f"{const}{body.c_type(items)} *{argument.name} = {argument.name}_row;", argument.name)
        if argument.output:
            places.append((argument, place))
        if argument.updated or not argument.output:
            inputs.append(place)
    inputs += map(Known, entry.constants)
    _add_results(body, entry, inputs, places)
    read = {word for line in body.lines for word in read_names(line.text)}
    unread = [f"    (void){one.name};" for one in entry.arguments if one.name not in read]
    lines = [*prototype, "{", *unread, *render(without_unread(body.lines)), "}"]
    return [f"/* {entry.comment} */", *lines]


def _python_function(entry: Entry) -> Any:
    law = entry.law
    while isinstance(law, ByKind):
        law = law.kinds[type(entry.arguments[0].like)]
    return getattr(law, "py_func", law)


def _stored(argument: Argument) -> Stored:
    """Return the value of an argument: a pointer to a struct, or an array."""
    kind = type_of_tuple(argument.like)
    array = is_array(kind)
    grouped = is_plain_tuple(Stored("", kind)) and not array
    return Stored(argument.name, kind, pointer=not array, constant=not argument.output, grouped=grouped)


def _add_results(body: Body, entry: Entry, inputs: list[Value], written: list[tuple[Argument, Stored]]) -> None:
    """Add the call of an entry's law, and the lines that write its results.

    Args:
        body: the function.
        entry: the entry.
        inputs: arguments of the law.
        written: arguments that are written, and their places.
    """
    structs = {one.struct_name for one in entry.arguments if one.like is not None and not one.output}
    places, into, last = list[Stored](), list[Into](), list[int]()
    for i, (argument, struct) in enumerate(written):
        place = field_of(struct, "joints") if isinstance(argument.like, ArmReport) else struct
        assert isinstance(place, Stored)
        places.append(place)
        if argument.updated or argument.struct_name in structs:  # it may be the one that the law reads
            into.append(Into(f"{argument.struct_name}_after"))
            last.append(i)
        else:
            into.append(Into("reports" if place is not struct else argument.name, place))
    if entry.result:
        into.append(Into("result"))
    value = body.call_law(entry.law, inputs, {}, tuple(into))
    results = items_of(value) if len(into) > 1 else [value]
    for i in sorted(range(len(places)), key=lambda i: i in last):
        body.store(places[i], results[i])
    if entry.result:
        body.emit(f"return {body.number(results[-1], INT_TYPE).text};")
