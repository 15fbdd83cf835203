"""Frames of an assembly's joints and links, and the parts that move with each."""

from __future__ import annotations

from typing import TYPE_CHECKING

from layflat.bridge.pieces import rigid_arm
from layflat.lazy import numpy as np
from layflat.solids.joint import joint_components
from layflat.solids.shapes import PartPlace, turn_about_z
from layflat.solids.sizes import MM

if TYPE_CHECKING:
    from collections.abc import Sequence

    from layflat.solids.assembly import Assembly
    from layflat.solids.component import Component


def belongs_to_link(component: Component) -> bool:
    """Return whether a component belongs to the link that its joint turns, not to the joint."""
    return "link" in component.tags


def belongs_to_joint(component: Component) -> bool:
    """Return whether a component belongs to the joint as it is bought or weighed: neither link nor foot."""
    return not belongs_to_link(component) and "foot" not in component.tags


def inverse(at: PartPlace) -> PartPlace:
    """Return the place of the outer frame in the frame that has a place."""
    return PartPlace(at.axes.T, -at.axes.T @ at.origin)


def link_places(assembly: Assembly, angles: Sequence[float]) -> list[PartPlace]:
    """Return the frames of base and links, in that of the base, with the joints at angles from mid-stroke, rad; mm."""
    poses = rigid_arm(assembly.machine).poses(angles)
    links = [PartPlace(axes, MM * origin) for axes, origin in poses[: len(assembly.machine.joints)]]
    return [PartPlace(np.eye(3), np.zeros(3)), *links]


def joint_place(assembly: Assembly, name: str, component: Component | None = None) -> PartPlace:
    """Return the place of a joint's own frame in that of the base, at the assembly's angles.

    Args:
        assembly: the assembly.
        name: of the joint.
        component: one of its body in its own frame; default: the first.
    """
    component = component or joint_components(assembly.sizes[name])[0]
    placed = next(one for one in assembly.components if one.joint == name and one.name == component.name)
    return inverse(component.places[0]).then(placed.places[0])


def joint_parts(assembly: Assembly, name: str, angle: float) -> list[Component]:
    """Return the components of a joint and of the link that it turns, in the joint's frame, with the joint at an angle.

    Args:
        assembly: the assembly.
        name: of the joint.
        angle: of its output from mid-stroke, rad.
    """
    sizes = assembly.sizes[name]
    before = assembly.angles[list(assembly.machine.joints).index(name)]
    turned = turn_about_z(angle - before, (0.0, sizes.axis))
    own = joint_components(sizes, angle)
    into = inverse(joint_place(assembly, name, own[0]))
    names = {one.name for one in own}
    added = [one.moved(into) for one in assembly.components if one.joint == name and one.name not in names]
    return own + [one if one.group == "body" else one.moved(turned) for one in added]
