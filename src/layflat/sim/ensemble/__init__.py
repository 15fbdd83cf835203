"""Many runs at once: `ensemble`. A reader's way: parallel.py, cases.py, kernel.py, watch.py, dataset.py."""

from layflat.sim.ensemble.parallel import ensemble

__all__ = ["ensemble"]
