"""Stresses of a built joint by the hand formulas of `strength.py`, with its sizes and greatest loads."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from layflat.design.strength import SHAFT_YIELD
from layflat.lazy import numpy as np
from layflat.solids import strength
from layflat.solids.brake import PAD_SHARE, disc_radius, pad_force, stud_places
from layflat.solids.frame import end_plate
from layflat.solids.places import bar_place, frame_places
from layflat.solids.section import WEBBING_THICKNESS
from layflat.solids.shapes import Prism
from layflat.solids.sizes import MM
from layflat.solids.standard.materials import MATERIALS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from layflat.solids.component import Component
    from layflat.solids.sizes import JointSizes
    from layflat.solids.strength import Strength


def joint_stresses(sizes: JointSizes, parts: Sequence[Component], label: str) -> list[Strength]:
    """Return the stresses of a joint's parts beside their limits, in the order in which the load goes through them.

    Args:
        sizes: sizes of the joint.
        parts: its components.
        label: of the joint, for messages.
    """
    found = [_hinge(sizes), *_clamp(sizes), _end_plate(sizes), *_shaft(sizes), *_brake_beam(sizes, parts)]
    return [replace(one, where=f"{label}: {one.where}") for one in found]


def _hinge(sizes: JointSizes) -> Strength:
    """Return the stress of a hinge: it bears the half of the hose's force on its shell that the strap does not."""
    limit = MATERIALS["webbing"].yield_stress
    return strength.hinge_webbing(sizes.pull, sizes.hose_width / MM, WEBBING_THICKNESS / MM, limit)


def _clamp(sizes: JointSizes) -> list[Strength]:
    """Return the stresses of the bars that clamp the hoses, and of their screws."""
    pressure, width, depth = sizes.design.pressure, sizes.hose_width / MM, bar_place(sizes)[2] / MM
    pitch = width / (sizes.clamp_screws - 1)
    pull = strength.hose_pull(pressure, width)
    force = strength.clamp_force(pressure * width * depth, pull)
    return [
        strength.clamp_bar(pressure, depth, pitch, depth, sizes.clamp_bar / MM, MATERIALS["aluminium"].yield_stress),
        strength.clamp_screws(
            force, sizes.clamp_screws, sizes.screw.stress_area, MATERIALS["screw-steel"].yield_stress
        ),
    ]


def _end_plate(sizes: JointSizes) -> Strength:
    """Return the stress of an end plate across its bush: half of a strap's pull, on a lever from the frame's screws."""
    points = end_plate(sizes, upper=True).outline.points()
    start, end = points, np.roll(points, -1, axis=0)
    crossing = (start[:, 1] - sizes.axis) * (end[:, 1] - sizes.axis) < 0
    share = (sizes.axis - start[crossing, 1]) / (end[crossing, 1] - start[crossing, 1])
    x = start[crossing, 0] + share * (end[crossing, 0] - start[crossing, 0])
    lever = sizes.axis - max(y for _, y in frame_places(sizes))
    return strength.end_plate(
        sizes.pull / 2,
        lever / MM,
        float(x.max() - x.min()) / MM,
        sizes.bush.outer,
        sizes.end_plate / MM,
        MATERIALS["aluminium"].yield_stress,
    )


def _shaft(sizes: JointSizes) -> list[Strength]:
    """Return the load of a bush and the stress of the shaft: the arm plates pass a strap's pull to it."""
    half, bearing = sizes.pull / 2, (sizes.top - sizes.end_plate / 2) / MM
    lever = bearing - sizes.arm_z[1] / MM
    loads = [(half, lever), (half, 2 * bearing - lever)]
    return [
        replace(
            strength.bearing_load(half, sizes.bush.allowed_load(sizes.end_plate / MM)),
            where="bush",
            formula="F/(d b) of allowed pressure",
            source="catalogues of polymer bushes",
        ),
        strength.shaft(loads, 2 * bearing, sizes.shaft / MM, sizes.joint.brake.torque, SHAFT_YIELD),
    ]


def _brake_beam(sizes: JointSizes, parts: Sequence[Component]) -> list[Strength]:
    """Return the stress of the beam that presses a brake's pad, between its studs."""
    span, width = 2 * stud_places(sizes)[1][0] / MM, 2 * PAD_SHARE * disc_radius(sizes) / MM
    found = []
    for one in parts:
        if one.name == "brake beam" and isinstance(one.shape, Prism):
            limit, height = MATERIALS[one.material].yield_stress, one.shape.height / MM
            # Half of the force on half of the span, as on a cantilever.
            beam = strength.calliper_arm(pad_force(sizes) / 2, span / 2, width, height, limit)
            found.append(replace(beam, where="brake: beam"))
    return found
