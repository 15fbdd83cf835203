"""Paths, trajectories, their limits, and demands over time for a machine's arm, from its description alone.

Names are loaded when they are first used.
"""

from typing import TYPE_CHECKING

from layflat.lazy import lazy_getattr

if TYPE_CHECKING:
    from layflat.motion.file import MotionDescription, read_motion
    from layflat.motion.plan import MotionPlan, plan_motion
    from layflat.motion.tip_angles import inverse_kinematics

__all__ = ["MotionDescription", "MotionPlan", "inverse_kinematics", "plan_motion", "read_motion"]

__getattr__ = lazy_getattr(
    __name__,
    {
        "MotionDescription": "layflat.motion.file:MotionDescription",
        "MotionPlan": "layflat.motion.plan:MotionPlan",
        "inverse_kinematics": "layflat.motion.tip_angles:inverse_kinematics",
        "plan_motion": "layflat.motion.plan:plan_motion",
        "read_motion": "layflat.motion.file:read_motion",
    },
)
