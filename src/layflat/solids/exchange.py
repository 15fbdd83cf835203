"""Files for other CAD programs and printers: STEP of assemblies and parts, STL of parts; all lengths in mm."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any

from layflat.errors import OutputError
from layflat.files import whole_file
from layflat.solids import cad
from layflat.solids.colours import MATERIAL_COLOURS
from layflat.solids.meshes import kernel_modules, triangulate

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from layflat.solids.assembly import Assembly
    from layflat.solids.component import Component

FILE_DATE = datetime(2000, 1, 1, tzinfo=UTC)  # in headers of STEP, so that equal assemblies give equal files
STL_DEVIATION = 0.05  # most that a triangle is off a curved face, mm
STL_ANGLE = 0.2  # most between neighbouring triangles of a curved face, rad


def write_assembly_step(assembly: Assembly, label: Callable[[Component], str], path: Path) -> Path:
    """Write an assembly as STEP, a named and coloured body a part in a group a joint, and return the path.

    Args:
        assembly: the assembly.
        label: function that returns the name of a component's parts.
        path: of the file.

    Raises:
        OutputError: the file can't be written.
    """
    b = cad.kernel()
    groups: dict[str, list[Any]] = {}
    colours = {name: b.Color(MATERIAL_COLOURS[name]) for name in {one.material for one in assembly.components}}
    for component, _, body in assembly.bodies():
        body.label = label(component)
        body.color = colours[component.material]
        groups.setdefault(component.joint, []).append(body)
    children = [b.Compound(label=joint or "arm", children=bodies) for joint, bodies in groups.items()]
    return _write_step(b.Compound(label=assembly.machine.name, children=children), path)


def write_part_files(solid: Any, name: str, path: Path) -> list[Path]:
    """Write a part as STEP and as STL and return the paths.

    Args:
        solid: of the part, in its own frame.
        name: of the part in the file.
        path: of the STEP file; that of the STL has another ending.

    Raises:
        OutputError: a file can't be written.
    """
    b = cad.kernel()
    part = b.Compound(label=name, children=[type(solid)(solid.wrapped)])
    stl = path.with_suffix(".stl")
    triangulate(solid, STL_DEVIATION, STL_ANGLE)
    (writing,) = kernel_modules("StlAPI")
    writer = writing.StlAPI_Writer()
    writer.ASCIIMode = False
    with whole_file(stl) as temporary:
        _check_written(writer.Write(solid.wrapped, str(temporary)), stl)
    return [_write_step(part, path), stl]


def _write_step(shape: Any, path: Path) -> Path:
    b = cad.kernel()
    with whole_file(path) as temporary:
        _check_written(b.export_step(shape, str(temporary), timestamp=FILE_DATE), path)
    return path


def _check_written(done: bool, path: Path) -> None:
    """Raise OutputError unless the kernel says that it wrote a file: it raises nothing where the disk is full."""
    if not done:
        raise OutputError("can't be written", where=str(path), right="see whether the disk is full")
