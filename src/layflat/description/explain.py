"""Errors of pydantic as one line in the words of the package: place in the file, problem, and advice."""

from collections.abc import Callable
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from layflat.description.places import FileLocation, SchemaWalk, Steps
from layflat.description.quantity import Quantity
from layflat.description.renamed import ANY_KIND, RENAMED_KEYS, migration_advice, present_steps
from layflat.description.wrong import ERROR_TYPE, did_you_mean, nearest, shown
from layflat.errors import InputError

MAX_LENGTH_DIFFERENCE = 4  # in characters, between a misspelt key and the missing one


def explain_error(
    error: ValidationError,
    where: str,
    model: type[BaseModel],
    kind: type[InputError] = InputError,
    complete: str = "",
    written: Callable[[Steps, object], str] | None = None,
) -> InputError:
    """Return an error of a description as one line: an old or misspelt key if there is one, else the first error.

    Args:
        error: pydantic's error.
        where: the file.
        model: class of the description.
        kind: class of the returned error.
        complete: advice for a missing key: the keys of a complete description, or a page that shows one.
        written: function that names a place, from its steps and the value there; default: joined by dots.
    """
    first, place = _first_error(error, model)
    steps, what, right = _explain(first, place, complete)
    if present := _present_name(first, place):
        file = where.partition(": ")[0]
        what, right = f"is called {present} now", migration_advice(file) if file.endswith(".toml") else "use that name"
    named = written(steps, first["input"]) if written else ".".join(map(str, steps))
    return kind(what, where=f"{where}: {named}" if named else where, right=right)


def unknown_key(error: ValidationError, where: str, model: type[BaseModel]) -> InputError | None:
    """Return an error of one line about the first unknown key of a description, None if all keys are known.

    Args:
        error: pydantic's error.
        where: the file.
        model: class of the description.
    """
    walk = SchemaWalk(model)
    for item in error.errors(include_url=False):
        if item["type"] == "extra_forbidden":
            steps, what, right = _explain(item, walk.locate(item["loc"]), "")
            return InputError(what, where=f"{where}: {'.'.join(map(str, steps))}", right=right)
    return None


def explain_value_error(error: ValidationError, where: str, quantity: Quantity | None = None) -> InputError:
    """Return the error of a single value as one line.

    Args:
        error: pydantic's error.
        where: place of the value.
        quantity: quantity of the value, for its unit.
    """
    first = error.errors(include_url=False)[0]
    _, what, right = _explain(first, FileLocation(first["loc"], quantity=quantity), "")
    return InputError(what, where=where, right=right)


def _first_error(error: ValidationError, model: type[BaseModel]) -> tuple[ErrorDetails, FileLocation]:
    """Return the first error with its place; an old or misspelt key comes before the missing key that was meant."""
    errors = error.errors(include_url=False)
    walk = SchemaWalk(model)
    old = next((item for item in errors if _present_name(item, walk.locate(item["loc"]))), None)
    if old is not None:
        return old, walk.locate(old["loc"])
    missing = {item["loc"] for item in errors if item["type"] == "missing"}
    for item in errors if missing else []:
        if item["type"] == "extra_forbidden":
            key = str(item["loc"][-1])
            meant = nearest(key, walk.locate(item["loc"]).valid_keys)
            if meant and abs(len(meant) - len(key)) < MAX_LENGTH_DIFFERENCE and (*item["loc"][:-1], meant) in missing:
                return item, walk.locate(item["loc"])
    return errors[0], walk.locate(errors[0]["loc"])


def _present_name(error: ErrorDetails, place: FileLocation) -> str | None:
    """Return the present name of a key that is unknown because it was renamed; None for any other error."""
    if error["type"] != "extra_forbidden":
        return None
    names = (present_steps(noun, place.steps, lambda _: ANY_KIND)[-1] for noun in RENAMED_KEYS)
    return next((str(name) for name in names if name != place.steps[-1] and name in place.valid_keys), None)


def _explain(error: ErrorDetails, place: FileLocation, complete: str) -> tuple[Steps, str, str]:
    """Return the steps to an error's place, the problem, and the advice.

    `complete` is the advice for a missing key; if it is empty, a general one is given.
    """
    kind, value, context, steps = error["type"], error["input"], error.get("ctx", {}), place.steps
    if kind == ERROR_TYPE:
        return steps, context["what"] if context["named"] else f"{shown(value)} {context['what']}", context["right"]
    if kind == "missing" and steps and isinstance(steps[-1], int):
        return steps[:-1], "has too few values", f"give {place.size}" if place.size else "give more"
    if kind.startswith("union_tag") and not isinstance(value, (dict, BaseModel)):
        return steps, *_explain_type("dict_type", value, context, place)
    if kind.startswith("union_tag"):
        return (*steps, "kind"), *_explain_kind(value, context)
    if kind in {"value_error", "assertion_error"}:
        what, _, right = str(context["error"]).partition("; ")
    elif kind == "extra_forbidden":
        what, right = "unknown key", did_you_mean(steps[-1], place.valid_keys, "known keys are {}")
    elif kind == "missing":
        what, right = "is missing", complete or "add it"
    else:
        what, right = _explain_type(kind, value, context, place)
    return steps, what, right


def _explain_kind(value: object, context: dict[str, Any]) -> tuple[str, str]:
    """Return problem and advice for a kind that is unknown or missing."""
    names = [name.strip(" '") for name in context.get("expected_tags", "").split(",") if name.strip()]
    tag = context.get("tag", value.get("kind") if isinstance(value, dict) else None)
    near = nearest(tag, names) if tag else None
    hint = f'did you mean "{near}"? ' if near else ""
    known = "known kinds are " + ", ".join(f'"{name}"' for name in names) if names else ""
    return f"{shown(tag)} is not a known kind" if tag else "is missing", f"{hint}{known}"


BOUND_ERRORS = {
    "greater_than": ("gt", "give more than {}"),
    "greater_than_equal": ("ge", "give at least {}"),
    "less_than": ("lt", "give less than {}"),
    "less_than_equal": ("le", "give at most {}"),
}

TYPE_ERRORS = {
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
"""Expected type and advice, by the first word of pydantic's type of error."""


def _explain_type(kind: str, value: object, context: dict[str, Any], place: FileLocation) -> tuple[str, str]:
    """Return problem and advice for a value out of range, of the wrong length or type, or none of the valid ones."""
    if kind in BOUND_ERRORS:
        name, text = BOUND_ERRORS[kind]
        unit = f" {place.quantity.unit}" if place.quantity and context[name] else ""
        return f"{shown(value)} is out of range", text.format(f"{context[name]:g}{unit}")
    if kind.endswith(("too_long", "too_short")):
        count = context.get("actual_length", len(value) if isinstance(value, (str, list, tuple)) else "other")
        bound = f"at least {context['min_length']}" if kind.endswith("short") else f"at most {context['max_length']}"
        return f"has {count} {'characters' if kind.startswith('string') else 'values'}", f"give {bound}"
    if kind == "string_pattern_mismatch":
        return f"{shown(value)} has the wrong form", f"it must match {context['pattern']}"
    expected = str(context.get("expected", ""))
    if kind in {"literal_error", "enum"}:
        near = nearest(value, [name.strip("' ") for name in expected.replace(" or ", ",").split(",")])
        return f"{shown(value)} is not known", f"did you mean {near!r}?" if near else f"give {expected}"
    noun, right = TYPE_ERRORS.get(
        kind.split("_", maxsplit=1)[0], ("a valid value", "`layflat machine schema` describes the valid ones")
    )
    return f"{shown(value)} is not {noun}", right
