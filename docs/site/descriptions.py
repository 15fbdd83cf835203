"""Reference of description files: every key, from the models that check them."""

from collections.abc import Iterator
from math import inf
from typing import Annotated, Any, get_args, get_origin

from annotated_types import Ge, Gt, Le, Lt
from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from layflat.description.quantity import Quantity
from layflat.kinds import AnyKindOf
from layflat.machine.listing import nested_value
from layflat.machine.loader import tables
from layflat.machine.model import Machine

SHOWN, JOINT = "paper-arm-tracking", "large"  # machine whose values stand beside the keys, with their sources
COLUMNS = ("key", "unit", "range", "default", "meaning", "example", "source")
MAX_SHOWN = 40  # characters of an example
Model = type[BaseModel]


def description_reference() -> str:
    """Return the page of keys: a table for each part of a machine's file, and one for each kind of a part."""
    parts = [
        "# Description files",
        "",
        "Every key of a machine's file: its unit (any unit of the same quantity is read), the range that it may have",
        "in that unit, its default, and its meaning. A key without a default has to be given, in the file or in one",
        f"that it `extends`. The last columns show the value in `{SHOWN}` and where that comes from.",
        "`layflat machine show NAME` prints all values of a machine, `layflat machine schema` a schema for editors.",
        "",
    ]
    plain, sources = tables(SHOWN)
    example = {path: (nested_value(plain, path.split(".")), source.source) for path, source in sources.items()}
    for path, model in _models(Machine, "", set()):
        rows = [_row(name, field, example.get(_example_path(path, name))) for name, field in model.model_fields.items()]
        title, meaning = path or "The file", _first_line(model)
        parts += [f"## {title}", "", _cell(meaning), "", *_table(rows), ""]
    return "\n".join(parts)


def _models(model: Model, path: str, seen: set[Model]) -> Iterator[tuple[str, Model]]:
    """Yield a model with its path, then those of its keys; each model once, where it comes first."""
    seen.add(model)
    yield path, model
    for name, field in model.model_fields.items():
        key = f"{path}.{name}" if path else name
        for where, inner in _parts(field.annotation, [*field.metadata], key):
            if inner not in seen:
                yield from _models(inner, where, seen)


def _parts(annotation: Any, notes: list[Any], key: str) -> Iterator[tuple[str, Model]]:
    """Yield the models that may stand at a key."""
    kinds = next((note for note in notes if isinstance(note, AnyKindOf)), None)
    if kinds is not None:
        for kind in kinds.table:
            yield f'{key}, kind = "{kind.name}"', kind.description
    elif get_origin(annotation) is Annotated:
        yield from _parts(get_args(annotation)[0], [*annotation.__metadata__], key)
    elif get_origin(annotation) is dict:
        yield from _parts(get_args(annotation)[1], [], f"{key}.NAME")
    elif isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield key, annotation
    else:
        for one in get_args(annotation):
            yield from _parts(one, [], key)


def _example_path(path: str, name: str) -> str:
    """Return the dotted path in the machine that is shown, with its first joint in place of any."""
    path = path.partition(",")[0].replace("joint.NAME", f"joint.{JOINT}")
    return f"{path}.{name}" if path else name


def _table(rows: list[list[str]]) -> list[str]:
    """Return the lines of a table, without columns that are empty."""
    used = [number for number in range(len(COLUMNS)) if any(row[number] for row in rows)]
    lines = [
        [COLUMNS[number] for number in used],
        ["---"] * len(used),
        *([row[number] for number in used] for row in rows),
    ]
    return [f"| {' | '.join(line)} |" for line in lines]


def _row(name: str, field: FieldInfo, example: tuple[Any, str] | None) -> list[str]:
    notes = [*field.metadata, *_inner_notes(field.annotation)]
    quantity = next((note for note in notes if isinstance(note, Quantity)), None)
    value, source = example or ("", "")
    default = "" if field.default is PydanticUndefined or field.default is None else _default(field.default, quantity)
    meaning = field.description or _meaning_of_parts(field)
    cells = [f"`{name}`", quantity.unit if quantity else "", _range(notes, quantity), default, meaning]
    shown = _shown(value) if len(str(value)) <= MAX_SHOWN else ""
    return [_cell(text) for text in [*cells, shown, source if shown else ""]]


def _meaning_of_parts(field: FieldInfo) -> str:
    """Return the first line of the part that may stand there, "" of a plain value; of kinds, how many there are."""
    found = [model for _, model in _parts(field.annotation, [*field.metadata], "")]
    return f"one of {len(found)} kinds" if len(found) > 1 else _first_line(found[0]) if found else ""


def _first_line(model: Model) -> str:
    return str(model.__doc__ or "").strip().splitlines()[0]


def _inner_notes(annotation: Any) -> list[Any]:
    inner = next((one for one in get_args(annotation) if get_origin(one) is Annotated), None)
    return [*inner.__metadata__] if inner is not None else []


def _range(notes: list[Any], quantity: Quantity | None) -> str:
    lower, upper, limit = "", "", quantity.most if quantity else inf
    for note in notes:
        lower = f"{note.ge:g}" if isinstance(note, Ge) else f"above {note.gt:g}" if isinstance(note, Gt) else lower
        upper = f"{note.le:g}" if isinstance(note, Le) else f"below {note.lt:g}" if isinstance(note, Lt) else upper
    upper = upper or (f"{limit:g}" if limit < inf else "")
    return (
        f"{lower} to {upper}"
        if lower and upper
        else f"at least {lower}"
        if lower
        else f"at most {upper}"
        if upper
        else ""
    )


def _default(value: Any, quantity: Quantity | None) -> str:
    if isinstance(value, BaseModel):
        return "its defaults"
    return f"{value:g}" if quantity is not None and isinstance(value, float) else _shown(value)


def _shown(value: Any) -> str:
    return "" if isinstance(value, dict | list | tuple) or value == "" else f"`{value}`"


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("<", "&lt;").replace("*", "\\*")
