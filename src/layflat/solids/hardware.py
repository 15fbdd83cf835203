"""Shapes of standard parts, simplified: screws without threads, springs as sleeves; lengths in mm.

A screw's shank has the diameter of its tapping hole, so that it overlaps no part that it is screwed into.
"""

from __future__ import annotations

from math import sqrt
from typing import TYPE_CHECKING

from layflat.solids.component import Component
from layflat.solids.loops import polygon
from layflat.solids.shapes import Hole, Prism, Turned
from layflat.solids.sizes import MM
from layflat.solids.standard.screws import Screw, nut, threaded_rod, washer

if TYPE_CHECKING:
    from layflat.solids.component import Group
    from layflat.solids.loops import Loop
    from layflat.solids.shapes import PartPlace
    from layflat.solids.standard.threads import Thread


def stepped(*steps: tuple[float, float, float], bore: float = 0.0) -> Loop:
    """Return the outline of a turned part from steps of radius, lower and upper end (mm, ascending), with a bore.

    Args:
        steps: radius, lower end and upper end of each step, mm.
        bore: radius of the bore, mm.
    """
    outer = [(radius, z) for radius, low, high in steps for z in (low, high)]
    return polygon([(bore, steps[0][1]), *outer, (bore, steps[-1][2])])


def sleeve(outer: float, bore: float, length: float) -> Turned:
    """Return a tube along z from 0 on.

    Args:
        outer: outer diameter, mm.
        bore: inner diameter, mm.
        length: mm.
    """
    return Turned(stepped((outer / 2, 0.0, length), bore=bore / 2))


def rod(diameter: float, length: float) -> Turned:
    """Return a round bar along z from 0 on, mm."""
    return Turned(stepped((diameter / 2, 0.0, length)))


def socket_screw(name: str, group: Group, screw: Screw, places: tuple[PartPlace, ...]) -> Component:
    """Return socket screws; the seat of the head is at z = 0, the head above it.

    Args:
        name: of the parts in the list.
        group: with which they move.
        screw: the screw.
        places: where they are.
    """
    size = screw.thread
    shank, head = size.tapping_hole * MM / 2 - 0.01, size.head_diameter * MM / 2
    outline = stepped((shank, -screw.length * MM, 0.0), (head, 0.0, size.head_height * MM))
    return Component(name, group, Turned(outline), "screw-steel", "bought", places, screw.designation, screw.mass)


def hexagon_nut(
    name: str, group: Group, size: Thread, places: tuple[PartPlace, ...], *, thin: bool = False
) -> Component:
    """Return nuts that stand on z = 0.

    Args:
        name: of the parts in the list.
        group: with which they move.
        size: their thread.
        places: where they are.
        thin: whether they are thin ones.
    """
    one = nut(size.name, thin=thin)
    half = size.nut_flats * MM / 2
    corner = 2 * half / sqrt(3)
    outline = polygon([(corner, 0), (corner / 2, half), (-corner / 2, half), (-corner, 0), (-corner / 2, -half),
                       (corner / 2, -half)])  # fmt: skip
    shape = Prism(outline, one.height * MM, (Hole((0.0, 0.0), size.tapping_hole * MM),))
    return Component(name, group, shape, "screw-steel", "bought", places, one.designation, one.mass)


def plain_washer(name: str, group: Group, size: Thread, places: tuple[PartPlace, ...]) -> Component:
    """Return washers that lie on z = 0.

    Args:
        name: of the parts in the list.
        group: with which they move.
        size: their thread.
        places: where they are.
    """
    one = washer(size.name)
    shape = sleeve(size.washer_diameter * MM, size.washer_hole * MM, size.washer_thickness * MM)
    return Component(name, group, shape, "screw-steel", "bought", places, one.designation, one.mass)


def stud(name: str, group: Group, size: Thread, length: float, places: tuple[PartPlace, ...]) -> Component:
    """Return pieces of threaded rod along z from 0 on.

    Args:
        name: of the parts in the list.
        group: with which they move.
        size: their thread.
        length: mm.
        places: where they are.
    """
    one = threaded_rod(size.name, length / MM)
    shape = rod(size.tapping_hole * MM - 0.02, length)
    return Component(name, group, shape, "screw-steel", "bought", places, one.designation, one.mass)
