"""Machines: description files, validated objects, and the parameters of the laws."""

from typing import TYPE_CHECKING

from layflat.description.change import changed
from layflat.machine.loader import load, names
from layflat.machine.model import Machine, build
from layflat.machine.parts import Joint
from layflat.plot.drawing import draw

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Joint", "Machine", "build", "changed", "load", "names"]


@draw.register(Machine)
def _draw_machine(machine: Machine) -> "Figure":
    """Draw a machine, as `draw` and `Machine.plot` do."""
    from layflat.machine.picture import draw_machine  # noqa: PLC0415  # the laws of arms, and numpy

    return draw_machine(machine)
