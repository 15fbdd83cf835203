"""Record of a control cycle: one row of numbers, the same for the loop, the recorder and the host.

Names are those of a simulated run, so that plots, metrics and identification work with either.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Self

from layflat.arrays import Array
from layflat.control.signals import SIGNALS as AVERAGED
from layflat.machine.signals import SIGNALS
from layflat.motion.scenario import SIGNALS as ACTING
from layflat.rig.clock import NS_PER_SECOND

if TYPE_CHECKING:
    from layflat.machine import Machine

SHARED_COLUMNS: dict[str, tuple[str, str]] = {
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
}  # unit and meaning of each shared number

# Signals of every joint under any control law; behind them stand those of the law, then the joint's fault.
RIG_SIGNALS: dict[str, tuple[str, str]] = {
    "demand": ACTING["demand"].recorded,
    "demand_velocity": ("rad/s", "velocity of the demand; zero where the control law takes none"),
    **{name: SIGNALS[name] for name in ("voltage", "measured_angle", "measured_pressure")},
    **AVERAGED,
    "estimated_air": ("kg", "air taken from the supply since the loop began, as the rig estimates it"),
}


@dataclass(frozen=True)
class RowLayout:
    """Layout of a row: the shared numbers, then those of one joint after the other."""

    joints: tuple[str, ...]  # names, from base to tip
    law: tuple[tuple[str, tuple[str, str]], ...] = ()  # name, unit and meaning of the control law's signals of a joint

    @classmethod
    def for_machine(cls, machine: "Machine") -> Self:
        """Return the layout of a machine's rows; signals of the law that the rig estimates itself are left out."""
        signals = machine.control_law.signals.items()
        return cls(tuple(machine.joints), tuple((name, about) for name, about in signals if name not in AVERAGED))

    @cached_property
    def by_joint(self) -> dict[str, tuple[str, str]]:
        """Return unit and meaning of each number of a joint, by name."""
        return {**RIG_SIGNALS, **dict(self.law), "joint_fault": ("1", "number of the joint's worst fault, 0 for none")}

    @property
    def width(self) -> int:
        """Return the count of numbers in a row."""
        return len(SHARED_COLUMNS) + len(self.joints) * len(self.by_joint)

    @cached_property
    def shared(self) -> dict[str, int]:
        """Return the column of each shared number, by name."""
        return {name: i for i, name in enumerate(SHARED_COLUMNS)}

    @cached_property
    def columns(self) -> dict[str, int]:
        """Return the column of each number of a joint in its part of a row, by name."""
        return {name: i for i, name in enumerate(self.by_joint)}

    def joint_rows(self, rows: Array) -> Array:
        """Return the joints' part of rows (..., width) as a view, (..., joints, numbers)."""
        return rows[..., len(SHARED_COLUMNS) :].reshape(*rows.shape[:-1], len(self.joints), len(self.by_joint))

    def named(self, rows: Array, name: str) -> Array:
        """Return the numbers of a name in rows (..., width) as a view: (...,) if shared, else (..., joints)."""
        if name in SHARED_COLUMNS:
            return rows[..., self.shared[name]]
        return self.joint_rows(rows)[..., self.columns[name]]

    def began(self, row: Array) -> int:
        """Return the time of day when the loop began, ns since 1970, from one of its rows, (width,)."""
        return round(float(self.named(row, "wall") - self.named(row, "time")) * NS_PER_SECOND)
