"""Arms from files of robots: URDF and MJCF."""

from layflat.bridge.robots.arm import ImportedArm, import_arm

__all__ = ["ImportedArm", "import_arm"]
