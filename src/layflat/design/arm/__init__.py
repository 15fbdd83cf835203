"""Design of arms from tasks: joints, links and masses for a payload, a reach and moves.

`size_arm` does it all. Read in this order: task, moves, components, described, sizing, trade_off. Names are loaded when
they are first used.
"""

from typing import TYPE_CHECKING

from layflat.lazy import lazy_getattr

if TYPE_CHECKING:
    from layflat.design.arm.sizing import SizedArm, size_arm
    from layflat.design.arm.task import TASK_LIBRARY, ArmTask, JointTask, read_task

__all__ = ["TASK_LIBRARY", "ArmTask", "JointTask", "SizedArm", "read_task", "size_arm"]

__getattr__ = lazy_getattr(
    __name__,
    {name: f"layflat.design.arm.{'sizing' if name in {'SizedArm', 'size_arm'} else 'task'}:{name}" for name in __all__},
)
