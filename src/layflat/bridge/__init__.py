"""Our joints in MuJoCo, and our arms as its models."""

from layflat.bridge.arm import arm_spec, to_mjcf
from layflat.bridge.joints import PneumaticJoints
from layflat.bridge.plant import MujocoPlant
from layflat.bridge.urdf import to_urdf

__all__ = ["MujocoPlant", "PneumaticJoints", "arm_spec", "to_mjcf", "to_urdf"]
