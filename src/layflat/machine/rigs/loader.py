"""From the file of a bench, or the name of a built-in one, to its validated description."""

from __future__ import annotations

import tomllib
from difflib import get_close_matches
from importlib.resources import files
from pathlib import Path
from typing import Any, TypeAlias

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from layflat.description.provenance import split
from layflat.errors import MachineError
from layflat.machine.loader import Plain, Sources, load, names
from layflat.machine.model import Machine
from layflat.machine.rigs.friction import FrictionRig
from layflat.machine.rigs.regulated import RegulatedRig
from layflat.machine.rigs.vessel import VesselRig

Rig: TypeAlias = FrictionRig | RegulatedRig | VesselRig
"""A bench that is no machine."""

KINDS: dict[str, type[Rig]] = {
    "friction rig": FrictionRig,
    "regulated joint": RegulatedRig,
    "vessel": VesselRig,
}
"""Descriptions by the `kind` at the top of their files."""

BUILT_IN = files("layflat.machine.rigs") / "builtin"


def rig_names() -> tuple[str, ...]:
    """Names of the built-in benches."""
    return tuple(sorted(entry.name.removesuffix(".toml") for entry in BUILT_IN.iterdir()))


def load_described(where: str | Path) -> Machine | Rig:
    """A machine or a bench, from its built-in name or from a TOML file.

    Raises:
        MachineError: in one line, which file, key and value is wrong and what would be right.
    """
    described: Machine | Rig = load_rig(where) if is_rig(where) else load(str(where))
    return described


def is_rig(where: str | Path) -> bool:
    """Whether a built-in name or a file is that of a bench that is no machine."""
    place = str(where)
    return place in rig_names() or (place not in names() and Path(place).is_file() and "kind" in rig_tables(place)[0])


def load_rig(rig: str | Path) -> Any:
    """A bench from its built-in name or from a TOML file, of the class for its kind.

    Raises:
        MachineError: in one line, which file, key and value is wrong and what would be right.
    """
    return build_rig(rig_tables(rig)[0], str(rig))


def rig_tables(rig: str | Path) -> tuple[Plain, Sources]:
    """The plain values of a bench as they are written, and where they come from.

    Raises:
        MachineError: the file is missing or broken.
    """
    where = str(rig)
    try:
        return split(tomllib.loads(_text(where)), where)
    except tomllib.TOMLDecodeError as error:
        raise MachineError(f"is not TOML: {error}", where=where, right='values look like volume = "10 l"') from None


def build_rig(tables: Plain, where: str) -> Any:
    """Validate plain tables, quantities as text with units, into a bench, of the class for its kind.

    Raises:
        MachineError: naming `where`, the key and the value.
    """
    kind = tables.get("kind")
    if kind not in KINDS:
        raise MachineError(f"{kind!r} is no kind of bench", where=f"{where}: kind", right=f"give {' or '.join(KINDS)}")
    try:
        return KINDS[str(kind)].model_validate(tables)
    except ValidationError as error:
        found = sorted(
            error.errors(), key=lambda one: one["type"] != "extra_forbidden"
        )  # what was misspelt is missing too
        raise _explained(found[0], where, KINDS[str(kind)]) from None


def _text(where: str) -> str:
    if where in rig_names():
        return (BUILT_IN / f"{where}.toml").read_text(encoding="utf-8")
    path = Path(where)
    try:
        return path.read_text(encoding="utf-8")
    except OSError as error:
        right = f"give a TOML file, or {' or '.join(map(repr, rig_names()))}"
        raise MachineError(f"can't be read ({error.strerror})", where=where, right=right) from None
    except UnicodeDecodeError:
        raise MachineError("is not a text file in UTF-8", where=where, right="give a TOML file") from None


def _explained(error: ErrorDetails, where: str, kind: type[BaseModel]) -> MachineError:
    """One line for the first thing that pydantic found wrong."""
    place = f"{where}: {'.'.join(map(str, error['loc']))}" if error["loc"] else where
    message = error["msg"].removeprefix("Value error, ")
    if error["type"] == "extra_forbidden":
        return MachineError("unknown key", where=place, right=_beside(error["loc"], kind))
    if error["type"] == "missing":
        return MachineError("is missing", where=place, right=f"see the built-in {' or '.join(rig_names())}")
    if error["type"] == "value_error":
        return MachineError(message, where=place)
    if error["type"] == "quantity":
        problem, _, right = message.partition("; ")
        return MachineError(f"{error['input']!r} {problem}", where=place, right=right)
    right = message[0].lower() + message[1:].replace("Input ", "it ")
    return MachineError(f"{error['input']!r} is out of range", where=place, right=right.replace("input ", "it "))


def _beside(location: tuple[int | str, ...], kind: type[BaseModel]) -> str:
    """What stands beside an unknown key: the nearest, or all."""
    part: Any = kind
    for key in location[:-1]:
        part = part.model_fields[key].annotation
    known = list(part.model_fields)
    near = get_close_matches(str(location[-1]), known, n=1)
    return f"did you mean {near[0]!r}?" if near else f"known keys are {', '.join(known)}"
