"""Work of the studio that takes longer than its event loop may be held up, called in a process beside it."""

from collections import OrderedDict
from pathlib import Path

from layflat.design.findings import Finding
from layflat.errors import LayflatError
from layflat.machine.model import Machine
from layflat.pages.studio.design import Design
from layflat.pages.studio.opened import open_description
from layflat.pages.studio.results import Designer, Figures, drawing
from layflat.pages.studio.saving import save, stale

LIMIT = 60.0  # time of one call, s
MAX_DESIGNERS = 16  # designs whose joints are remembered
_designers: OrderedDict[tuple[int, bool], Designer] = OrderedDict()


def open_design(given: str) -> Design:
    """Return the design of a built-in machine or a file, with its values found; errors are those of `load`."""
    design = Design(open_description(given))
    _ = design.fields
    return design


def find_figures(tab: int, kept: bool, machine: Machine, joint: str) -> Figures:
    """Return the statics of a joint.

    Args:
        tab: whose design it is: joints that have not changed since are not designed anew.
        kept: whether it is the design that the tab has kept as A.
        machine: as it is designed.
        joint: that is shown.
    """
    designer = _designers.setdefault((tab, kept), Designer())
    _designers.move_to_end((tab, kept))
    while len(_designers) > MAX_DESIGNERS:
        _designers.popitem(last=False)
    found = designer.figures(machine, joint)
    _ = found.quantities, found.torque, found.roller_torque  # found here, not where they are shown
    return found


def find_drawing(figures: Figures, kept: Figures | None, layout: bool) -> str:
    """Return the drawing of a joint as SVG; empty where there is none.

    Args:
        figures: of the joint.
        kept: of the one that is kept as A, whose cam is drawn with chain lines.
        layout: the whole layout in place of the cam.
    """
    return drawing(figures, kept, layout=layout)


def find_stale(design: Design) -> list[Finding]:
    """Return values that were given for other sizes than the design has; none where that can't be found out."""
    try:
        return stale(design)
    except LayflatError:  # what it extends is missing or broken by now, which is said elsewhere
        return []


def write_design(design: Design, path: Path) -> Design:
    """Write a design as a description, and return it as it knows itself afterwards; errors are those of `save`."""
    save(design, path)
    return design


def reread(design: Design) -> tuple[Design, list[str]]:
    """Return a design whose description was read again, and the paths of changes that were dropped; see `reload`."""
    dropped = design.reload()
    return design, dropped
