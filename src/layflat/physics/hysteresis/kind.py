"""What a kind of hysteresis has to offer: torques that hose and strap lose, from how the joint turns."""

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
from layflat.kinds import REQUIRED, Kind, KindPart

Law = Callable[..., Any]

TRIED = ((0.01, 1e5, 1e-3), (-0.02, 1e5, 1e-3), (0.0, 0.0, 1e-3), (0.01, 1e5, inf))
"""Turns (rad), gauge pressures (Pa) and times (s) with which laws from outside are tried."""


class LossesPart(KindPart):
    """What all descriptions of losses say: the pressure at which `loss_share` of hose and strap was measured."""

    reference_pressure_gauge: u.PositivePressure
    pressure_free: u.Share = Field(
        description="part of the loss at reference pressure that does not grow with pressure"
    )
    damping_time: u.TimeOrZero = Field(
        default=0.0,
        description="of a Kelvin-Voigt element beside the law: torque per velocity over the loss of a slow motion",
    )


def over_pressure(described: LossesPart, torque: float) -> tuple[float, float]:
    """Split a torque at the reference pressure (N m) into what stands without pressure, and its growth (N m/Pa)."""
    free = described.pressure_free
    return free * torque, (1.0 - free) * torque / described.reference_pressure_gauge


@dataclass(frozen=True, kw_only=True)
class HysteresisKind(Kind):
    """A law of losses, of one hose with its strap.

    `parameters(described, limit)` has the torque that the losses oppose either way at the reference pressure in a large
    slow motion, N m. All zeros have to be parameters of a hose without losses.
    """

    LAWS = ("at_rest", "turned", "torques", "stored", "loaded")

    at_rest: Law = REQUIRED  # `at_rest(loss)` yields the state of a hose that never moved: a named tuple of floats
    turned: Law = REQUIRED
    """`turned(loss, state, turn, p_g, h)` yields the state after a turn (rad) in h seconds at gauge pressure p_g (Pa).
    In a slow sweep h is infinite."""
    torques: Law = REQUIRED
    """`torques(loss, state)` yields the torques against the motion, N m, as a tuple that is summed in order."""
    stored: Law = REQUIRED
    """`stored(loss, state)` yields what the losses give back, J; all else that was put in is heat."""
    loaded: Law = REQUIRED
    """`loaded(loss, p_g, share)` yields a state in which the losses carry a share (-1 to 1) of what they can."""

    def try_laws(self, parameters: Any, *_: Any) -> None:
        """Turn a hose to and fro, and check what the laws return; raise KindError if they return something else."""
        with tolerating_arithmetic(self.turned):
            with naming_law(f"hysteresis {self.name!r}", "at_rest", self.at_rest):
                state = self.at_rest(parameters)
                check_nested(state, "the state")
            for turn, p_g, h in TRIED:
                with naming_law(f"hysteresis {self.name!r}", "turned", self.turned):
                    turned = self.turned(parameters, state, turn, p_g, h)
                    check_alike(turned, state, "the state")
                state = turned
                self._try_torques(parameters, state)
            with naming_law(f"hysteresis {self.name!r}", "loaded", self.loaded):
                check_alike(self.loaded(parameters, 1e5, 0.5), state, "the state")

    def _try_torques(self, parameters: Any, state: Any) -> None:
        with naming_law(f"hysteresis {self.name!r}", "torques", self.torques):
            torques = self.torques(parameters, state)
            if type(torques) is not tuple:
                raise MisfitError(f"it is {described(torques)}, not a tuple of torques")
            check_nested(torques, "the tuple")
        with naming_law(f"hysteresis {self.name!r}", "stored", self.stored):
            check_number(self.stored(parameters, state), "the energy")
