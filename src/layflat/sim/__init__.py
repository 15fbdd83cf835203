"""Simulation of one arm over time."""

from typing import TYPE_CHECKING

from layflat.lazy import lazy_getattr
from layflat.motion.scenario import Scenario
from layflat.physics.step import STEP
from layflat.sim.run import rollout
from layflat.sim.saving import save

if TYPE_CHECKING:
    from layflat.sim.dataset import open_run
    from layflat.sim.results import Metrics, Run

__all__ = ["STEP", "Metrics", "Run", "Scenario", "open_run", "rollout", "save"]

__getattr__ = lazy_getattr(
    __name__,
    {
        "Metrics": "layflat.sim.results:Metrics",
        "Run": "layflat.sim.results:Run",
        "open_run": "layflat.sim.dataset:open_run",
    },
)
