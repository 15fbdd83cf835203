"""Simulation of many runs at once: `ensemble`. Read in this order: parallel.py, cases.py, kernel.py, watch.py."""

from layflat.sim.ensemble.parallel import ensemble

__all__ = ["ensemble"]
