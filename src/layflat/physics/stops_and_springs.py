"""End stops and springs of a joint's shaft.

At an end the collapsed hose is squeezed first, then the arm meets the mechanical stop. A spring returns a joint that
has a single hose, or bears part of the weight of an arm.

| symbol | meaning | unit |
|---|---|---|
| q | joint angle from the middle of the stroke | rad |
| k_h, q_h | stiffness of the squeezed hose, and the angle at which squeezing begins | N m/rad, rad |
| k_s, q_s | stiffness of the mechanical stop, and its angle | N m/rad, rad |
| d_s | damping while the mechanical stop is touched | N m s/rad |
"""

from typing import NamedTuple

from layflat.jit import by_kind, law
from layflat.lanes import select
from layflat.physics.arms.kind import NO_TORQUE


class StopParameters(NamedTuple):
    """Parameters of the end stops on both sides (units as in the module's table)."""

    squeeze_angle: float  # q_h, rad
    squeeze_stiffness: float  # k_h, N m/rad
    stop_angle: float  # q_s, rad
    stop_stiffness: float  # k_s, N m/rad
    stop_damping: float  # d_s, N m s/rad


@law
def _overtravel(q, limit):
    return max(q - limit, 0.0) + min(q + limit, 0.0)


@law
def stop_torque(stops, q):
    """Return the torque of the stops on the joint at q, N m."""
    return -stops.squeeze_stiffness * _overtravel(q, stops.squeeze_angle) - stops.stop_stiffness * _overtravel(
        q, stops.stop_angle
    )


@law
def stop_damping(stops, q):
    """Return the damping of the mechanical stop at q, N m s/rad."""
    return select(abs(q) > stops.stop_angle, stops.stop_damping, 0.0)


@law
def stop_energy(stops, q):
    """Return the energy stored in squeezed hose and stop, J."""
    squeezed, past = _overtravel(q, stops.squeeze_angle), _overtravel(q, stops.stop_angle)
    return 0.5 * (stops.squeeze_stiffness * squeezed * squeezed + stops.stop_stiffness * past * past)


class NoSpring(NamedTuple):
    """Parameters of a joint without a spring."""


class SpringParameters(NamedTuple):
    """Parameters of a spring: torque at q = 0 (N m; positive turns the joint forward), and stiffness (N m/rad)."""

    torque: float  # at q = 0, N m
    stiffness: float  # N m/rad


@law
def _no_torque(spring, q):  # noqa: ARG001
    return NO_TORQUE


@law
def _torque(spring, q):
    return spring.torque - spring.stiffness * q


spring_torque = by_kind({NoSpring: _no_torque, SpringParameters: _torque})
"""Torque of a spring on the joint at q, N m: `spring_torque(spring, q)`."""


def spring_energy(spring: SpringParameters, q: float) -> float:
    """Return the energy of a spring at q relative to that at q = 0, J."""
    return q * (0.5 * spring.stiffness * q - spring.torque)
