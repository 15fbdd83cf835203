"""What the ports of a spool valve let through, by where the spool is.

| symbol | meaning | unit |
|---|---|---|
| x | spool opening, positive: hose A to supply, hose B to exhaust | 1 |
| o | overlap: the share of the stroke in which a land covers its port | 1 |
| C | sonic conductance of a fully open path | m3/(s Pa) |
| C_0 | leakage conductance of a closed path | m3/(s Pa) |

A path has C_0 + (C - C_0) (x - o) / (1 - o) where x is over o, else C_0.
"""

from layflat.jit import law
from layflat.physics.ramp import mean_above_zero, mean_below_zero


@law
def path_conductance(valve, x):
    """Conductance of the path that a positive x opens, m3/(s Pa)."""
    share = max(x - valve.overlap, 0.0) * (1.0 / (1.0 - valve.overlap))
    return valve.leakage + (valve.conductance - valve.leakage) * share


@law
def mean_conductances(valve, x_0, x_1):
    """Mean conductances of the paths that a positive and that a negative x opens, m3/(s Pa).

    x moves evenly from x_0 to x_1.
    """
    o = valve.overlap
    per_opening = (valve.conductance - valve.leakage) * (1.0 / (1.0 - o))
    fills, vents = mean_above_zero(x_0 - o, x_1 - o), mean_below_zero(x_0 + o, x_1 + o)
    return valve.leakage + per_opening * fills, valve.leakage + per_opening * vents
