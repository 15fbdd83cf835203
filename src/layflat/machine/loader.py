"""From a description file, or the name of a built-in machine, to a validated `Machine`."""

import json
from functools import lru_cache
from pathlib import Path

from pydantic import ValidationError

from layflat.description.change import forget_annotations
from layflat.description.explain import explained
from layflat.description.provenance import Sources
from layflat.description.tables import Plain
from layflat.errors import MachineError
from layflat.jit.outside import load_kinds
from layflat.kinds import Table
from layflat.machine.libraries import BENCHES, MACHINES
from layflat.machine.model import Machine
from layflat.machine.parts import Joint
from layflat.physics.hysteresis import ParallelPart

BUILT_IN = MACHINES.folder

FORMER = {"surplus": "air_residual"}
"""Keys of `safety` that have another name now; files and logs of earlier versions have the first."""


def names() -> tuple[str, ...]:
    """Return the names of the built-in machines."""
    return MACHINES.names


def load(machine: str | Path | Machine) -> Machine:
    """Return a machine from its built-in name or from a TOML file; a `Machine` is passed through.

    Raises:
        MachineError: in one line, which file, key and value is wrong and what would be right.
    """
    if isinstance(machine, Machine):
        return machine
    return build(*tables(machine), str(machine))


def tables(machine: str | Path) -> tuple[Plain, Sources]:
    """Return the plain values of a description as they are written, what it extends included, and their sources.

    Raises:
        MachineError: the file is missing or broken, or describes a test bench.
    """
    where = str(machine)
    if where in BENCHES.names:
        raise _is_bench(where)
    plain, sources = MACHINES.tables(machine)
    if "kind" in plain:
        raise _is_bench(where)
    return plain, sources


def _is_bench(where: str) -> MachineError:
    return MachineError("is a test bench, not a machine", where=where, right="`layflat identify` takes it")


def build(plain: Plain, sources: Sources, where: str) -> Machine:
    """Validate plain tables into a machine; the files of kinds that they name are run first.

    Raises:
        MachineError: naming `where`, the key and the value.
        KindError: a file of kinds can't be run.
    """
    for path in plain.get("kinds", ()):
        load_kinds(Path(path), f"{where}: kinds")
    _know_all_kinds(Table.registered)
    if isinstance(safety := plain.get("safety"), dict):
        plain = plain | {"safety": {FORMER.get(key, key): value for key, value in safety.items()}}
    try:
        machine = Machine.model_validate(plain)
    except ValidationError as error:
        raise explained(
            error, where, Machine, MachineError, "`layflat show paper-arm` shows a complete description"
        ) from None
    machine._provenance.update(sources)
    machine._origin = where
    return machine


def restored(text: str, where: str = "") -> Machine:
    """Return a machine from the JSON that it was kept as, in a run or a log; raise MachineError if it is none."""
    return build(json.loads(text), {}, where)


@lru_cache(maxsize=1)
def _know_all_kinds(registered: int) -> None:  # noqa: ARG001  # again whenever their number changes
    for part in (ParallelPart, Joint, Machine):
        if part.__pydantic_complete__:
            part.model_rebuild(force=True)
    forget_annotations()
