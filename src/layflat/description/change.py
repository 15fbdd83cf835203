"""Variants of what is described, for experiments: one value replaced by its dotted path, and checked as in a file."""

from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import TYPE_CHECKING, Annotated, Any, TypeVar, get_args, get_origin

from pydantic import BaseModel, ConfigDict, PydanticUserError, TypeAdapter, ValidationError

from layflat.description.explain import explained_value
from layflat.description.hints import nearest
from layflat.description.part import Part
from layflat.description.quantity import SI, Quantity
from layflat.description.wrong import shown
from layflat.errors import InputError

if TYPE_CHECKING:
    import numpy as np

Described = TypeVar("Described", bound=Part)


def changed(described: Described, path: str, value: Any) -> Described:
    """Return a copy of a machine or a bench with one value replaced, by its dotted path, such as "arm.payload".

    What is changed passes the checks of a file. Numbers are in SI units; a text has its unit. For an ensemble a number
    may be replaced by an array, with a number for each run, each of which passes.

    Args:
        described: what is copied.
        path: keys, and numbers of items, as `layflat show` lists them.
        value: a number, a text, an array of numbers, or a whole part.

    Raises:
        InputError: there is no such path, or the value can't stand there.
    """
    if not isinstance(path, str):
        raise InputError(f"{shown(path)} is no path", where="path", right='give one such as "arm.payload"')
    return changed_all(described, {path: value})


def changed_all(
    described: Described, values: Mapping[str, Any], where: str = "", *, together: bool = True
) -> Described:
    """Return a copy with several values replaced: each as by `changed`.

    Args:
        described: what is copied.
        values: by their dotted paths.
        where: in place of the origin of what is described, in messages.
        together: whether they are also checked against each other, all replaced.

    Raises:
        InputError: there is no such path, or a value can't stand there.
    """
    if not isinstance(described, Part):
        raise InputError(f"{shown(described)} is no description", where=where, right="give a machine: load(...)")
    where = where or _origin(described)
    odd = next((path for path in values if not isinstance(path, str)), None)
    if odd is not None:
        raise InputError(f"{shown(odd)} is no path", where=where, right='give one such as "arm.payload"')
    above: set[str] = set()
    for path, value in values.items():
        value_at(described, path)
        checked = _checked(value, annotation_at(described, path), f"{where}: {path}")
        described = replaced(described, path.split("."), checked)
        above |= {path.rsplit(".", i)[0] for i in range(1, path.count(".") + 1)}
    if not together:
        return described
    for place in sorted(above, key=lambda one: -one.count(".")):
        part = value_at(described, place)
        if isinstance(part, Part):
            rechecked(part, f"{where}: {place}")
    rechecked(described, where)
    return described


def value_at(described: Part, path: str) -> Any:
    """Return what stands at a dotted path (SI); raise InputError if there is no such path."""
    part: Any = described
    for key in path.split("."):
        if isinstance(part, dict) and key in part:
            part = part[key]
        elif isinstance(part, tuple) and key.isdigit() and int(key) < len(part):
            part = part[int(key)]
        elif key in getattr(type(part), "model_fields", {}):
            part = getattr(part, key)
        else:
            near = nearest(path, paths(described), cutoff=0.5)
            right = f"nearest is {near!r}" if near else "`layflat show` lists the paths"
            raise InputError(f"{key!r} is not there", where=f"{_origin(described)}: {path}", right=right)
    return part


def _origin(described: Part) -> str:
    return getattr(described, "origin", "") or getattr(described, "name", type(described).__name__)


def replaced(part: Any, keys: list[str], value: Any) -> Any:
    """Return a copy of a part with what stands at a path replaced, unchecked."""
    if not keys:
        return value
    head, rest = keys[0], keys[1:]
    if isinstance(part, tuple):
        return tuple(replaced(item, rest, value) if i == int(head) else item for i, item in enumerate(part))
    if isinstance(part, dict):
        return {**part, head: replaced(part[head], rest, value)}
    return part.model_copy(update={head: replaced(getattr(part, head), rest, value)})


def annotation_at(described: Part, path: str) -> Any:
    """Return the annotation of what stands at a dotted path, with its quantity and its bounds."""
    part: Any = described
    annotation: Any = None
    for key in path.split("."):
        if isinstance(part, tuple):
            annotation, part = _item_annotations(annotation, len(part))[int(key)], part[int(key)]
        elif isinstance(part, dict):
            annotation, part = (*get_args(annotation), Any, Any)[1], part[key]
        else:
            annotation, part = annotation_of(type(part), key), getattr(part, key)
    return annotation


def annotation_of(part: type[BaseModel], key: str) -> Any:
    """Return the annotation of a field; Pydantic keeps the notes of a field apart from its type."""
    field = part.model_fields[key]
    return Annotated[(field.annotation, *field.metadata)] if field.metadata else field.annotation


def quantity_of(annotation: Any) -> Quantity | None:
    """Return the kind of quantity of an annotation, None of a number without unit."""
    return next((note for note in get_args(annotation)[1:] if isinstance(note, Quantity)), None)


