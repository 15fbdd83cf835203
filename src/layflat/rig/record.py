"""What is kept of every control cycle: one row of numbers, the same for the loop, the recorder and who looks on.

Names and units are those of a simulated run (sim/dataset.py), so that plots, metrics and identification take either.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

SHARED: dict[str, tuple[str, str]] = {
    "time": ("s", "since the loop began"),
    "wall": ("s", "time of day when the cycle began, since 1970"),
    "elapsed": ("s", "since the cycle before"),
    "lateness": ("s", "of the cycle, after its deadline"),
    "compute": ("s", "taken by the cycle before, waiting for the far side left out"),
    "link": ("s", "taken by this cycle's transaction"),
    "supply": ("Pa", "absolute supply pressure"),
    "air": ("1", "1 where air is asked for"),
    "stopped": ("1", "1 while the e-stop is pressed"),
    "far": ("1", "what the far side does by itself"),
    "mode": ("1", "state of the supervisor"),
    "fault": ("1", "number of the worst fault, 0 for none"),
    "lost": ("1", "transactions that failed one after the other"),
}
"""Unit and meaning of what there is once."""

BY_JOINT: dict[str, tuple[str, str]] = {
    "demand": ("rad", "angle asked for"),
    "voltage": ("V", "control voltage"),
    "measured_angle": ("rad", "angle as sampled"),
    "measured_pressure": ("Pa", "differential pressure as sampled"),
    "averaged_angle": ("rad", "angle averaged over the dither period"),
    "averaged_velocity": ("rad/s", "velocity from the averaged angle"),
    "averaged_pressure": ("Pa", "differential pressure averaged over the dither period"),
    "ripple": ("Pa", "amplitude of the pressure at the dither frequency"),
    "phase": ("1", "phase of the controller"),
    "short_term": ("V", "short-term integral F"),
    "long_term": ("V", "long-term integral FL"),
    "learning": ("1", "1 while the long-term integral may build"),
    "joint_fault": ("1", "number of the joint's worst fault, 0 for none"),
}
"""Unit and meaning of what there is of every joint."""


@dataclass(frozen=True)
class Layout:
    """Where everything stands in a row: what is shared, then one joint after the other.

    Args:
        joints: names, from base to tip.
    """

    joints: tuple[str, ...]

    @classmethod
    def of(cls, joints: Sequence[str]) -> Layout:
        """Layout for joints of these names."""
        return cls(tuple(joints))

    @property
    def width(self) -> int:
        """Numbers in a row."""
        return len(SHARED) + len(self.joints) * len(BY_JOINT)

    @cached_property
    def shared(self) -> dict[str, int]:
        """Column of each shared number."""
        return {name: i for i, name in enumerate(SHARED)}

    def of_joint(self, joint: int) -> slice:
        """Columns of a joint, in the order of `BY_JOINT`."""
        first = len(SHARED) + joint * len(BY_JOINT)
        return slice(first, first + len(BY_JOINT))
