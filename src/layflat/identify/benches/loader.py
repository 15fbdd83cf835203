"""Kinds of test benches, and their descriptions from files or by the names of built-in ones.

A kind is a module or package beside this file, and one line here. It has `DESCRIPTION`, the class of its descriptions,
and `BENCH`, which fits its logs; built-in descriptions stand with those of machines, in a folder of their own.
"""

from importlib import import_module
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from layflat.description.explain import explain_error
from layflat.description.tables import Plain, Sources
from layflat.description.text import exists
from layflat.description.wrong import nearest, shown
from layflat.errors import MachineError
from layflat.identify.benches import BenchDescription, BenchKind, Logs, check_choices
from layflat.machine import Machine, load
from layflat.machine.loader import BENCH_LIBRARY, MACHINE_LIBRARY, tables

KINDS = {"friction rig": "rod", "regulated joint": "regulated", "vessel": "vessel"}  # modules by a description's `kind`
HYDDOWN = {".yml", ".yaml"}  # suffixes of HydDown's input files, which describe vessels


def is_bench(where: str | Path) -> bool:
    """Return whether a built-in name or a file is that of a test bench that is not a machine.

    A file of HydDown (YAML) is. Of others the `kind` counts, their own or that of the descriptions that they extend;
    an unknown name, or a file that is not there, is none.

    Raises:
        InputError: a file can't be read.
    """
    place, visited = str(where), set[str]()
    if Path(place).suffix in HYDDOWN:
        return True
    while place not in visited and place not in MACHINE_LIBRARY.names and exists(Path(place)):
        visited.add(place)
        raw = BENCH_LIBRARY.raw(place)
        if "kind" in raw or not isinstance(raw.get("extends"), str):
            return "kind" in raw
        place = BENCH_LIBRARY.resolve(place, raw["extends"])
    return place in BENCH_LIBRARY.names


def load_description(where: str | Path) -> Machine | BenchDescription:
    """Return a machine or a test bench, as `load` and `load_bench` do."""
    return load_bench(where) if is_bench(where) else load(str(where))


def description_tables(where: str | Path) -> tuple[Plain, Sources]:
    """Return the plain values of a machine or a test bench, with those that it extends, and their sources.

    Raises:
        InputError: there is no such machine or bench, or a file is broken.
    """
    return bench_tables(where) if is_bench(where) else tables(where)


def load_bench(where: str | Path) -> Any:
    """Return a test bench from its built-in name or file (HydDown's too); raise InputError if anything is wrong."""
    return build_bench(bench_tables(where)[0], str(where))


def bench_tables(where: str | Path) -> tuple[Plain, Sources]:
    """Return the plain values of a test bench, with those that it extends, and their sources.

    Sources are empty for a file of HydDown (YAML).

    Raises:
        InputError: there is no such bench, or a file is broken.
    """
    if Path(where).suffix in HYDDOWN:
        from layflat.identify.benches.vessel.hyddown import hyddown_tables  # noqa: PLC0415  # of few benches

        return hyddown_tables(where), {}
    return BENCH_LIBRARY.tables(where)


def build_bench(plain: Plain, where: str) -> Any:
    """Validate plain tables into a test bench of the class of its kind; raise MachineError naming `where` and key."""
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
        complete = f"see the built-in {' or '.join(BENCH_LIBRARY.names)}"
        raise explain_error(error, where, described, MachineError, complete) from None


def description_class(kind: str) -> Any:
    """Return the class of the descriptions of a kind of test bench, one of `KINDS`."""
    return _import_bench(KINDS[kind]).DESCRIPTION


def select_bench(described: Machine | BenchDescription, logs: Logs) -> BenchKind:
    """Return the bench of a description.

    That of a machine is `joint_loops` if all logs have torque and no voltage, else `moving`.
    """
    slow = all("torque" in log and "voltage" not in log for log in logs.values())
    of_machine = "joint_loops" if slow else "moving"
    name = KINDS[described.kind] if isinstance(described, BenchDescription) else of_machine
    return _import_bench(name).BENCH  # type: ignore[no-any-return]


def parse_blocks(bench: BenchKind, fitted: str | None) -> list[str]:
    """Return the blocks in a text such as "valve, hose", default ones if None; raise InputError if one is unknown."""
    blocks = list(bench.default_blocks) if fitted is None else [part.strip() for part in fitted.split(",")]
    return check_choices(blocks, bench.blocks, "blocks", "block")


def _import_bench(name: str):  # type: ignore[no-untyped-def]
    return import_module(f"{__package__}.{name}")
