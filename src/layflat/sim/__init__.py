"""One arm through time."""

from layflat.motion.scenario import Scenario
from layflat.physics.step import STEP
from layflat.sim.run import rollout

__all__ = ["STEP", "Scenario", "rollout"]
