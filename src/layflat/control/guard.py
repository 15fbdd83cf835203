"""Guard of compiled control laws from outside: a number that is none, wherever one returns it, ends the run at once."""

from collections.abc import Callable
from math import nan
from typing import Any

from layflat.control.contract import Command
from layflat.jit import composition, law
from layflat.lanes import each, in_lanes, select, zero_if_finite


@law
def _in_range(share):
    return select((share >= 0.0) & (share <= 1.0), share, nan)


@law
def _with_flaws(voltage, shares, flaw):
    brake, dither, supply = _in_range(shares.brake), _in_range(shares.dither), _in_range(shares.supply)
    return voltage + zero_if_finite((voltage, brake, dither, supply)) + flaw


def guard_step(step: Callable[..., Any]) -> Callable[..., Any]:
    """Return a compiled `step` whose voltages are not numbers in a cycle in which it returns what it may not.

    That is a number in memory, command or report that is not finite, or a share outside 0 to 1.
    """

    @composition
    def guarded_step(settings, memory, sensed, demand, elapsed):
        zero = 0.0 * sensed.angle[0]
        after, command, report = step(settings, memory, sensed, demand, elapsed)
        flaw = zero_if_finite((in_lanes(after, zero), in_lanes(report, zero)))
        voltages = each(_with_flaws, in_lanes(command.voltage, zero), in_lanes(command.shares, zero), flaw)
        return after, Command(voltages, command.shares), report

    return guarded_step
