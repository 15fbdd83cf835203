"""What is kept of every control cycle: one row of numbers, the same for the loop, the recorder and who looks on.

Names are those of a simulated run, so that plots, metrics and identification take either.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from layflat.machine.signals import SIGNALS

SHARED: dict[str, tuple[str, str]] = {
    "time": ("s", "since the loop began"),
    "wall": ("s", "time of day when the cycle began, since 1970"),
    "elapsed": ("s", "since the cycle before"),
    "lateness": ("s", "of the cycle, after its deadline"),
    "compute": ("s", "taken by the cycle before, waiting for the device left out"),
    "link": ("s", "taken by this cycle's transaction"),
    "supply": SIGNALS["supply"],
    "air": ("1", "1 where air is asked for"),
    "stopped": ("1", "1 while the e-stop is pressed"),
    "device": ("1", "what the device does by itself"),
    "mode": ("1", "state of the supervisor"),
    "fault": ("1", "number of the worst fault, 0 for none"),
    "lost": ("1", "transactions that failed one after the other"),
}
"""Unit and meaning of what there is once."""

_SIGNALS = (
    "demand", "voltage", "measured_angle", "measured_pressure", "averaged_angle", "averaged_velocity",
    "averaged_pressure", "ripple", "phase", "short_term", "long_term", "learning",
)  # fmt: skip

BY_JOINT: dict[str, tuple[str, str]] = {
    **{name: SIGNALS[name] for name in _SIGNALS},
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
