"""Benches as people describe them: a file says at its top what `kind` of bench it is."""

from layflat.machine.rigs.loader import KINDS, build_rig, load_rig, rig_names
from layflat.machine.rigs.vessel import VesselRig

__all__ = ["KINDS", "VesselRig", "build_rig", "load_rig", "rig_names"]
