"""Kind of friction: the torque at which an output shaft slips in its brake, bearings and seals."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import nan
from typing import Any

from layflat.errors import KindError
from layflat.jit import law
from layflat.kind_checks import MisfitError, check_number, described, naming_law, tolerating_arithmetic
from layflat.kinds import REQUIRED, Kind, KindPart
from layflat.lanes import select

Law = Callable[..., Any]

TRIED = [(brake, speed, pull) for brake in (0.0, 1.0) for speed in (0.0, 1e-3, 0.1, 1.0, 10.0) for pull in (0.0, 10.0)]
"""Brake torques (N m), speeds (rad/s) and pulls (N m) with which a law from outside is tried."""


class FrictionPart(KindPart):
    """Description of friction: its kind alone; the brake's torque stands with the brake."""


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

    def __post_init__(self) -> None:
        """Refuse `plain` that are no parameters of the kind."""
        super().__post_init__()
        if self.plain is not None and type(self.plain) not in self.parameter_types:
            what = f"plain of kind {self.name!r} is {described(self.plain)}, not its parameters"
            raise KindError(what, where=type(self).__name__, right=f"give a {self.parameter_types[0].__name__}")

    def guarded(self) -> "FrictionKind":
        """Return the kind with a level that is not a number where it would be negative."""
        return replace(self, level=_not_negative(self.level))

    def try_laws(self, parameters: Any, *described: Any) -> None:  # noqa: ARG002
        """Make sure that the level is a number and not negative; raise KindError if it is not."""
        with tolerating_arithmetic(self.level), naming_law(f"friction {self.name!r}", "level", self.level):
            for brake, speed, pull in TRIED:
                level = self.level(parameters, brake, speed, pull)
                what = f"the torque at a brake of {brake:g} N m, {speed:g} rad/s and a pull of {pull:g} N m"
                check_number(level, what)
                if level < 0.0:
                    raise MisfitError(f"{what} is {level:g} N m, which would drive the joint")


def _not_negative(level_of: Law) -> Law:
    @law
    def level(friction, brake, speed, pull):
        found = level_of(friction, brake, speed, pull)
        return select(found < 0.0, nan, found)

    return level