def is_whole(annotation: Any) -> bool:
    """Tell whether an annotation is that of whole numbers."""
    return int in (annotation, *get_args(annotation)[:1])


def paths(described: Part) -> list[str]:
    """Return every number of what is described, by its dotted path."""

    def below(part: Any, path: str) -> list[str]:
        if isinstance(part, (int, float)) and not isinstance(part, bool):
            return [path]
        items: list[tuple[str, Any]]
        if isinstance(part, dict):
            items = list(part.items())
        elif isinstance(part, tuple):
            items = [(str(i), item) for i, item in enumerate(part)]
        else:
            items = [(name, getattr(part, name)) for name in getattr(type(part), "model_fields", {})]
        return [leaf for name, item in items for leaf in below(item, f"{path}.{name}" if path else name)]

    return below(described, "")


def rechecked(part: Part, where: str) -> None:
    """Pass a part through its own checks again; of arrays, every item has to pass.

    Raises:
        InputError: naming `where`: its numbers contradict each other.
    """
    for check in _checks(type(part)):
        try:
            try:
                check(part)
            except ValueError as error:
                if "truth value of an array" not in str(error):
                    raise
                check(_with_any(part))
        except ValueError as error:
            what, _, right = str(error).partition("; ")
            raise InputError(what, where=where, right=right) from None


@lru_cache(maxsize=1000)
def _checks(part: type[Part]) -> list[Callable[[Any], Any]]:
    """Return the validators that run on a part once its values are validated."""
    return [one.func for one in part.__pydantic_decorators__.model_validators.values() if one.info.mode == "after"]


def _bare(annotation: Any) -> Any:
    """An annotation without its notes."""
    while hasattr(annotation, "__metadata__"):
        annotation = get_args(annotation)[0]
    return annotation


def _item_annotations(annotation: Any, count: int) -> list[Any]:
    """Annotations of the items of a tuple."""
    annotation = _bare(annotation)
    items = [one for one in get_args(annotation) if one is not Ellipsis]
    return items if len(items) == count else (items or [Any])[:1] * count


def _checked(value: Any, annotation: Any, where: str) -> Any:
    """A value as it would be read from a file, but for numbers, which are in SI units."""
    if annotation is Any:
        return value
    if getattr(value, "ndim", 0) and get_origin(_bare(annotation)) is tuple:
        value = tuple(value)
    if isinstance(value, tuple) and any(getattr(item, "ndim", 0) for item in value):
        items = _item_annotations(annotation, len(value))
        return tuple(_checked(item, one, where) for item, one in zip(value, items, strict=True))
    if getattr(value, "ndim", 0):
        return _checked_array(value, annotation, where)
    if hasattr(value, "dtype"):
        value = value.item()
    if isinstance(value, float) and is_whole(annotation) and value.is_integer():
        value = int(value)
    kind = quantity_of(annotation)
    # What code computes may be zero but for rounding, where zero may stand.
    tiny = kind is not None and isinstance(value, float) and 0.0 < abs(value) < kind.least
    try:
        found = _adapter(annotation).validate_python(0.0 if tiny else value, context=SI)
    except ValidationError as error:
        raise explained_value(error, where, kind) from None
    return value if tiny else found


def _checked_array(values: "np.ndarray[Any, Any]", annotation: Any, where: str) -> "np.ndarray[Any, Any]":
    """An array of numbers, each of which may stand there: bounds are intervals, so that the extremes tell."""
    import numpy as np  # noqa: PLC0415  # descriptions are read without it

    if not np.issubdtype(values.dtype, np.number) or values.size == 0:
        raise InputError(f"{shown(values)} is not an array of numbers", where=where, right="give a number for each run")
    if is_whole(annotation) and np.any(values != np.round(values)):
        raise InputError("has an item that is not a whole number", where=where, right="give whole numbers")
    away = np.abs(values[values != 0.0])
    for worst in (values.min(), values.max(), *([away.min()] if away.size and values.min() >= 0.0 else [])):
        _checked(worst.item(), annotation, where)
    return values


def forget_annotations() -> None:
    """Look at annotations anew: what they allow has changed."""
    _adapter.cache_clear()


@lru_cache(maxsize=1000)
def _adapter(annotation: Any) -> TypeAdapter[Any]:
    try:
        return TypeAdapter(annotation, config=ConfigDict(allow_inf_nan=False))
    except PydanticUserError:  # a part has a configuration of its own
        return TypeAdapter(annotation)


def _with_any(part: Any) -> Any:
    """A part whose arrays are true where any of their items is: a check then refuses it if it refuses one item."""
    import numpy as np  # noqa: PLC0415

    class AnyOf(np.ndarray[Any, Any]):
        def __bool__(self) -> bool:
            return bool(np.any(np.asarray(self)))

    def viewed(one: Any) -> Any:
        if isinstance(one, np.ndarray):
            return one.view(AnyOf)
        if isinstance(one, tuple):
            return tuple(map(viewed, one))
        if isinstance(one, dict):
            return {key: viewed(item) for key, item in one.items()}
        if isinstance(one, BaseModel):
            return one.model_copy(update={name: viewed(getattr(one, name)) for name in type(one).model_fields})
        return one

    return viewed(part)
