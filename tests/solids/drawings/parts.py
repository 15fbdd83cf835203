"""Components that drawings are tested with: those of a joint, and single parts."""

from functools import cache

from layflat.machine import load
from layflat.solids.component import Component, Making
from layflat.solids.joint import joint_components, joint_sizes
from layflat.solids.shapes import Shape, place


@cache
def joint_parts(name: str = "small") -> tuple[Component, ...]:
    """Return the components of a joint of the paper's arm."""
    return tuple(joint_components(joint_sizes(load("paper-arm"), name)))


def made_parts(name: str = "small") -> list[Component]:
    """Return the components of a joint that are made."""
    return [one for one in joint_parts(name) if not one.bought]


def component(shape: Shape, making: Making = "laser cutting", material: str = "aluminium", size: str = "") -> Component:
    """Return a component of a shape."""
    return Component("part", "body", shape, material, making, (place(),), "plate 5", size=size)
