"""One arm through time."""

from layflat.sim.run import STEP, rollout
from layflat.sim.scenario import Scenario

__all__ = ["STEP", "Scenario", "rollout"]
