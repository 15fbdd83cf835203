"""Processes that make parts, and the walls, holes and bends that they can do.

Each limit is the larger of an absolute one and a share of the sheet's thickness; parts that are not sheets have no
thickness in this sense.
"""

from dataclasses import dataclass

from layflat.design.summary import Finding
from layflat.errors import DesignError
from layflat.solids.standard.materials import material


@dataclass(frozen=True)
class Process:
    """Process with its limits."""

    name: str
    min_wall: float  # between two edges, m
    wall_share: float  # of the thickness, between two edges
    min_hole: float  # diameter, m
    hole_share: float  # of the thickness, diameter of a hole
    tolerance: str  # general tolerance on drawings
    source: str


PROCESSES = {
    process.name: process
    for process in (
        Process("laser cutting", 1e-3, 1.0, 1e-3, 1.0, "ISO 9013-1", "rule of cutting shops: not below the thickness"),
        Process("milling", 1e-3, 0.0, 1e-3, 0.1, "ISO 2768-m", "rule of machining shops: holes to 10 diameters deep"),
        Process("turning", 0.8e-3, 0.0, 1e-3, 0.0, "ISO 2768-m", "rule of machining shops: 0.8 mm does not chatter"),
        Process("bending", 1e-3, 1.0, 1e-3, 1.0, "ISO 2768-c", "rule of cutting shops, as laser cutting"),
        Process("printing", 1.2e-3, 0.0, 2e-3, 0.0, "ISO 2768-c", "three lines of a 0.4 mm nozzle"),
    )
}
"""Known processes by name; printing is that of molten filament."""

BEND_SHARES = {  # min inner radius of a bend of 90 deg over the thickness, with the source
    "aluminium": (4.5, "EN 485-2: 6082 T6 up to 6 mm"),
    "aluminium-sheet": (1.5, "EN 485-2: 5754 H111 up to 6 mm"),
    "stainless-steel": (1.0, "rule of bending shops"),
    "steel": (1.0, "EN 10025-2: S235JR up to 6 mm"),
}


def process(name: str) -> Process:
    """Return a known process; raise DesignError for an unknown one, with the list of the known."""
    if name not in PROCESSES:
        raise DesignError(f"unknown process {name!r}", where="process", right=f"known are {', '.join(PROCESSES)}")
    return PROCESSES[name]


def smallest_wall(name: str, thickness: float = 0.0) -> float:
    """Return the thinnest wall of a process in a sheet of a thickness (m), m."""
    limits = process(name)
    return max(limits.min_wall, limits.wall_share * thickness)


def smallest_hole(name: str, thickness: float = 0.0) -> float:
    """Return the smallest hole of a process in a sheet of a thickness (m), m."""
    limits = process(name)
    return max(limits.min_hole, limits.hole_share * thickness)


def smallest_bend(material_name: str, thickness: float) -> float:
    """Return the smallest inner radius to which a sheet of a thickness (m) bends by 90 deg, m.

    Raises:
        DesignError: the material is unknown or not bent cold.
    """
    if material_name not in BEND_SHARES:
        right = f"bend {', '.join(BEND_SHARES)}"
        raise DesignError(f"{material(material_name).name} is not bent", where="bending", right=right)
    return BEND_SHARES[material_name][0] * thickness


def check_wall(name: str, wall: float, where: str, thickness: float = 0.0) -> Finding | None:
    """Return an error if a wall is thinner than its process can make, else None.

    Args:
        name: process.
        wall: distance of two edges, m.
        where: part and place, for the message.
        thickness: of the sheet, m; 0 for a part that is none.
    """
    return _below("wall", wall, smallest_wall(name, thickness), where, name)


def check_hole(name: str, diameter: float, where: str, thickness: float = 0.0) -> Finding | None:
    """Return an error if a hole is smaller than its process can make, else None.

    Args:
        name: process.
        diameter: of the hole, m.
        where: part and place, for the message.
        thickness: of the sheet, m; 0 for a part that is none.
    """
    return _below("hole", diameter, smallest_hole(name, thickness), where, name)


def check_bend(material_name: str, radius: float, where: str, thickness: float) -> Finding | None:
    """Return an error if a sheet is bent to a smaller inner radius than its material bears, else None.

    Args:
        material_name: material of the sheet.
        radius: inner, m.
        where: part and place, for the message.
        thickness: of the sheet, m.
    """
    return _below("bend", radius, smallest_bend(material_name, thickness), where, f"bending of {material_name}")


SIZE_TOLERANCE = 1e-9  # below a limit, m


def _below(rule: str, size: float, limit: float, where: str, process_name: str) -> Finding | None:
    """Return an error if a size (m) is below the limit (m) of a process, else None.

    Args:
        rule: wall, hole or bend.
        size: m.
        limit: m.
        where: part and place.
        process_name: for the message.
    """
    if size >= limit - SIZE_TOLERANCE:
        return None
    what = f"a {rule} of {size * 1e3:.3g} mm"
    return Finding("error", rule, where, what, f"{process_name} needs {limit * 1e3:.3g} mm at least")
