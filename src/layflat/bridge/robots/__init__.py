"""Arms from files of robots: URDF and MJCF."""

from layflat.bridge.robots.arm import ChainEnds, ImportedArm, import_arm

__all__ = ["ChainEnds", "ImportedArm", "import_arm"]
