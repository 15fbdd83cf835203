"""Kind of friction: the torque at which an output shaft slips in its brake, bearings and seals."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import nan
from typing import Any

from layflat.errors import KindError
from layflat.jit import law
from layflat.kind_checks import MisfitError, check_number, described, naming_law, tolerating_arithmetic
from layflat.kinds import REQUIRED_ENTRY, Kind, KindPart
from layflat.lanes import select

Law = Callable[..., Any]

TRIAL_POINTS = [
    (brake, speed, pull) for brake in (0.0, 1.0) for speed in (0.0, 1e-3, 0.1, 1.0, 10.0) for pull in (0.0, 10.0)
]
"""Brake torques (N m), speeds (rad/s) and hose torques (N m) with which a user's law is tried."""


class FrictionPart(KindPart):
    """Description of friction: its kind alone; the brake's torque is described with the brake."""


@dataclass(frozen=True, kw_only=True)
class FrictionKind(Kind):
    """Kind of dry friction of an output shaft. Viscous friction is `brake.viscous`.

    `parameters(described)` takes the description.
    """

    LAWS = ("level",)

    level: Law = REQUIRED_ENTRY
    """`level(friction, brake, speed, pull)` yields the torque at which the shaft slips (N m, not negative), from the
    torque of its brake at the present brake signal (N m), its speed (rad/s; 0 at rest), and the sum of the torques of
    both hoses, which load the bearings through the straps (N m)."""
    constant: bool = False  # whether the level is the same at all speeds, rest included
    plain: Any = None
    """Parameters with which it is Coulomb friction; with them, only some of a machine's joints need this kind."""

    def __post_init__(self) -> None:
        """Raise KindError if `plain` are no parameters of the kind."""
        super().__post_init__()
        if self.plain is not None and type(self.plain) not in self.parameter_types:
            what = f"plain of kind {self.name!r} is {described(self.plain)}, not its parameters"
            raise KindError(what, where=type(self).__name__, right=f"give a {self.parameter_types[0].__name__}")

    def guarded(self) -> "FrictionKind":
        """Return the kind with a level that becomes nan where it would be negative."""
        return replace(self, level=_with_valid_torque(self.level))

    def try_laws(self, parameters: Any, *described: Any) -> None:  # noqa: ARG002
        """Call the law at `TRIAL_POINTS`; raise KindError if the level is no number or negative."""
        with tolerating_arithmetic(self.level), naming_law(f"friction {self.name!r}", "level", self.level):
            for brake, speed, pull in TRIAL_POINTS:
                level = self.level(parameters, brake, speed, pull)
                what = f"the torque at a brake of {brake:g} N m, {speed:g} rad/s and a pull of {pull:g} N m"
                check_number(level, what)
                if level < 0.0:
                    raise MisfitError(f"{what} is {level:g} N m, which would drive the joint")


def _with_valid_torque(level_of: Law) -> Law:
    """Return the law of slipping torque, with NaN in place of a negative torque."""

    @law
    def level(friction, brake, speed, pull):
        torque = level_of(friction, brake, speed, pull)
        return select(torque < 0.0, nan, torque)

    return level
