"""Coulomb friction whose level depends on the angle and comes there only slowly.

| symbol | meaning | unit |
|---|---|---|
| q | joint angle | rad |
| F | level: the torque at which the joint slips | N m |
| F_s | level that F settles at while the angle stays | N m |
| F_0 | F_s at angle zero | N m |
| f | fade: how fast F_s falls with the angle | 1/rad |
| tau | how long F takes | s |

F_s = F_0 exp(-f q) is positive everywhere, and F' = (F_s - F)/tau. Empirical: the friction of the elbow of a pneumatic
android is told by where it was in the seconds before, not by where it is (see docs/derivations.md). With f = 0 it is
Coulomb friction. How it holds a joint exactly stands in friction.py.
"""

from math import exp
from typing import NamedTuple

from layflat.jit import law


class LaggingFriction(NamedTuple):
    """Level at angle zero (N m), fade (1/rad) and lag (s)."""

    torque: float
    fade: float
    lag: float


@law
def settled_level(friction, q):
    """Level that the friction settles at, N m."""
    return friction.torque * exp(-friction.fade * q)


@law
def next_level(friction, F, q, share):
    """Level after a step at angle q in which the lag goes a share of the way, N m."""
    return F + share * (settled_level(friction, q) - F)
