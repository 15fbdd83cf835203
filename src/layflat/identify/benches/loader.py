"""From the file of a test bench, or the name of a built-in one, to its validated description."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pydantic import ValidationError

from layflat.description.explain import explained
from layflat.description.hints import nearest
from layflat.description.provenance import Sources
from layflat.description.tables import Plain
from layflat.description.wrong import shown
from layflat.errors import MachineError
from layflat.identify.benches.contract import BenchDescription
from layflat.identify.benches.kinds import KINDS, description_class
from layflat.machine import Machine, load
from layflat.machine.libraries import BENCHES, HYDDOWN, is_bench
from layflat.machine.loader import tables


def bench_names() -> tuple[str, ...]:
    """Return the names of the built-in test benches."""
    return BENCHES.names


def load_described(where: str | Path) -> Machine | BenchDescription:
    """Return a machine or a test bench, from its built-in name or from a file; of a vessel also HydDown's input file.

    Raises:
        MachineError: in one line, which file, key and value is wrong and what would be right.
    """
    return load_bench(where) if is_bench(where) else load(str(where))


def described_tables(where: str | Path) -> tuple[Plain, Sources]:
    """Return the plain values of a machine or a test bench as they are written, and their sources.

    Raises:
        MachineError: the file is missing or broken.
    """
    return bench_tables(where) if is_bench(where) else tables(where)


def load_bench(where: str | Path) -> Any:
    """Return a test bench from its built-in name or from a file, of the class for its kind.

    Raises:
        MachineError: in one line, which file, key and value is wrong and what would be right.
    """
    return build_bench(bench_tables(where)[0], str(where))


def bench_tables(where: str | Path) -> tuple[Plain, Sources]:
    """Return the plain values of a test bench as they are written, and their sources.

    Raises:
        MachineError: the file is missing or broken.
    """
    if Path(where).suffix in HYDDOWN:
        from layflat.identify.benches.vessel.hyddown import hyddown_tables  # noqa: PLC0415  # of few benches

        return hyddown_tables(where), {}
    return BENCHES.tables(where)


def build_bench(plain: Plain, where: str) -> Any:
    """Validate plain tables, quantities as text with units, into a test bench of the class for its kind.

    Raises:
        MachineError: naming `where`, the key and the value.
    """
    kind = plain.get("kind")
    if str(kind) not in KINDS:
        near = nearest(kind, KINDS)
        hint = f'did you mean "{near}"? ' if near else ""
        right = f"{hint}known kinds are {', '.join(KINDS)}"
        raise MachineError(f"unknown kind of test bench {shown(kind)}", where=f"{where}: kind", right=right)
    described = description_class(str(kind))
    try:
        return described.model_validate(plain)
    except ValidationError as error:
        complete = f"see the built-in {' or '.join(bench_names())}"
        raise explained(error, where, described, MachineError, complete) from None
