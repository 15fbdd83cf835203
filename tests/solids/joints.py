"""Joints whose parts tests look at, made once a process."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING, Any

from layflat.machine import load
from layflat.solids.joint import joint_components, joint_sizes

if TYPE_CHECKING:
    from collections.abc import Callable

    from layflat.solids.component import Component
    from layflat.solids.shapes import Shape
    from layflat.solids.sizes import JointSizes


@cache
def sizes_of(machine: str, joint: str) -> JointSizes:
    return joint_sizes(load(machine), joint)


def maker_of_solids() -> Callable[[Component], Any]:
    """Return a function that makes the solid of each shape once."""
    from layflat.solids import cad

    @cache
    def make(shape: Shape) -> Any:
        return cad.solid(shape)

    return lambda component: make(component.shape)


@cache
def components_of(machine: str, joint: str, angle: float = 0.0, name: str = "") -> tuple[Component, ...]:
    """Return the components of a joint, under a name of its own if one is given."""
    return tuple(replace(one, joint=name or joint) for one in joint_components(sizes_of(machine, joint), angle))


def mass_by_name(one: Component) -> float:
    """Return a mass that needs no solid: as bought, or one by the length of the name."""
    return one.bought_mass if one.bought_mass is not None else 0.0123456 * len(one.name)
