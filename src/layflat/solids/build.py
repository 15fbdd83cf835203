"""The folder of a machine that is to be built: solids, parts list, drawings, guide and documents."""

from __future__ import annotations

import re
from contextlib import nullcontext
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from layflat import extras
from layflat.design.summary import refuse_errors
from layflat.errors import DesignError, LayflatError
from layflat.files import whole_folder, write_text
from layflat.parallel import generate_in_process
from layflat.plot import render_page
from layflat.solids.assembly import Assembly, assemble
from layflat.solids.blanks import list_cuts
from layflat.solids.checks.findings import FINDING_COLUMNS, MASS_COLUMNS, STRESS_COLUMNS, BuildChecks, check_build
from layflat.solids.cost import Cost, Prices, cost_of
from layflat.solids.documents import write_documents
from layflat.solids.drawings.assembly import DrawnMachine
from layflat.solids.drawings.write import SheetFiles, write_drawings
from layflat.solids.exchange import write_assembly_step, write_part_files
from layflat.solids.gltf import write_glb
from layflat.solids.guide import guide_page
from layflat.solids.parts_files import parts_page, write_parts_csv, write_parts_xlsx
from layflat.solids.parts_list import PartsList, list_parts

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from contextlib import AbstractContextManager
    from pathlib import Path

    from layflat.machine import Machine
    from layflat.solids.component import Component

STAGE_NAMES = ("solids", "checks", "parts", "documents", "guide", "drawings")
"""Stages of a build, in their order."""


@dataclass(frozen=True)
class BuiltMachine:
    """A machine as it was built, and the files of it."""

    assembly: Assembly
    parts: PartsList
    checks: BuildChecks
    folder: Path
    omitted: dict[str, str]  # joints and documents that could not be made, and why
    cost: Cost | None = None  # None without prices


def build_files(name: str) -> tuple[str, ...]:
    """Return the names of what the folder of a machine may hold."""
    endings = (
        ".step", ".glb", "-parts.csv", "-parts.xlsx", "-parts.html", "-guide.html", "-checks.html", "-air.svg",
        "-tubes.csv", "-wiring.svg", "-wiring.csv", "-commissioning.html",
    )  # fmt: skip
    return (*(f"{name}{ending}" for ending in endings), "settings.py", "parts", "drawings")


def build_machine(
    machine: Machine,
    out: Path,
    *,
    angles: Sequence[float] | None = None,
    prices: Prices | None = None,
    aside: bool = False,
    progress: Callable[[str, float], object] = lambda _stage, _share: None,
) -> BuiltMachine:
    """Write solids, parts list, drawings, guide and documents of a machine into a folder, all of them or none.

    Args:
        machine: the machine.
        out: folder, new or empty.
        angles: of the joints in the assembly from mid-stroke, rad; default: all in mid-stroke.
        prices: of parts, for the parts list; default: none.
        aside: whether another process draws meanwhile; the script that is run has to guard its main part then.
        progress: function that is called with a stage of `STAGE_NAMES` and the share of it that is done, 0 to 1.

    Raises:
        MissingExtraError: the extra `cad` is not installed.
        DesignError: no joint has solids, a check finds an error, or no size keeps a rule; the message says which
            value would mend it.
        InputError: the angles are not those of the joints.
        OutputError: the folder is not empty, or can't be written.
    """
    extras.require("cad", where="build")
    progress("solids", 0.0)
    assembly = assemble(machine, angles, mend=True)
    if not assembly.sizes:
        why = next(iter(assembly.omitted.values()))
        raise DesignError("no joint has solids", where=machine.origin, right=why)
    with whole_folder(out, build_files(machine.name)) as folder:
        assembly.build(lambda done, total: progress("solids", done / total))
        parts = list_parts(assembly.components, assembly.mass_of)
        drawn = _drawn_machine(assembly, parts)
        with _sheets_aside(drawn, folder / "drawings") if aside else nullcontext(()) as sheets:
            checks = check_build(assembly, lambda done, total: progress("checks", done / total))
            refuse_errors([replace(one, where=f"{machine.origin}: {one.where}") for one in checks.findings])
            write_text(folder / f"{machine.name}-checks.html", checks_page(machine.name, checks))
            _write_solids(assembly, parts, folder, progress)
            cost = None if prices is None else cost_of(parts, prices)
            _write_lists(assembly, parts, cost, folder)
            progress("documents", 0.0)
            omitted = assembly.omitted | _write_documents(machine, folder)
            progress("guide", 0.0)
            _write_guide(assembly, parts, folder)
            write_drawings(drawn, folder / "drawings", sheets, lambda done, total: progress("drawings", done / total))
    return BuiltMachine(assembly, parts, checks, out, omitted, cost)


