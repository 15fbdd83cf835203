"""Variants of descriptions: values replaced by their dotted paths, and checked as in a file."""

from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import lru_cache
from types import UnionType
from typing import TYPE_CHECKING, Annotated, Any, TypeVar, Union, get_args, get_origin

from pydantic import BaseModel, ConfigDict, PydanticUserError, TypeAdapter, ValidationError

from layflat.description import DescribedFile, Part
from layflat.description.explain import explain_value_error
from layflat.description.quantity import SI, Quantity
from layflat.description.renamed import RENAMED_KEYS, present_path
from layflat.description.wrong import nearest, shown
from layflat.errors import InputError

if TYPE_CHECKING:
    import numpy as np

Described = TypeVar("Described", bound=Part)


def changed(described: Described, path: str, value: Any) -> Described:
    """Return a copy of a machine or a bench with one value replaced, by its dotted path, such as "arm.payload".

    The copy passes the checks of a file. Numbers are in SI units; a text has its unit. For an ensemble a number may be
    replaced by an array, with a number for each run, each of which is checked.

    Args:
        described: the description to copy.
        path: keys, and numbers of items, as `layflat machine show` lists them.
        value: a number, a text, an array of numbers, or a whole part.

    Raises:
        InputError: there is no such path, or the value is not valid there.

    Example:
        >>> import layflat as lf
        >>> heavier = lf.changed(lf.load("paper-arm"), "arm.payload", "2 kg")
        >>> heavier.arm.payload
        2.0
    """
    if not isinstance(path, str):
        raise InputError(f"{shown(path)} is no path", where="path", right='give one such as "arm.payload"')
    return changed_all(described, {path: value})


def changed_all(
    described: Described, values: Mapping[str, Any], where: str = "", *, together: bool = True
) -> Described:
    """Return a copy with several values replaced, each as by `changed`; the source of each is then "given".

    Args:
        described: the description to copy.
        values: new values by their dotted paths.
        where: name of the description in messages; default: its origin.
        together: whether the values are also checked against each other, after all are replaced.

    Raises:
        InputError: `described` is no description, there is no such path, or a value is not valid or contradicts others.
    """
    if not isinstance(described, Part):
        raise InputError(f"{shown(described)} is no description", where=where, right="give a machine: load(...)")
    where = where or _origin(described)
    bad_path = next((path for path in values if not isinstance(path, str)), None)
    if bad_path is not None:
        raise InputError(f"{shown(bad_path)} is no path", where=where, right='give one such as "arm.payload"')
    above: set[str] = set()
    for path, value in values.items():
        described = _with_tables(described, path)
        value_at(described, path)
        checked = _checked(value, annotation_at(described, path), f"{where}: {path}")
        described = replace_value(described, path.split("."), checked)
        above |= {path.rsplit(".", i)[0] for i in range(1, path.count(".") + 1)}
    if isinstance(described, DescribedFile):
        described.note_given(values)
    if not together:
        return described
    for place in sorted(above, key=lambda path: -path.count(".")):
        part = value_at(described, place)
        if isinstance(part, Part):
            recheck(part, f"{where}: {place}")
    recheck(described, where)
    return described


def value_at(described: Part, path: str) -> Any:
    """Return the value (SI) or the part itself at a dotted path, items of lists by number from 0.

    Raises:
        InputError: there is no such path; the message has the nearest one, or the new name of a renamed one.
    """
    part: Any = described
    for key in path.split("."):
        if isinstance(part, dict) and key in part:
            part = part[key]
        elif isinstance(part, tuple) and key.isdigit() and int(key) < len(part):
            part = part[int(key)]
        elif key in getattr(type(part), "model_fields", {}):
            part = getattr(part, key)
        else:
            if present := _present_path(described, path):
                raise InputError(
                    f"is called {present} now", where=f"{_origin(described)}: {path}", right="use that path"
                )
            near = nearest(path, paths(described), cutoff=0.5)
            right = f"nearest is {near!r}" if near else "`layflat machine show` lists the paths"
            raise InputError(f"{key!r} is not there", where=f"{_origin(described)}: {path}", right=right)
    return part


def _with_tables(described: Described, path: str) -> Described:
    """Return a description in which tables that were left out above a path stand, if all their keys have defaults."""
    keys = path.split(".")
    for above in (".".join(keys[:i]) for i in range(1, len(keys))):
        with suppress(InputError):  # a path that is not there, which its reader refuses in words
            if value_at(described, above) is None:
                tables = [one for one in _choices(annotation_at(described, above)) if _is_table(one)]
                described = replace_value(described, above.split("."), tables[0]()) if tables else described
    return described


def _is_table(annotation: Any) -> bool:
    """Return whether an annotation is that of a table whose keys all have defaults."""
    return (
        isinstance(annotation, type)
        and issubclass(annotation, Part)
        and not any(field.is_required() for field in annotation.model_fields.values())
    )


def _present_path(described: Part, path: str) -> str | None:
    """Return the path that a renamed path has in a description now; None if it was not renamed."""
    for present in {present_path(noun, path) for noun in RENAMED_KEYS} - {path}:
        with suppress(InputError):
            value_at(described, present)
            return present
    return None


def _origin(described: Part) -> str:
    return getattr(described, "origin", "") or getattr(described, "name", type(described).__name__)


def replace_value(part: Any, keys: list[str], value: Any) -> Any:
    """Return a copy of a part with the value at a path replaced, unchecked.

    Args:
        part: a part, dictionary or tuple.
        keys: the path's keys, and numbers of items.
        value: the new value.
    """
    if not keys:
        return value
    head, rest = keys[0], keys[1:]
    if isinstance(part, tuple):
        return tuple(replace_value(item, rest, value) if i == int(head) else item for i, item in enumerate(part))
    if isinstance(part, dict):
        return {**part, head: replace_value(part[head], rest, value)}
    return part.model_copy(update={head: replace_value(getattr(part, head), rest, value)})


