"""Many arms that their caller steps: `Batch`."""

from layflat.sim.batch.batch import Batch
from layflat.sim.batch.state import BatchState

__all__ = ["Batch", "BatchState"]
