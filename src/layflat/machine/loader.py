"""From a description file, or the name of a built-in machine, to a validated `Machine`."""

from __future__ import annotations

import tomllib
from difflib import get_close_matches
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from layflat.description.provenance import Provenance, split
from layflat.errors import MachineError
from layflat.machine.model import Machine

Plain = dict[str, Any]
Sources = dict[str, Provenance]

BUILT_IN = files("layflat.machine") / "builtin"


@cache
def names() -> tuple[str, ...]:
    """Names of the built-in machines."""
    return tuple(
        sorted(entry.name.removesuffix(".toml") for entry in BUILT_IN.iterdir() if entry.name.endswith(".toml"))
    )


def load(machine: str | Path | Machine) -> Machine:
    """A machine from its built-in name or from a TOML file; a `Machine` is passed through.

    Raises:
        MachineError: in one line, which file, key and value is wrong and what would be right.
    """
    if isinstance(machine, Machine):
        return machine
    return build(*tables(machine), str(machine))


def tables(machine: str | Path) -> tuple[Plain, Sources]:
    """The plain values of a description as they are written, what it extends included, and where they come from.

    Raises:
        MachineError: the file is missing or broken.
    """
    return _read(str(machine), ())


def build(plain: Plain, sources: Sources, where: str) -> Machine:
    """Validate plain tables into a machine.

    Raises:
        MachineError: naming `where`, the key and the value.
    """
    try:
        machine = Machine.model_validate(plain)
    except ValidationError as error:
        raise explained(error.errors()[0], where, Machine) from None
    machine._provenance.update(sources)
    machine._origin = where
    return machine


def _read(where: str, seen: tuple[str, ...]) -> tuple[Plain, Sources]:
    """Tables of a file, laid over those of the file that it extends."""
    if where in seen:
        raise MachineError(f"extends itself through {' -> '.join(seen)}", where=where, right="break the circle")
    try:
        raw = tomllib.loads(_text(where))
    except tomllib.TOMLDecodeError as error:
        raise MachineError(f"is not TOML: {error}", where=where, right='values look like width = "160 mm"') from None
    base, omitted = raw.pop("extends", None), raw.pop("omits", [])
    plain, sources = split(raw, where)
    if base is None:
        return plain, sources
    if not isinstance(base, str):
        raise MachineError(f"{base!r} is not a name", where=f"{where}: extends", right='give one such as "paper-arm"')
    below = Path(where).parent / base
    under, under_sources = _read(str(below) if below.suffix == ".toml" else base, (*seen, where))
    for path in omitted:
        omit(under, under_sources, path, where)
    return laid_over(under, plain), under_sources | sources


def omit(plain: Plain, sources: Sources, path: str, where: str) -> None:
    """Leave out a part, by its dotted path, of what a file extends.

    Raises:
        MachineError: there is no such part.
    """
    *above, last = str(path).split(".")
    table: Any = plain
    for key in above:
        table = table.get(key, {}) if isinstance(table, dict) else {}
    if not isinstance(table, dict) or last not in table:
        raise MachineError(
            f"{path!r} is not there to omit", where=f"{where}: omits", right='name a part such as "valve"'
        )
    del table[last]
    for key in [key for key in sources if key == path or key.startswith(f"{path}.")]:
        del sources[key]


def _text(where: str) -> str:
    if where in names():
        return (BUILT_IN / f"{where}.toml").read_text(encoding="utf-8")
    path = Path(where)
    if not path.suffix and not path.exists():
        near = get_close_matches(where, names(), n=1)
        hint = f"did you mean {near[0]!r}?" if near else "`layflat machines` lists them"
        raise MachineError("no such machine", where=where, right=hint)
    try:
        return path.read_text(encoding="utf-8")
    except OSError as error:
        right = "give the path of a TOML file or a name that `layflat machines` lists"
        raise MachineError(f"can't be read ({error.strerror})", where=where, right=right) from None
    except UnicodeDecodeError:
        raise MachineError("is not a text file in UTF-8", where=where, right="give a TOML file") from None


def laid_over(under: Plain, over: Plain) -> Plain:
    """Tables with what differs in others put in their place."""
    merged = dict(under)
    for key, value in over.items():
        below = merged.get(key)
        merged[key] = laid_over(below, value) if isinstance(below, dict) and isinstance(value, dict) else value
    return merged


def explained(
    error: ErrorDetails, where: str, kind: type[BaseModel], complete: str = "`layflat show paper-arm` shows"
) -> MachineError:
    """One line for what pydantic found wrong with a description of some kind; `complete` shows a whole one."""
    key = ".".join(str(step) for step in _written(error["loc"]))
    value = error["input"]
    message = error["msg"].removeprefix("Value error, ")
    place = f"{where}: {key}" if key else where
    if error["type"] == "extra_forbidden":
        return MachineError("unknown key", where=place, right=_known_keys(error["loc"], kind))
    if error["type"] == "missing":
        return MachineError("is missing", where=place, right=f"{complete} a complete description")
    if error["type"] == "union_tag_invalid":
        kinds = error["ctx"]["expected_tags"].replace("'", '"').replace(", ", " or ")
        return MachineError(f"{value.get('kind')!r} is no kind of it", where=f"{place}.kind", right=f"give {kinds}")
    if error["type"] == "quantity":
        problem, _, right = message.partition("; ")
        return MachineError(f"{value!r} {problem}", where=place, right=right)
    if isinstance(value, dict):
        return MachineError(message, where=place)
    return MachineError(f"{value!r} is out of range", where=place, right=_plain_bound(error, message))


def _written(location: tuple[int | str, ...]) -> tuple[int | str, ...]:
    """A place as it stands in the file: without the kind that pydantic puts behind the key of a valve."""
    kinds = {"spool", "switching"}
    return tuple(step for i, step in enumerate(location) if not (step in kinds and location[i - 1] == "valve"))


def _plain_bound(error: ErrorDetails, message: str) -> str:
    text = message[0].lower() + message[1:]
    return text.replace("input ", "it ") + " (in SI units)" if "ctx" in error else text.replace("input ", "it ")


def _known_keys(location: tuple[int | str, ...], kind: type[BaseModel]) -> str:
    """The keys that stand beside an unknown one, nearest first."""
    schema: dict[str, Any] = kind.model_json_schema()
    definitions, here = schema["$defs"], schema
    for step in location[:-1]:
        here = here.get("properties", {}).get(step) or here.get("additionalProperties") or {}
        options = [here, *here.get("anyOf", [])]
        options += [kind for option in options for kind in option.get("oneOf", [])]
        names = [option["$ref"].rsplit("/", 1)[-1] for option in options if "$ref" in option]
        named = [definitions[name] for name in names]
        if len(named) == 1:
            here = named[0]
        elif named:
            here = {"properties": {kind["properties"]["kind"]["const"]: kind for kind in named}}
    known = list(here.get("properties", {}))
    near = get_close_matches(str(location[-1]), known, n=1)
    return f"did you mean {near[0]!r}?" if near else f"known keys are {', '.join(known)}"
