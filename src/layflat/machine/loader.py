"""From a description file, or the name of a built-in machine, to a validated `Machine`."""

from pathlib import Path

from layflat.description.provenance import Sources
from layflat.description.tables import Plain
from layflat.errors import MachineError
from layflat.machine.libraries import BENCHES, MACHINES
from layflat.machine.model import Machine, build

BUILT_IN = MACHINES.folder


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
