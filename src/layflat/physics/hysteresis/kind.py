"""Kind of hysteresis: laws of the torques that hose and strap lose, from the rotation of the joint."""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from typing import Any

from pydantic import Field

from layflat.description import units as u
from layflat.kind_checks import (
    MisfitError,
    check_alike,
    check_nested,
    check_number,
    described,
    naming_law,
    tolerating_arithmetic,
)
from layflat.kinds import REQUIRED_ENTRY, Kind, KindPart

Law = Callable[..., Any]

TRIAL_MOTIONS = ((0.01, 1e5, 1e-3), (-0.02, 1e5, 1e-3), (0.0, 0.0, 1e-3), (0.01, 1e5, inf))
"""Rotations (rad), gauge pressures (Pa) and times (s) with which a user's laws are tried."""


class LossesPart(KindPart):
    """Description of losses: fields that all kinds have, such as the pressure at which `loss_fraction` was measured."""

    reference_pressure_gauge: u.PositivePressure
    pressure_free: u.Share = Field(
        description="part of the loss at reference pressure that does not grow with pressure"
    )
    damping_time: u.TimeOrZero = Field(
        default=0.0,
        description="of a Kelvin-Voigt element beside the law: torque per velocity over the loss of a slow motion",
    )


def split_by_pressure(described: LossesPart, torque: float) -> tuple[float, float]:
    """Return the part of a torque (N m) at the reference pressure that needs no pressure, and its slope (N m/Pa).

    Other quantities, such as times, are split alike.
    """
    free = described.pressure_free
    return free * torque, (1.0 - free) * torque / described.reference_pressure_gauge


@dataclass(frozen=True, kw_only=True)
class HysteresisKind(Kind):
    """Kind of losses of one hose with its strap.

    `parameters(described, limit)` takes the limit: the torque against a large slow motion in either direction at the
    reference pressure, N m. All zeros have to be parameters of a hose without losses.
    """

    LAWS = ("at_rest", "turned", "torques", "stored", "loaded")

    at_rest: Law = (
        REQUIRED_ENTRY  # `at_rest(loss)` yields the state of a hose that never moved: a named tuple of floats
    )
    turned: Law = REQUIRED_ENTRY
    """`turned(loss, state, turn, p_g, h)` yields the state after a rotation (rad) in h seconds at gauge pressure p_g.
    In a slow sweep h is infinite."""
    torques: Law = REQUIRED_ENTRY
    """`torques(loss, state)` yields the torques against the motion, N m, as a tuple that is summed in order."""
    stored: Law = REQUIRED_ENTRY
    """`stored(loss, state)` yields the recoverable energy, J; the rest of the work is heat."""
    loaded: Law = REQUIRED_ENTRY
    """`loaded(loss, p_g, share)` yields a state in which the losses carry a fraction (-1 to 1) of their limit."""

    def try_laws(self, parameters: Any, *_: Any) -> None:
        """Call the laws for a rotation to and fro; raise KindError if a result has a wrong shape or value."""
        with tolerating_arithmetic(self.turned):
            with naming_law(f"hysteresis {self.name!r}", "at_rest", self.at_rest):
                state = self.at_rest(parameters)
                check_nested(state, "the state")
            for turn, p_g, h in TRIAL_MOTIONS:
                with naming_law(f"hysteresis {self.name!r}", "turned", self.turned):
                    turned = self.turned(parameters, state, turn, p_g, h)
                    check_alike(turned, state, "the state")
                state = turned
                self._try_torques(parameters, state)
            with naming_law(f"hysteresis {self.name!r}", "loaded", self.loaded):
                check_alike(self.loaded(parameters, 1e5, 0.5), state, "the state")

    def _try_torques(self, parameters: Any, state: Any) -> None:
        """Raise MisfitError unless the laws return a tuple of torques and a stored energy for a state."""
        with naming_law(f"hysteresis {self.name!r}", "torques", self.torques):
            torques = self.torques(parameters, state)
            if type(torques) is not tuple:
                raise MisfitError(f"it is {described(torques)}, not a tuple of torques")
            check_nested(torques, "the tuple")
        with naming_law(f"hysteresis {self.name!r}", "stored", self.stored):
            check_number(self.stored(parameters, state), "the energy")
