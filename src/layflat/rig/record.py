"""What is kept of every control cycle: one row of numbers, the same for the loop, the recorder and who looks on.

Names are those of a simulated run, so that plots, metrics and identification take either.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from layflat.arrays import Array
from layflat.control.average import SIGNALS as AVERAGED
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

RIG_SIGNALS: dict[str, tuple[str, str]] = {
    **{name: SIGNALS[name] for name in ("demand", "voltage", "measured_angle", "measured_pressure")},
    **AVERAGED,
}
"""Unit and meaning of what there is of every joint, whatever law controls it; behind it stands what the law tells."""

JOINT_FAULT = {"joint_fault": ("1", "number of the joint's worst fault, 0 for none")}  # what stands at the end


@dataclass(frozen=True)
class Layout:
    """Where everything stands in a row: what is shared, then one joint after the other."""

    joints: tuple[str, ...]  # names, from base to tip
    law: tuple[tuple[str, tuple[str, str]], ...] = ()
    """Unit and meaning of each signal that the control law tells of a joint."""

    @classmethod
    def of(cls, joints: Sequence[str], law: Mapping[str, tuple[str, str]]) -> Layout:
        """Layout for joints of these names and a law with these signals."""
        return cls(tuple(joints), tuple((name, (unit, meaning)) for name, (unit, meaning) in law.items()))

    @cached_property
    def by_joint(self) -> dict[str, tuple[str, str]]:
        """Unit and meaning of what there is of every joint."""
        return {**RIG_SIGNALS, **dict(self.law), **JOINT_FAULT}

    @property
    def width(self) -> int:
        """Numbers in a row."""
        return len(SHARED) + len(self.joints) * len(self.by_joint)

    @cached_property
    def shared(self) -> dict[str, int]:
        """Column of each shared number."""
        return {name: i for i, name in enumerate(SHARED)}

    @cached_property
    def columns(self) -> dict[str, int]:
        """Where the numbers of a joint stand in its part of a row, by name."""
        return {name: i for i, name in enumerate(self.by_joint)}

    def joint_rows(self, rows: Array) -> Array:
        """The joints' part of rows, (..., joints, numbers); a view of (..., width)."""
        return rows[..., len(SHARED) :].reshape(*rows.shape[:-1], len(self.joints), len(self.by_joint))

    def of_joint(self, joint: int) -> slice:
        """Columns of a joint, in the order of `by_joint`."""
        first = len(SHARED) + joint * len(self.by_joint)
        return slice(first, first + len(self.by_joint))
