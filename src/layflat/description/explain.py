"""One line for what pydantic found wrong: where in the file, what, and what would be right, in our own words."""

from collections.abc import Callable
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from layflat.description.hints import did_you_mean, nearest
from layflat.description.places import Place, Steps, Walk
from layflat.description.quantity import Quantity
from layflat.description.wrong import WRONG, shown
from layflat.errors import InputError

LONGER = 4  # characters by which a misspelt key differs in length less than one of another kind does


def explained(
    error: ValidationError,
    where: str,
    model: type[BaseModel],
    kind: type[InputError] = InputError,
    complete: str = "",
    written: Callable[[Steps, object], str] | None = None,
) -> InputError:
    """Return one line for what is wrong with a description.

    Args:
        error: what pydantic found.
        where: the file.
        model: class of the description.
        kind: class of what is returned.
        complete: what to say where something is missing: what a complete description has, or what shows one.
        written: how a place is named, from its steps and the value there; default: by dots.
    """
    first, place = _first(error, model)
    steps, what, right = _said(first, place, complete)
    named = written(steps, first["input"]) if written else ".".join(map(str, steps))
    return kind(what, where=f"{where}: {named}" if named else where, right=right)


def explained_value(error: ValidationError, where: str, quantity: Quantity | None = None) -> InputError:
    """Return one line for what is wrong with a single value, which stands at `where`."""
    first = error.errors(include_url=False)[0]
    _, what, right = _said(first, Place(first["loc"], quantity=quantity), "")
    return InputError(what, where=where, right=right)


def _first(error: ValidationError, model: type[BaseModel]) -> tuple[ErrorDetails, Place]:
    """The first thing that is wrong; a key that is misspelt before the one that is missing for it."""
    found = error.errors(include_url=False)
    walk = Walk(model)
    missing = {one["loc"] for one in found if one["type"] == "missing"}
    for one in found if missing else []:
        if one["type"] == "extra_forbidden":
            key = str(one["loc"][-1])
            meant = nearest(key, walk.to(one["loc"]).known)
            if meant and abs(len(meant) - len(key)) < LONGER and (*one["loc"][:-1], meant) in missing:
                return one, walk.to(one["loc"])
    return found[0], walk.to(found[0]["loc"])


def _said(error: ErrorDetails, place: Place, complete: str) -> tuple[Steps, str, str]:
    """Steps to the place, what is wrong there, and what would be right."""
    kind, value, context, steps = error["type"], error["input"], error.get("ctx", {}), place.steps
    if kind == WRONG:
        return steps, context["what"] if context["named"] else f"{shown(value)} {context['what']}", context["right"]
    if kind == "missing" and steps and isinstance(steps[-1], int):
        return steps[:-1], "has too few values", f"give {place.size}" if place.size else "give more"
    if kind.startswith("union_tag") and not isinstance(value, (dict, BaseModel)):
        return steps, *_plain("dict_type", value, context, place)
    if kind.startswith("union_tag"):
        return (*steps, "kind"), *_kind(value, context)
    if kind in {"value_error", "assertion_error"}:
        what, _, right = str(context["error"]).partition("; ")
    elif kind == "extra_forbidden":
        what, right = "unknown key", did_you_mean(steps[-1], place.known, "known keys are {}")
    elif kind == "missing":
        what, right = "is missing", complete or "add it"
    else:
        what, right = _plain(kind, value, context, place)
    return steps, what, right


def _kind(value: object, context: dict[str, Any]) -> tuple[str, str]:
    """Explain a kind that is unknown, or not given."""
    names = [name.strip(" '") for name in context.get("expected_tags", "").split(",") if name.strip()]
    tag = context.get("tag", value.get("kind") if isinstance(value, dict) else None)
    near = nearest(tag, names) if tag else None
    hint = f'did you mean "{near}"? ' if near else ""
    known = "known kinds are " + ", ".join(f'"{name}"' for name in names) if names else ""
    return f"{shown(tag)} is not a known kind" if tag else "is missing", f"{hint}{known}"


BOUNDS = {
    "greater_than": ("gt", "give more than {}"),
    "greater_than_equal": ("ge", "give at least {}"),
    "less_than": ("lt", "give less than {}"),
    "less_than_equal": ("le", "give at most {}"),
}

TYPES = {
    "string": ("a text", "put it in quotes"),
    "int": ("a whole number", "give one such as 12"),
    "float": ("a number", "give one such as 0.5, without a unit"),
    "finite": ("a finite number", "give one such as 0.5"),
    "bool": ("true or false", "give one of them, without quotes"),
    "dict": ("a table", "write its keys under a heading in brackets"),
    "model": ("a table", "write its keys under a heading in brackets"),
    "tuple": ("a list", "put its values in brackets"),
    "list": ("a list", "put its values in brackets"),
}
"""What was expected, and what would be right, by the first word of pydantic's type of error."""


def _plain(kind: str, value: object, context: dict[str, Any], place: Place) -> tuple[str, str]:
    """Explain a value of the wrong size or type."""
    if kind in BOUNDS:
        name, text = BOUNDS[kind]
        unit = f" {place.quantity.unit}" if place.quantity and context[name] else ""
        return f"{shown(value)} is out of range", text.format(f"{context[name]:g}{unit}")
    if kind.endswith(("too_long", "too_short")):
        count = context.get("actual_length", len(value) if isinstance(value, (str, list, tuple)) else "other")
        bound = f"at least {context['min_length']}" if kind.endswith("short") else f"at most {context['max_length']}"
        return f"has {count} {'characters' if kind.startswith('string') else 'values'}", f"give {bound}"
    if kind == "string_pattern_mismatch":
        return f"{shown(value)} is not such a text", f"it must match {context['pattern']}"
    expected = str(context.get("expected", ""))
    if kind in {"literal_error", "enum"}:
        near = nearest(value, [name.strip("' ") for name in expected.replace(" or ", ",").split(",")])
        return f"{shown(value)} is not known", f"did you mean {near!r}?" if near else f"give {expected}"
    noun, right = TYPES.get(kind.split("_", maxsplit=1)[0], ("what can stand here", "`layflat schema` shows what can"))
    return f"{shown(value)} is not {noun}", right