def annotation_at(described: Part, path: str) -> Any:
    """Return the annotation of the value at an existing dotted path, with its quantity and its bounds."""
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
    """Return the annotation of a field with its metadata, which Pydantic stores separately."""
    field = part.model_fields[key]
    return Annotated[(field.annotation, *field.metadata)] if field.metadata else field.annotation


def quantity_of(annotation: Any) -> Quantity | None:
    """Return the quantity of an annotation, also of a value that may be left out; None for a number without unit."""
    return next(
        (note for one in _choices(annotation) for note in get_args(one)[1:] if isinstance(note, Quantity)), None
    )


def is_whole(annotation: Any) -> bool:
    """Return whether an annotation is that of whole numbers."""
    return any(int in (one, *get_args(one)[:1]) for one in _choices(annotation))


def _choices(annotation: Any) -> tuple[Any, ...]:
    """Return an annotation, or those between which it gives the choice."""
    return get_args(annotation) if get_origin(annotation) in {Union, UnionType} else (annotation,)


def paths(described: Part) -> list[str]:
    """Return the dotted paths of all numbers of a description."""

    def below(part: Any, path: str) -> list[str]:
        """Return the paths of the numbers at and below a part, which is at `path`."""
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


def recheck(part: Part, where: str) -> None:
    """Check the values of a part against each other by its own validators; of arrays, every item has to pass.

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
    """Return the validators that run on a part after those of its values."""
    validators = part.__pydantic_decorators__.model_validators.values()
    return [validator.func for validator in validators if validator.info.mode == "after"]


def _bare(annotation: Any) -> Any:
    """Return an annotation without its metadata."""
    while hasattr(annotation, "__metadata__"):
        annotation = get_args(annotation)[0]
    return annotation


def _item_annotations(annotation: Any, count: int) -> list[Any]:
    """Return the annotations of the `count` items of a tuple of fixed or of any length."""
    annotation = _bare(annotation)
    items = [item for item in get_args(annotation) if item is not Ellipsis]
    return items if len(items) == count else (items or [Any])[:1] * count


def _checked(value: Any, annotation: Any, where: str) -> Any:
    """Return a value from code (numbers in SI units) validated by its annotation; raise InputError naming `where`."""
    if annotation is Any:
        return value
    if getattr(value, "ndim", 0) and get_origin(_bare(annotation)) is tuple:
        value = tuple(value)
    if isinstance(value, tuple) and any(getattr(item, "ndim", 0) for item in value):
        items = _item_annotations(annotation, len(value))
        return tuple(_checked(item, expected, where) for item, expected in zip(value, items, strict=True))
    if getattr(value, "ndim", 0):
        return _checked_array(value, annotation, where)
    if hasattr(value, "dtype"):
        value = value.item()
    if isinstance(value, float) and is_whole(annotation) and value.is_integer():
        value = int(value)
    kind = quantity_of(annotation)
    # A computed value may differ from zero by rounding alone; it is valid where zero is.
    tiny = kind is not None and isinstance(value, float) and 0.0 < abs(value) < kind.least
    try:
        validated = _type_adapter(annotation).validate_python(0.0 if tiny else value, context=SI)
    except ValidationError as error:
        raise explain_value_error(error, where, kind) from None
    return value if tiny else validated


def _checked_array(values: "np.ndarray[Any, Any]", annotation: Any, where: str) -> "np.ndarray[Any, Any]":
    """Return an array unchanged; raise InputError if an extreme is not valid (which suffices: bounds are intervals)."""
    import numpy as np  # noqa: PLC0415  # descriptions are read without it

    if not np.issubdtype(values.dtype, np.number) or values.size == 0:
        raise InputError(f"{shown(values)} is not an array of numbers", where=where, right="give a number for each run")
    if is_whole(annotation) and np.any(values != np.round(values)):
        odd = values[values != np.round(values)][0].item()
        raise InputError(f"{shown(odd)} is not a whole number", where=where, right="give whole numbers")
    nonzero = np.abs(values[values != 0.0])
    for extreme in (values.min(), values.max(), *([nonzero.min()] if nonzero.size and values.min() >= 0.0 else [])):
        _checked(extreme.item(), annotation, where)
    return values


def forget_annotations() -> None:
    """Clear the cache of validators, after the values that annotations allow have changed."""
    _type_adapter.cache_clear()


@lru_cache(maxsize=1000)
def _type_adapter(annotation: Any) -> TypeAdapter[Any]:
    """Return the validator of an annotation, which refuses infinity and NaN."""
    try:
        return TypeAdapter(annotation, config=ConfigDict(allow_inf_nan=False))
    except PydanticUserError:  # a part has a configuration of its own
        return TypeAdapter(annotation)


def _with_any(part: Any) -> Any:
    """Return a copy of a part whose arrays count as true if any item is true; comparisons still go item by item.

    So a validator that raises an error `if` a comparison holds raises it if that holds for one item.
    """
    import numpy as np  # noqa: PLC0415

    class AnyTrueArray(np.ndarray[Any, Any]):
        def __bool__(self) -> bool:
            return bool(np.any(np.asarray(self)))

    def view(value: Any) -> Any:
        """Return a copy of a value in which every array is an `AnyTrueArray`."""
        if isinstance(value, np.ndarray):
            return value.view(AnyTrueArray)
        if isinstance(value, tuple):
            return tuple(map(view, value))
        if isinstance(value, dict):
            return {key: view(item) for key, item in value.items()}
        if isinstance(value, BaseModel):
            return value.model_copy(update={name: view(getattr(value, name)) for name in type(value).model_fields})
        return value

    return view(part)
