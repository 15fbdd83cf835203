"""The supply line of a rig: regulator, dump valve with soft start, and the line to the joints' valves.

| symbol | meaning | unit |
|---|---|---|
| p | absolute pressure in the line | Pa |
| p_r | of the regulator | Pa |
| p_a | of the atmosphere | Pa |

p' = (p_0 - p)/T. While air is on p_0 = p_r, and T is long up to a share of the gauge pressure, short above it: a soft
start, as ISO 4414 asks for. While it is off the line is open to the atmosphere: p_0 = p_a.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, log

NEAR = 1.0
"""Within so many Pa of where it is going a line has arrived."""


@dataclass(frozen=True)
class LineLaw:
    """How fast a line fills and empties."""

    soft_time: float = 0.3
    """Time constant of the soft start, s."""
    opens_at: float = 0.5
    """Share of the regulator's gauge pressure at which the dump valve opens fully."""
    fill_time: float = 0.02
    """Time constant through the open valve, s."""
    dump_time: float = 0.03
    """Time constant to the atmosphere, s."""


class SupplyLine:
    """The line through time.

    Args:
        regulator: absolute pressure that the regulator gives, Pa.
        ambient: absolute pressure outside, Pa.
        air: whether it begins full, with air on; else empty.
        law: how fast it fills and empties.
    """

    def __init__(self, regulator: float, ambient: float, *, air: bool = False, law: LineLaw | None = None) -> None:
        self.regulator, self.ambient, self.air = regulator, ambient, air
        self.law = law or LineLaw()
        self.pressure = self.target

    @property
    def target(self) -> float:
        """Where the pressure goes, Pa."""
        return self.regulator if self.air else self.ambient

    @property
    def steady(self) -> bool:
        """Whether time changes nothing."""
        return self.pressure == self.target

    def advance(self, seconds: float) -> None:
        """Let time pass."""
        if not self.air:
            self._approach(self.ambient, seconds / self.law.dump_time)
            return
        opens = self.ambient + self.law.opens_at * (self.regulator - self.ambient)
        if self.pressure < opens:
            soft = self.law.soft_time * log((self.regulator - self.pressure) / (self.regulator - opens))
            if soft > seconds:
                self._approach(self.regulator, seconds / self.law.soft_time)
                return
            self.pressure, seconds = opens, seconds - soft
        self._approach(self.regulator, seconds / self.law.fill_time)

    def _approach(self, end: float, times: float) -> None:
        gone = end + (self.pressure - end) * exp(-times)
        self.pressure = end if abs(gone - end) < NEAR else gone
