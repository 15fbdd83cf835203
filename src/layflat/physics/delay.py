"""A command that reaches the valve late: transport delay of driver and solenoid.

| symbol | meaning | unit |
|---|---|---|
| u | opening asked for in this control cycle, and in the cycles before it | 1 |
| n | delay in control cycles, up to `LONGEST` | 1 |

A command is held for a whole cycle. Delayed by a part of one, the command before it acts during that part: what acts on
average over the cycle is a mean of two neighbours, which has the same area.
"""

from typing import NamedTuple

from layflat.jit import law

LONGEST = 3  # control cycles that a command may take at most


class Line(NamedTuple):
    """Openings asked for one, two and three cycles ago."""

    last_1: float
    last_2: float
    last_3: float


NOTHING_ASKED = Line(0.0, 0.0, 0.0)


@law
def _share(n, of):
    # Weight of the command asked for so many cycles ago.
    return max(1.0 - abs(n - of), 0.0)


@law
def delayed(line, u, n):
    """Opening that acts in this cycle, and the line after it."""
    acts = (
        _share(n, 0.0) * u + _share(n, 1.0) * line.last_1 + _share(n, 2.0) * line.last_2 + _share(n, 3.0) * line.last_3
    )
    return acts, Line(u, line.last_1, line.last_2)
