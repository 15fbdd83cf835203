"""Benches as people describe them: a file says at its top what `kind` of bench it is."""

from layflat.machine.rigs.loader import KINDS, build_rig, load_rig, rig_names
from layflat.machine.rigs.regulated import RegulatedRig
from layflat.machine.rigs.vessel import VesselRig

__all__ = ["KINDS", "RegulatedRig", "VesselRig", "build_rig", "load_rig", "rig_names"]
