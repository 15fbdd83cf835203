"""What is kept of every control cycle: one row of numbers, the same for the loop, the recorder and who looks on.

Names are those of a simulated run, so that plots, metrics and identification take either.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Self

from layflat.arrays import Array
from layflat.control.average import SIGNALS as AVERAGED
from layflat.machine.signals import SIGNALS
from layflat.motion.scenario import SIGNALS as ACTING
from layflat.rig.clock import SECOND

if TYPE_CHECKING:
    from layflat.machine import Machine

SHARED: dict[str, tuple[str, str]] = {
    "time": ("s", "since the loop began"),
    "wall": ("s", "time of day when the cycle began, since 1970"),
    "elapsed": ("s", "since the cycle before"),
    "lateness": ("s", "of the cycle, after its deadline"),
    "compute": ("s", "taken by the cycle before, waiting for the device left out"),
    "link": ("s", "taken by this cycle's transaction"),
    "supply": ACTING["supply"].recorded,
    "air": ("1", "1 where air is asked for"),
    "stopped": ("1", "1 while the e-stop is pressed"),
    "device": ("1", "what the device does by itself"),
    "mode": ("1", "state of the supervisor"),
    "fault": ("1", "number of the worst fault, 0 for none"),
    "lost": ("1", "transactions that failed one after the other"),
    "outputs": ("1", "digital outputs that are on, as bits"),
}  # unit and meaning of what there is once

# What there is of every joint, whatever law controls it; behind it stands what the law tells, then its fault.
RIG_SIGNALS: dict[str, tuple[str, str]] = {
    "demand": ACTING["demand"].recorded,
    "demand_velocity": ("rad/s", "velocity of the demand; zero where the control law takes none"),
    **{name: SIGNALS[name] for name in ("voltage", "measured_angle", "measured_pressure")},
    **AVERAGED,
    "estimated_air": ("kg", "air taken from the supply since the loop began, as the rig estimates it"),
}


@dataclass(frozen=True)
class Layout:
    """Layout of a row: what is shared, then one joint after the other."""

    joints: tuple[str, ...]  # names, from base to tip
    law: tuple[tuple[str, tuple[str, str]], ...] = ()  # name, unit and meaning of what the control law tells of a joint

    @classmethod
    def of(cls, machine: "Machine") -> Self:
        """Layout of the rows that a loop of a machine records; what the rig estimates by itself is not told twice."""
        told = machine.control_law.signals.items()
        return cls(tuple(machine.joints), tuple((name, about) for name, about in told if name not in AVERAGED))

    @cached_property
    def by_joint(self) -> dict[str, tuple[str, str]]:
        """Unit and meaning of what there is of every joint."""
        return {**RIG_SIGNALS, **dict(self.law), "joint_fault": ("1", "number of the joint's worst fault, 0 for none")}

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
        """Columns of a joint's numbers in its part of a row, by name."""
        return {name: i for i, name in enumerate(self.by_joint)}

    def joint_rows(self, rows: Array) -> Array:
        """The joints' part of rows, (..., joints, numbers); a view of (..., width)."""
        return rows[..., len(SHARED) :].reshape(*rows.shape[:-1], len(self.joints), len(self.by_joint))

    def named(self, rows: Array, name: str) -> Array:
        """The numbers of a name in rows, (...,) or (..., joints); a view of (..., width)."""
        if name in SHARED:
            return rows[..., self.shared[name]]
        return self.joint_rows(rows)[..., self.columns[name]]

    def began(self, row: Array) -> int:
        """Time of day when the loop began, ns since 1970, by one of its rows."""
        return round(float(self.named(row, "wall") - self.named(row, "time")) * SECOND)
