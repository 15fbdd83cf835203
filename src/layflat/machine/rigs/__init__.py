"""Benches as people describe them: a file says at its top what `kind` of bench it is."""

from layflat.machine.rigs.friction import FrictionRig
from layflat.machine.rigs.loader import KINDS, load_rig, rig_names

__all__ = ["KINDS", "FrictionRig", "load_rig", "rig_names"]
