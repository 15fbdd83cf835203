"""Kinds of test benches, and their descriptions from files or by the names of built-in ones.

A kind is one folder beside this file, and one line here. A folder has a `description` with the class `DESCRIPTION`, and
a `model` with the `BENCH` that fits its logs; descriptions that are built in stand with those of machines, in a room of
their own; two kinds of bench take their logs.
"""

from importlib import import_module
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from layflat.description.explain import explained
from layflat.description.hints import nearest
from layflat.description.provenance import Sources
from layflat.description.tables import Plain
from layflat.description.text import exists
from layflat.description.wrong import shown
from layflat.errors import MachineError
from layflat.identify.benches.contract import Bench, BenchDescription, Logs, check_known
from layflat.machine import Machine, load
from layflat.machine.loader import BENCHES, MACHINES, tables

KINDS = {"friction rig": "rod", "regulated joint": "regulated", "vessel": "vessel"}  # folders by a description's `kind`
HYDDOWN = {".yml", ".yaml"}  # suffixes of HydDown's input files, which describe vessels


def is_bench(where: str | Path) -> bool:
    """Tell whether a built-in name or a file is that of a test bench that is not a machine."""
    place, seen = str(where), set[str]()
    if Path(place).suffix in HYDDOWN:
        return True
    while place not in seen and place not in MACHINES.names and exists(Path(place)):
        seen.add(place)
        raw = BENCHES.raw(place)
        if "kind" in raw or not isinstance(raw.get("extends"), str):
            return "kind" in raw
        place = BENCHES.beside(place, raw["extends"])
    return place in BENCHES.names


def load_described(where: str | Path) -> Machine | BenchDescription:
    """Return a machine or a test bench, as `load` and `load_bench` do."""
    return load_bench(where) if is_bench(where) else load(str(where))


def described_tables(where: str | Path) -> tuple[Plain, Sources]:
    """Return the plain values of a machine or a test bench as they are written, and their sources."""
    return bench_tables(where) if is_bench(where) else tables(where)


def load_bench(where: str | Path) -> Any:
    """Return a test bench from its built-in name or file (HydDown's too); raise MachineError if anything is wrong."""
    return build_bench(bench_tables(where)[0], str(where))


def bench_tables(where: str | Path) -> tuple[Plain, Sources]:
    """Return the plain values of a test bench as they are written, and their sources; raise MachineError if broken."""
    if Path(where).suffix in HYDDOWN:
        from layflat.identify.benches.vessel.hyddown import hyddown_tables  # noqa: PLC0415  # of few benches

        return hyddown_tables(where), {}
    return BENCHES.tables(where)


def build_bench(plain: Plain, where: str) -> Any:
    """Validate plain tables into a test bench of the class for its kind; raise MachineError naming `where` and key."""
    kind = plain.get("kind")
    if str(kind) not in KINDS:
        near = nearest(kind, KINDS)
        hint = f'did you mean "{near}"? ' if near else ""
        right = f"{hint}known kinds are {', '.join(KINDS)}"
        raise MachineError(f"unknown kind of test bench {shown(kind)}", where=f"{where}: kind", right=right)
    described = _part(KINDS[str(kind)], "description").DESCRIPTION
    try:
        return described.model_validate(plain)
    except ValidationError as error:
        complete = f"see the built-in {' or '.join(BENCHES.names)}"
        raise explained(error, where, described, MachineError, complete) from None


def bench_of(described: Machine | BenchDescription, logs: Logs) -> Bench:
    """The bench of a description with these logs: of a machine, a joint is turned slowly where only torque is there."""
    turned = all("torque" in log and "voltage" not in log for log in logs.values())
    of_machine = "joint_loops" if turned else "moving"
    folder = KINDS[described.kind] if isinstance(described, BenchDescription) else of_machine
    return _part(folder, "model").BENCH  # type: ignore[no-any-return]


def chosen_blocks(bench: Bench, fitted: str | None) -> list[str]:
    """Blocks from text such as "valve, hose"; raise InputError if the bench does not have one."""
    blocks = list(bench.default_blocks) if fitted is None else [part.strip() for part in fitted.split(",")]
    return check_known(blocks, bench.blocks, "--fit", "block")


def _part(folder: str, name: str):  # type: ignore[no-untyped-def]
    return import_module(f"{__package__}.{folder}.{name}")
