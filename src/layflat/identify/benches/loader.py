"""From the file of a test bench, or the name of a built-in one, to its validated description."""

from __future__ import annotations

import tomllib
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from layflat.errors import MachineError
from layflat.identify.benches.contract import BenchDescription
from layflat.identify.benches.kinds import KINDS, built_in, description_class
from layflat.machine import Machine, load, names
from layflat.machine.loader import Plain, Sources, tables
from layflat.description.provenance import split

HYDDOWN = {".yml", ".yaml"}
"""Suffixes of HydDown's input files, which describe vessels."""


def bench_names() -> tuple[str, ...]:
    """Names of the built-in test benches."""
    return tuple(built_in())


def is_bench(where: str | Path) -> bool:
    """Whether a built-in name or a file is that of a test bench that is not a machine."""
    place = Path(where)
    if str(where) in built_in() or place.suffix in HYDDOWN:
        return True
    return str(where) not in names() and place.is_file() and "kind" in bench_tables(where)[0]


def load_described(where: str | Path) -> Machine | BenchDescription:
    """A machine or a test bench, from its built-in name or from a file; of a vessel also HydDown's input file.

    Raises:
        MachineError: in one line, which file, key and value is wrong and what would be right.
    """
    return load_bench(where) if is_bench(where) else load(str(where))


def described_tables(where: str | Path) -> tuple[Plain, Sources]:
    """The values of a machine or a test bench as they are written, and where they come from.

    Raises:
        MachineError: the file is missing or broken.
    """
    return bench_tables(where) if is_bench(where) else tables(where)


def load_bench(where: str | Path) -> Any:
    """A test bench from its built-in name or from a file, of the class for its kind.

    Raises:
        MachineError: in one line, which file, key and value is wrong and what would be right.
    """
    return build_bench(bench_tables(where)[0], str(where))


def bench_tables(where: str | Path) -> tuple[Plain, Sources]:
    """The values of a test bench as they are written, and where they come from.

    Raises:
        MachineError: the file is missing or broken.
    """
    if Path(where).suffix in HYDDOWN:
        from layflat.identify.benches.vessel.hyddown import hyddown_tables  # noqa: PLC0415  # of few benches

        return hyddown_tables(where), {}
    try:
        return split(tomllib.loads(_text(str(where))), str(where))
    except tomllib.TOMLDecodeError as error:
        right = 'values look like volume = "10 l"'
        raise MachineError(f"is not TOML: {error}", where=str(where), right=right) from None


def build_bench(plain: Plain, where: str) -> Any:
    """Validate plain tables, quantities as text with units, into a test bench of the class for its kind.

    Raises:
        MachineError: naming `where`, the key and the value.
    """
    kind = plain.get("kind")
    if kind not in KINDS:
        raise MachineError(f"unknown kind {kind!r}", where=f"{where}: kind", right=f"give {' or '.join(KINDS)}")
    described = description_class(str(kind))
    try:
        return described.model_validate(plain)
    except ValidationError as error:
        # What was misspelt is missing too.
        first = min(error.errors(), key=lambda one: one["type"] != "extra_forbidden")
        raise _explained(first, where, described) from None


def _text(where: str) -> str:
    path = built_in().get(where, Path(where))
    try:
        return path.read_text(encoding="utf-8")
    except OSError as error:
        right = f"give a TOML file, or {' or '.join(map(repr, bench_names()))}"
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
        return MachineError("is missing", where=place, right=f"see the built-in {' or '.join(bench_names())}")
    if error["type"] == "value_error":
        return MachineError(message, where=place)
    if error["type"] == "quantity":
        problem, _, right = message.partition("; ")
        return MachineError(f"{error['input']!r} {problem}", where=place, right=right)
    right = message[0].lower() + message[1:].replace("Input ", "it ")
    return MachineError(f"{error['input']!r} is out of range", where=place, right=right.replace("input ", "it "))


def _beside(location: tuple[int | str, ...], kind: type[BaseModel]) -> str:
    """The keys beside an unknown one: the nearest, or all."""
    part: Any = kind
    for key in location[:-1]:
        part = part.model_fields[key].annotation
    known = list(part.model_fields)
    near = get_close_matches(str(location[-1]), known, n=1)
    return f"did you mean {near[0]!r}?" if near else f"known keys are {', '.join(known)}"
