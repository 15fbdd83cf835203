"""What a kind of friction has to offer: the torque at which an output shaft slips in its brake, bearings and seals."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from layflat.kinds import REQUIRED, Kind, KindPart

Law = Callable[..., Any]


class FrictionPart(KindPart):
    """What all descriptions of friction say: nothing beside their kind; the brake's torque stands with the brake."""


@dataclass(frozen=True, kw_only=True)
class FrictionKind(Kind):
    """A law of the dry friction of an output shaft. What grows in proportion to velocity is `brake.viscous`.

    `parameters(described)` has what a file says.
    """

    LAWS = ("level",)

    level: Law = REQUIRED
    """`level(friction, brake, speed, pull)` yields the torque at which the shaft slips (N m, not negative), from that
    of its brake as the brake's signal has it (N m), its speed (rad/s; 0 while it stands still), and the torques of both
    hoses added up, with which the straps pull on the bearings (N m)."""
    constant: bool = False  # whether the level is the same at all speeds, so that a joint holds what it slides at
    plain: Any = None
    """Parameters with which it is Coulomb friction; where there are some, only some of a machine's joints need it."""
