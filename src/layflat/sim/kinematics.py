"""Where the tip of a planar arm is.

| symbol | meaning | unit |
|---|---|---|
| q | joint angles from mid-stroke, (..., joints) | rad |
| e | elbow angle at mid-stroke | rad |
| l | lengths of the links | m |
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from layflat.machine import Machine


def tip_position(machine: Machine, q: NDArray[np.float64]) -> NDArray[np.float64]:
    """Position of the tip, (..., 2) in m, x along link 1 at mid-stroke, for angles (..., joints)."""
    lengths = [joint.link.length for joint in machine.joints.values()]
    offsets = [0.0, machine.arm.elbow][: len(lengths)]
    heading = np.cumsum(q + np.array(offsets), axis=-1)
    x = (np.cos(heading) * lengths).sum(axis=-1)
    y = (np.sin(heading) * lengths).sum(axis=-1)
    return np.stack([x, y], axis=-1)
