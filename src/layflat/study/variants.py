"""Machines that a study compares: each the study's own, or another one, with changes."""

from dataclasses import dataclass
from pathlib import Path

from layflat.description.change import changed_all, paths, value_at
from layflat.description.provenance import split
from layflat.description.tables import laid_over, leaves
from layflat.errors import InputError
from layflat.machine import Machine, load
from layflat.machine.loader import tables
from layflat.machine.model import build
from layflat.study.description import StudyFile, VariantTable


@dataclass(frozen=True)
class Variant:
    """A machine by its name in the table; the name is empty where a study has but one machine."""

    name: str
    machine: Machine


def variants(file: StudyFile, folder: Path, where: str) -> tuple[Variant, ...]:
    """Return the machines of a study; machine files are meant relative to `folder` (InputError: naming `where`)."""
    machine = load(_place(file.machine, folder))
    if not file.variant:
        return (Variant("", machine),)
    names = [table.name for table in file.variant]
    if len(set(names)) < len(names):
        raise InputError("two have the same name", where=f"{where}: variant.name", right="give each its own")
    made = tuple(
        Variant(table.name, _varied(table, file.machine, folder, f"{where}: variant.{i}"))
        for i, table in enumerate(file.variant)
    )
    for i, one in enumerate(made):
        if one.machine.arm.joints != made[0].machine.arm.joints:
            what = f"has the joints {', '.join(one.machine.arm.joints)}"
            right = f"all variants have the same: {', '.join(made[0].machine.arm.joints)}"
            raise InputError(what, where=f"{where}: variant.{i}", right=right)
    return made


def _place(machine: str, folder: Path) -> str:
    """A file is meant relative to the study's file."""
    return str(folder / machine) if machine.endswith(".toml") else machine


def _varied(table: VariantTable, usual: str, folder: Path, where: str) -> Machine:
    place = _place(table.machine or usual, folder)
    plain, sources = tables(place)
    over, own = split(table.set, f"{where}.set")
    machine = build(laid_over(plain, over), sources | own, f"{where}.set" if over else place)
    known, times = set(paths(machine)), dict[str, float]()
    for path, factor in leaves(table.times):
        key = f"{where}.times.{path}"
        if isinstance(factor, bool) or not isinstance(factor, (int, float)) or factor < 0:
            raise InputError(f"{factor!r} is not a factor", where=key, right="give a number such as 2.0")
        if path not in known:
            value_at(machine, path)
            raise InputError("is not a number", where=key, right="name a single number of the machine")
        times[path] = value_at(machine, path) * factor
    machine = changed_all(machine, times, f"{where}.times")
    return build(machine.model_dump(mode="json"), sources | own, f"{where}.times") if table.times else machine
