"""Joints of hose in MuJoCo, and arms as MuJoCo models, MJCF and URDF."""

from layflat.bridge.arm import arm_spec, save_arm
from layflat.bridge.joints import PneumaticJoints
from layflat.bridge.mjcf import to_mjcf
from layflat.bridge.plant import MujocoPlant
from layflat.bridge.urdf import to_urdf

__all__ = ["MujocoPlant", "PneumaticJoints", "arm_spec", "save_arm", "to_mjcf", "to_urdf"]
