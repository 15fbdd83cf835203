"""A spring on a joint's shaft: it brings back a joint that has a single hose, or bears part of what an arm weighs.

| symbol | meaning | unit |
|---|---|---|
| q | joint angle from the middle of the stroke | rad |
"""

from typing import NamedTuple

from layflat.jit import by_kind, law
from layflat.physics.arms.kind import NONE


class NoSpring(NamedTuple):
    """A joint without one."""


class Spring(NamedTuple):
    """Torque at q = 0 (N m; positive turns the joint forward), and stiffness (N m/rad)."""

    torque: float
    stiffness: float


@law
def _nothing(spring, q):  # noqa: ARG001
    return NONE


@law
def _torque(spring, q):
    return spring.torque - spring.stiffness * q


spring_torque = by_kind({NoSpring: _nothing, Spring: _torque})
"""Torque of a spring on the joint, N m: `spring_torque(spring, q)`."""


def spring_energy(spring: Spring, q: float) -> float:
    """Return the energy that is stored in a spring beyond that at q = 0, J."""
    return q * (0.5 * spring.stiffness * q - spring.torque)
