"""End stops: the collapsed hose is squeezed first, then the arm meets the mechanical stop.

| symbol | meaning | unit |
|---|---|---|
| q | joint angle from the middle of the stroke | rad |
| k_h, q_h | stiffness of the squeezed hose, and the angle at which squeezing begins | N m/rad, rad |
| k_s, q_s | stiffness of the mechanical stop, and its angle | N m/rad, rad |
| d_s | damping while the mechanical stop is touched | N m s/rad |
"""

from typing import NamedTuple

from layflat.jit import law
from layflat.lanes import select


class Stops(NamedTuple):
    """Parameters of the end stops on both sides (units as in the module's table)."""

    squeeze_angle: float
    squeeze_stiffness: float
    stop_angle: float
    stop_stiffness: float
    stop_damping: float


@law
def _past(q, limit):
    return max(q - limit, 0.0) + min(q + limit, 0.0)


@law
def stop_torque(stops, q):
    """Torque of the stops on the joint, N m."""
    return -stops.squeeze_stiffness * _past(q, stops.squeeze_angle) - stops.stop_stiffness * _past(q, stops.stop_angle)


@law
def stop_damping(stops, q):
    """Damping of the mechanical stop at q, N m s/rad."""
    return select(abs(q) > stops.stop_angle, stops.stop_damping, 0.0)


@law
def stop_energy(stops, q):
    """Energy stored in squeezed hose and stop, J."""
    squeezed, past = _past(q, stops.squeeze_angle), _past(q, stops.stop_angle)
    return 0.5 * (stops.squeeze_stiffness * squeezed * squeezed + stops.stop_stiffness * past * past)
