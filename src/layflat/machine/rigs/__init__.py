"""Benches as people describe them: a file says at its top what `kind` of bench it is."""

from layflat.machine.rigs.friction import FrictionRig
from layflat.machine.rigs.loader import KINDS, Rig, build_rig, load_described, load_rig, rig_names, rig_tables
from layflat.machine.rigs.regulated import RegulatedRig
from layflat.machine.rigs.vessel import VesselRig

__all__ = [
    "KINDS",
    "FrictionRig",
    "RegulatedRig",
    "Rig",
    "VesselRig",
    "build_rig",
    "load_described",
    "load_rig",
    "rig_names",
    "rig_tables",
]
