"""A rig of layflat in ROS 2, over rosbridge: `layflat-ros2 paper-arm --driver simulated`.

This computer needs no ROS. A node has the rig's joint states, pressures and diagnostics as topics, follows the
trajectories of MoveIt and others, and obeys the controllers of ros2_control.
"""

from layflat_ros2.node import RigNode
from layflat_ros2.rosbridge import Rosbridge

__all__ = ["RigNode", "Rosbridge"]
