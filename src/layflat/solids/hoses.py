"""Parts that move between frame and output: hoses with their inlets, hinges, shells and straps."""

from __future__ import annotations

from dataclasses import replace
from math import ceil, cos, pi, sin
from typing import TYPE_CHECKING

from layflat.lazy import numpy as np
from layflat.solids.blanks import strip_length
from layflat.solids.cams import CLAMP_SCREW, flat, opening
from layflat.solids.component import Component, axes_towards
from layflat.solids.hardware import socket_screw
from layflat.solids.inlets import choose_inlet, inlet, outer_inlet
from layflat.solids.output import clamp_places
from layflat.solids.places import clamp_heights, clamp_line
from layflat.solids.section import BAR_THICKNESS, STRIP_THICKNESS, WEBBING_THICKNESS
from layflat.solids.shapes import Drilled, Lofted, PartPlace, Prism, place, turn_about_z
from layflat.solids.sizes import MM
from layflat.solids.standard.screws import screw, screw_lengths

if TYPE_CHECKING:
    from layflat.solids.component import Group
    from layflat.solids.section import CrossSection
    from layflat.solids.sizes import JointSizes

MIRROR_AXES = np.diag([-1.0, 1.0, -1.0])  # hose B and its parts, laid upside down, are the mirror image of hose A
FOLD_LENGTH = 10.0  # length that a hose's fold takes beyond its contact, mm
STRAP_ALLOWANCE = 15.0  # length of a strap to cut beyond its clamps, mm


def hose_components(sizes: JointSizes, section: CrossSection, angle: float) -> list[Component]:
    """Return hoses, hinges, shells and straps.

    Args:
        sizes: sizes of the joint.
        section: its cross-section.
        angle: of the output from mid-stroke, rad.
    """
    found = _side(section, "a", sizes.stroke / 2 + angle)
    if sizes.double:
        mirrored = PartPlace(MIRROR_AXES, np.zeros(3))
        found += [one.moved(mirrored) for one in _side(section, "b", sizes.stroke / 2 - angle)]
    return found


def _strips(sizes: JointSizes, side: str) -> list[tuple[float, float]]:
    """Return from where to where along z the strips of a strap lie, mm."""
    if side == "a":
        return [(-sizes.strap_width / 2, sizes.strap_width / 2)]
    low, high = sizes.cam_b
    return [(low, high), (-high, -low)]


def _side(section: CrossSection, side: str, turn: float) -> list[Component]:
    """Return what belongs to hose A or B, in the frame of hose A, once its cam has turned by an angle, rad."""
    sizes, letter = section.sizes, side.upper()
    hose: Group = "hose a" if side == "a" else "hose b"
    width, strips = sizes.hose_width, _strips(sizes, side)
    wrapped = sizes.radius * sizes.joint.hose.wrap
    folded = 2 if sizes.hose_layers == 4 else 1
    cut = folded * (wrapped + sizes.tail + (FOLD_LENGTH if folded == 2 else sizes.tail))
    path = section.strap_path(sizes.stroke / 2)
    strap_cut = float(np.hypot(*np.diff(path, axis=0).T).sum()) + STRAP_ALLOWANCE
    hinge_cut = ceil(strip_length(section.webbing(sizes.stroke / 2)))
    sections = tuple(tuple((x, y, z) for x, y, z in one) for one in section.hose(turn))
    mass = 2 * cut / MM * sizes.joint.hose.width * sizes.joint.hose.areal_mass
    strap = Prism(section.strap(turn), strips[0][1] - strips[0][0], drilled=_strap_holes(section, turn, strips[0]))
    hinge = Prism(section.webbing(turn), width, drilled=_clamp_holes(sizes, width / 2))
    layers = sizes.joint.strap.layers
    thickness = sizes.joint.strap.thickness * MM
    name = f"strip {strips[0][1] - strips[0][0]:g} x {thickness:g}"
    return [
        Component(f"hose {letter}", hose, Lofted(sections, _clamp_holes(sizes, 0.0)), "hose", "cutting", (place(),),
                  f"layflat hose {width:g}", mass, size=f"{cut:.0f} mm long", tags=frozenset({"hose"})),
        Component(f"hinge of hose {letter}", hose, hinge, "webbing", "cutting",
                  (place(z=-width / 2),), f"webbing {width:g} x 1", size=f"{hinge_cut} mm long",
                  tags=frozenset({"hinge"})),
        *(() if choose_inlet(sizes).outside else (inlet(sizes, hose),)),
        *_shell(section, side, turn),
        Component(f"strap of hose {letter}", hose, strap, "steel-strip", "cutting",
                  tuple(place(z=low) for low, _ in strips), f"{name}, {layers} layers",
                  size=f"{strap_cut:.1f} mm long", tags=frozenset({"strap"})),
    ]  # fmt: skip


def _clamp_holes(sizes: JointSizes, middle: float) -> tuple[Drilled, ...]:
    """Return the holes for the screws of the clamp, in a part whose z = 0 lies below the middle by a distance, mm."""
    y = clamp_line(sizes)
    reach = 2 * (sizes.hose_thickness + WEBBING_THICKNESS)
    hole = sizes.screw.clearance_hole * MM
    return tuple(Drilled((-reach, y, z + middle), (1.0, 0.0, 0.0), hole, 2 * reach) for z in clamp_heights(sizes))


