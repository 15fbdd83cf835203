"""All values of a machine's description, found by walking through it."""

from collections.abc import Iterator
from math import inf
from typing import Any, Literal, get_args, get_origin

from pydantic import BaseModel

from layflat.description.change import annotation_at, is_whole, quantity_of, value_at
from layflat.description.expression import QuantityError, split
from layflat.description.quantity import Quantity
from layflat.description.tables import Plain
from layflat.machine.listing import at_path
from layflat.machine.model import Machine
from layflat.pages.studio.field import Bounds, Field, Shape

FIXED = {"file", "bodies", "kinds"}  # keys of texts that name other files or say how a file is read


def fields_of(machine: Machine, plain: Plain) -> list[Field]:
    """Return all values of a machine that its arm uses, in the order of a description.

    Shapes are left out, by which links are drawn in pictures: nothing follows from them.

    Args:
        machine: as it is.
        plain: its values as they are written, which say the units.
    """
    used = {f"joint.{name}" for name in machine.joints}
    return [
        field_at(machine, plain, path)
        for path, _ in _leaves(machine, "")
        if path != "name" and (not path.startswith("joint.") or ".".join(path.split(".")[:2]) in used)
    ]


def _leaves(part: Any, path: str) -> Iterator[tuple[str, Any]]:
    """Yield path and value of everything that stands in a part; a list of numbers or texts is one value."""
    below: list[tuple[str, Any]]
    if isinstance(part, BaseModel):
        below = [(key, getattr(part, key)) for key in type(part).model_fields if key != "shapes"]
    elif isinstance(part, dict):
        below = list(part.items())
    elif isinstance(part, tuple) and part and isinstance(part[0], (BaseModel, tuple)):
        below = [(str(i), item) for i, item in enumerate(part)]
    else:
        if part is not None and part != ():
            yield path, part
        return
    for key, value in below:
        yield from _leaves(value, f"{path}.{key}" if path else key)


def field_at(machine: Machine, plain: Plain, path: str) -> Field:
    """Return the value of a machine at a path.

    Args:
        machine: as it is.
        plain: its values as they are written, which say the units; where one is missing its usual unit is taken.
        path: of the value, dotted.
    """
    value = value_at(machine, path)
    annotation = annotation_at(machine, path)
    meaning = _meaning(machine, path)
    choices = _choices(annotation)
    if isinstance(value, bool):
        return Field(path, "switch", meaning=meaning)
    if choices:
        return Field(path, "choice" if len(choices) > 1 else "fixed", choices=choices, meaning=meaning)
    written = at_path(plain, path.split("."))
    shape: Shape = "whole" if is_whole(annotation) else "number"
    if isinstance(value, tuple) and not isinstance(value[0], str):
        shape, annotation = "list", annotation_at(machine, f"{path}.0")
        written = written[0] if written else None
    elif not isinstance(value, (int, float)):
        fixed = isinstance(value, tuple) or path.rpartition(".")[2] in FIXED
        return Field(path, "fixed" if fixed else "text", meaning=meaning)
    quantity = quantity_of(annotation)
    return Field(path, shape, _unit(written, quantity), quantity, _bounds(annotation), meaning=meaning)


def _choices(annotation: Any) -> tuple[str, ...]:
    while get_origin(annotation) is not Literal and get_args(annotation) and hasattr(annotation, "__metadata__"):
        annotation = get_args(annotation)[0]
    return tuple(map(str, get_args(annotation))) if get_origin(annotation) is Literal else ()


def _unit(written: Any, quantity: Quantity | None) -> str:
    """The unit in which a value is written, or which is usual for it."""
    if quantity is None:
        return ""
    try:
        return split(written)[1] if isinstance(written, str) else split(quantity.example)[1]
    except QuantityError:
        return split(quantity.example)[1]


def _bounds(annotation: Any) -> Bounds:
    least, above, most, below = -inf, False, inf, False
    for note in get_args(annotation)[1:]:
        for name, excluded in (("ge", False), ("gt", True)):
            if getattr(note, name, None) is not None and float(getattr(note, name)) >= least:
                least, above = float(getattr(note, name)), excluded
        for name, excluded in (("le", False), ("lt", True)):
            if getattr(note, name, None) is not None and float(getattr(note, name)) <= most:
                most, below = float(getattr(note, name)), excluded
    return least, above, most, below


def _meaning(machine: Machine, path: str) -> str:
    """Return what a field's class says of it; of an item of a list, what it says of the list."""
    part: Any = machine
    found = ""
    for key in path.split("."):
        if isinstance(part, BaseModel):
            found = type(part).model_fields[key].description or ""
            part = getattr(part, key)
        else:
            part = part[int(key)] if isinstance(part, tuple) else part[key]
            found = found if key.isdigit() else ""
    return found
