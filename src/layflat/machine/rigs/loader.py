"""From the file of a test bench, or the name of a built-in one, to its validated description."""

from __future__ import annotations

from pathlib import Path
from typing import Any, TypeAlias

from pydantic import ValidationError

from layflat.description.explain import explained
from layflat.description.hints import nearest
from layflat.description.provenance import Sources
from layflat.description.tables import Plain
from layflat.description.text import exists
from layflat.description.wrong import shown
from layflat.errors import MachineError
from layflat.machine.libraries import BENCHES, MACHINES
from layflat.machine.loader import load
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

BUILT_IN = BENCHES.folder


def rig_names() -> tuple[str, ...]:
    """Return the names of the built-in benches."""
    return BENCHES.names


def load_described(where: str | Path) -> Machine | Rig:
    """Return a machine or a bench, from its built-in name or from a TOML file.

    Raises:
        MachineError: in one line, which file, key and value is wrong and what would be right.
    """
    described: Machine | Rig = load_rig(where) if is_rig(where) else load(str(where))
    return described


def is_rig(where: str | Path) -> bool:
    """Tell whether a built-in name or a file is that of a bench that is no machine."""
    place, seen = str(where), set[str]()
    while place not in seen and place not in MACHINES.names and exists(Path(place)):
        seen.add(place)
        raw = BENCHES.raw(place)
        if "kind" in raw or not isinstance(raw.get("extends"), str):
            return "kind" in raw
        place = BENCHES.beside(place, raw["extends"])
    return place in BENCHES.names


def load_rig(rig: str | Path) -> Any:
    """Return a bench from its built-in name or from a TOML file, of the class for its kind.

    Raises:
        MachineError: in one line, which file, key and value is wrong and what would be right.
    """
    return build_rig(rig_tables(rig)[0], str(rig))


def rig_tables(rig: str | Path) -> tuple[Plain, Sources]:
    """Return the plain values of a bench as they are written, and where they come from.

    Raises:
        MachineError: the file is missing or broken.
    """
    return BENCHES.tables(rig)


def build_rig(tables: Plain, where: str) -> Any:
    """Validate plain tables, quantities as text with units, into a bench, of the class for its kind.

    Raises:
        MachineError: naming `where`, the key and the value.
    """
    kind = tables.get("kind")
    model = KINDS.get(str(kind))
    if model is None:
        near = nearest(kind, KINDS)
        hint = f'did you mean "{near}"? ' if near else ""
        known = f"{hint}known kinds are {', '.join(KINDS)}"
        raise MachineError(f"{shown(kind)} is no known kind of test bench", where=f"{where}: kind", right=known)
    try:
        return model.model_validate(tables)
    except ValidationError as error:
        raise explained(error, where, model, MachineError, f"see the built-in {' or '.join(rig_names())}") from None
