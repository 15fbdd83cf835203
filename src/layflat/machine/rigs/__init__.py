"""Benches as people describe them: a file says at its top what `kind` of bench it is."""

from layflat.machine.rigs.loader import KINDS, load_rig, rig_names
from layflat.machine.rigs.regulated import RegulatedRig

__all__ = ["KINDS", "RegulatedRig", "load_rig", "rig_names"]
