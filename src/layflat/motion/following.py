"""How a machine's control law wants motions to be asked for."""

from typing import NamedTuple

from layflat.machine import Machine
from layflat.motion.limits import RESERVE
from layflat.motion.trajectory import States, at_rest
from layflat.motion.travel import LEAD, SHARES, Travel


class Following(NamedTuple):
    """How motions are asked for."""

    lead: float  # by which a demand runs ahead at the motion's speed, s: what goes by angles alone lags behind
    shares: tuple[float, float, float]  # of speed, acceleration and jerk that motions are planned with

    def demands(self, travel: Travel, cycle: float) -> States:
        """Return what to ask for in each control cycle (s) of a motion: with its rates, or else ahead of it."""
        return travel.rows(cycle) if self.lead == 0.0 else at_rest(travel.demand(cycle, lead=self.lead))

    def demand(self, motion: States) -> States:
        """Return what to ask for so that joints follow a motion that goes on, likewise."""
        return motion if self.lead == 0.0 else at_rest(motion.angles + self.lead * motion.velocities)


BY_ANGLES, BY_RATES = Following(LEAD, SHARES), Following(0.0, (1.0 - RESERVE,) * 3)


def following(machine: Machine) -> Following:
    """Return how to ask the machine for motions."""
    return BY_RATES if machine.control_law.plans else BY_ANGLES