def _drawn_machine(assembly: Assembly, parts: PartsList) -> DrawnMachine:
    """Return what the drawings of a machine need of it, which another process can take."""
    numbers = [parts.part(component).number for component in assembly.components]
    masses = [assembly.mass_of(component) for component in assembly.components]
    return DrawnMachine(assembly.machine.name, assembly.components, numbers, masses)


def _sheets_aside(machine: DrawnMachine, folder: Path) -> AbstractContextManager[Iterator[SheetFiles]]:
    """Return a context in which another process, which needs no CAD kernel, draws; its values as `draw_sheets`."""
    return generate_in_process("layflat.solids.drawings.write:draw_sheets", machine, folder)


def checks_page(name: str, checks: BuildChecks) -> str:
    """Return an HTML page of the checks of a machine.

    Args:
        name: of the machine.
        checks: their results.
    """
    tables = {
        "Findings": (FINDING_COLUMNS, (), checks.finding_table()),
        "Masses": (MASS_COLUMNS, (), checks.mass_table()),
        "Stresses": (STRESS_COLUMNS, (), checks.stress_table()),
    }
    return render_page("layflat.solids", "parts.html.j2", title=f"Checks of {name}", tables=tables)


def _links(name: str) -> dict[str, str]:
    """Return the documents for a first start by their titles."""
    return {
        "Pneumatic diagram": f"{name}-air.svg",
        "Tubes": f"{name}-tubes.csv",
        "Wiring": f"{name}-wiring.svg",
        "Sheet of the first start": f"{name}-commissioning.html",
    }


def _write_solids(assembly: Assembly, parts: PartsList, folder: Path, progress: Callable[[str, float], object]) -> None:
    """Write assembly and made parts for other programs."""
    name = assembly.machine.name

    def label(component: Component) -> str:
        part = parts.part(component)
        return f"{part.number} {component.name}"

    write_assembly_step(assembly, label, folder / f"{name}.step")
    write_glb(folder / f"{name}.glb", name, assembly.components, assembly.sizes, assembly.solid)
    made = [part for part in parts.parts if not part.bought]
    for done, part in enumerate(made):
        progress("parts", done / len(made))
        stem = f"{part.number:02d}-{re.sub(r'[^a-z0-9]+', '-', part.name.lower()).strip('-')}"
        write_part_files(assembly.solid(part.components[0]), part.name, folder / "parts" / f"{stem}.step")


def _write_lists(assembly: Assembly, parts: PartsList, cost: Cost | None, folder: Path) -> None:
    """Write the parts list in all its forms."""
    name, cuts = assembly.machine.name, list_cuts(assembly.components)
    write_parts_csv(parts, folder / f"{name}-parts.csv", cost)
    write_parts_xlsx(parts, cuts, folder / f"{name}-parts.xlsx", cost)
    write_text(folder / f"{name}-parts.html", parts_page(f"Parts of {name}", parts, cuts, cost))


def _write_guide(assembly: Assembly, parts: PartsList, folder: Path) -> None:
    """Write the assembly guide, with links to the documents that are there."""
    name = assembly.machine.name
    links = {title: file for title, file in _links(name).items() if (folder / file).exists()}
    page = guide_page(f"Guide to {name}", assembly.sizes, assembly.components, parts, links, assembly.solid)
    write_text(folder / f"{name}-guide.html", page)


def _write_documents(machine: Machine, folder: Path) -> dict[str, str]:
    """Write the documents of air, wires and first start; return why they could not be made, if so."""
    try:
        write_documents(machine, folder)
    except LayflatError as error:
        return {"documents": str(error)}
    return {}
