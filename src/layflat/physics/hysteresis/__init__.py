"""Losses inside hose and strap: table.py has the kinds that are built in, docs/kinds.md shows how to add one."""

from layflat.physics.hysteresis.kind import HysteresisKind, LossesPart
from layflat.physics.hysteresis.parallel import ParallelPart
from layflat.physics.hysteresis.table import HYSTERESIS, at_rest, loaded, stored, torques, turned

__all__ = [
    "HYSTERESIS",
    "HysteresisKind",
    "LossesPart",
    "ParallelPart",
    "at_rest",
    "loaded",
    "stored",
    "torques",
    "turned",
]