def _strap_holes(section: CrossSection, turn: float, strip: tuple[float, float]) -> tuple[Drilled, ...]:
    """Return the holes of a strap's strip for the screws of both clamps, after a turn."""
    sizes, (low, high) = section.sizes, strip
    hinge = (sizes.line.hinge[0] * MM, sizes.line.hinge[1] * MM)
    start, end = section.ramp
    (x, y), normal = flat(sizes)
    heading = float(np.arctan2(*(end - start)[::-1]))
    clamps = (
        (np.array([*(start + end) / 2, 0.0]), heading + pi / 2, turn_about_z(opening(sizes, turn), hinge)),
        (np.array([x, y, 0.0]), normal, turn_about_z(turn).then(place(0.0, sizes.axis))),
    )
    holes = []
    for middle, angle, moved in clamps:
        outward = moved.axes @ np.array([cos(angle), sin(angle), 0.0])
        point = moved.origin + moved.axes @ middle + 1.0 * outward
        for z in clamp_places(high - low):
            at = (float(point[0]), float(point[1]), z + (high - low) / 2)
            inward = (-float(outward[0]), -float(outward[1]), 0.0)
            holes.append(Drilled(at, inward, CLAMP_SCREW.clearance_hole * MM, 2.0))
    return tuple(holes)


def _shell(section: CrossSection, side: str, turn: float) -> list[Component]:
    """Return the shell with bar, clamp strips and screws of its strap, after a turn."""
    sizes, letter = section.sizes, side.upper()
    group: Group = "shell a" if side == "a" else "shell b"
    width, strips = sizes.hose_width, _strips(sizes, side)
    hinge = (sizes.line.hinge[0] * MM, sizes.line.hinge[1] * MM)
    moved = turn_about_z(opening(sizes, turn), hinge)
    start, end = section.ramp
    along = (end - start) / float(np.hypot(*(end - start)))
    outward = np.array([-along[1], along[0], 0.0])
    middle = np.array([*(start + end) / 2, 0.0])
    at = [z + (low + high) / 2 for low, high in strips for z in clamp_places(high - low)]
    hole, tapping = CLAMP_SCREW.clearance_hole * MM, CLAMP_SCREW.tapping_hole * MM
    inward = (-outward[0], -outward[1], 0.0)
    shell = Prism(section.shell(), width, drilled=tuple(
        Drilled(_surface(middle, z + width / 2, outward, 0.5), inward, hole, sizes.shell + 1.0)
        for z in at))  # fmt: skip
    outside = choose_inlet(sizes).outside
    if outside:
        fitting, through = outer_inlet(sizes, section, group)
        shell = replace(shell, drilled=(*shell.drilled, through))
    bar = Prism(section.bar(), width, drilled=tuple(
        Drilled(_surface(middle, z + width / 2, outward, -sizes.shell + 0.2), inward, tapping, BAR_THICKNESS + 0.4,
                CLAMP_SCREW.name)
        for z in at))  # fmt: skip
    head = sizes.strap_thickness + STRIP_THICKNESS + 0.05
    strip_width = strips[0][1] - strips[0][0]
    clamp = Prism(section.clamp_strip(), strip_width, drilled=tuple(
        Drilled(_surface(middle, z + strip_width / 2, outward, head + 0.5), inward, hole, STRIP_THICKNESS + 1.0)
        for z in clamp_places(strip_width)))  # fmt: skip
    one = screw(CLAMP_SCREW.name, _screw_length(head + sizes.shell + BAR_THICKNESS))
    heads = tuple(PartPlace(axes_towards(*outward), np.array(_surface(middle, z, outward, head))) for z in at)
    across = place(z=-width / 2)
    return [
        one_.moved(moved)
        for one_ in (
            Component(f"shell {letter}", group, shell, "aluminium-sheet", "bending", (across,),
                      f"sheet {sizes.shell:g}", tags=frozenset({"shell"})),
            Component(f"bar of shell {letter}", group, bar, "aluminium", "milling", (across,),
                      f"flat bar {BAR_THICKNESS:g}"),
            Component(f"strap clamp on shell {letter}", group, clamp, "stainless-steel", "laser cutting",
                      tuple(place(z=low) for low, _ in strips), f"sheet {STRIP_THICKNESS:g}"),
            socket_screw(f"screw of the strap clamp on shell {letter}", group, one, heads),
            *((fitting,) if outside else ()),
        )
    ]  # fmt: skip


def _surface(middle: np.ndarray, z: float, outward: np.ndarray, distance: float) -> tuple[float, float, float]:
    """Return a point at a distance (mm) from the ramp's face, at z."""
    x, y, _ = middle + distance * outward
    return float(x), float(y), z


def _screw_length(depth: float) -> float:
    """Return the longest preferred length (m) of a clamp's screw that ends within a depth, mm."""
    lengths = [length for length in screw_lengths(CLAMP_SCREW.name) if length * MM <= depth + 0.01]
    return lengths[-1] if lengths else screw_lengths(CLAMP_SCREW.name)[0]
