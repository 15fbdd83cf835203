"""One arm through time."""

from layflat.physics.step import STEP
from layflat.sim.run import rollout
from layflat.sim.scenario import Scenario

__all__ = ["STEP", "Scenario", "rollout"]
