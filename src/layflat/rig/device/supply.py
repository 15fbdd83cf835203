"""The supply line of a rig: regulator, dump valve with soft start, and the line to the joints' valves.

| symbol | meaning | unit |
|---|---|---|
| p | absolute pressure in the line | Pa |
| p_r | of the regulator | Pa |
| p_a | of the atmosphere | Pa |

p' = (p_0 - p)/T. While air is on p_0 = p_r, and T is long up to a share of the gauge pressure, short above it: a soft
start, as ISO 4414 asks for. While it is off the line is open to the atmosphere: p_0 = p_a.
"""

from math import exp, log

NEAR = 1.0  # within so many Pa of where it is going a line has arrived
SOFT_TIME, FILL_TIME, DUMP_TIME = 0.3, 0.02, 0.03  # of soft start, through the open valve, to the atmosphere: T, s
OPENS_AT = 0.5  # share of the regulator's gauge pressure at which the dump valve opens fully


class SupplyLine:
    """The line through time; pressures are absolute, Pa. With air on it begins full, else empty."""

    def __init__(self, regulator: float, ambient: float, *, air: bool = False) -> None:
        self.regulator, self.ambient, self.air = regulator, ambient, air
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
            self._approach(self.ambient, seconds / DUMP_TIME)
            return
        opens = self.ambient + OPENS_AT * (self.regulator - self.ambient)
        if self.pressure < opens:
            soft = SOFT_TIME * log((self.regulator - self.pressure) / (self.regulator - opens))
            if soft > seconds:
                self._approach(self.regulator, seconds / SOFT_TIME)
                return
            self.pressure, seconds = opens, seconds - soft
        self._approach(self.regulator, seconds / FILL_TIME)

    def _approach(self, end: float, times: float) -> None:
        gone = end + (self.pressure - end) * exp(-times)
        self.pressure = end if abs(gone - end) < NEAR else gone
