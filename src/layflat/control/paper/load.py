"""The differential pressure that holds an arm, taken off the one that is fed back.

Eq. (2) takes differential pressure for acceleration. Under gravity or against a spring it is not: a joint at rest needs
some, which would count as motion. What the described arm needs at its demand is therefore taken off where that is asked
for; the paper's arm turns in a level plane and needs none.
"""

from typing import Any, NamedTuple

from layflat.jit import by_kind, composition, law
from layflat.lanes import each
from layflat.physics.arms import dynamics
from layflat.physics.joint import Surroundings, pressures_at_rest


class NoLoad(NamedTuple):
    """A law that feeds the differential pressure back as it is."""


class DescribedLoad(NamedTuple):
    """Parameters of the laws of the described arm, its joints and what is around them."""

    arm: Any
    joints: tuple[Any, ...]
    around: Surroundings


@law
def _still(q):
    return 0.0 * q


@law
def _less(dp, joint, q, pull, around):
    p_1, p_2 = pressures_at_rest(joint, q, pull, around)
    return dp - (p_1 - p_2)


@composition
def _as_it_is(load, q, dp):  # noqa: ARG001
    return dp


@composition
def _without_load(load, q, dp):
    _, _, pulls = dynamics(load.arm, load.around.payload, q, each(_still, q))
    return each(_less, dp, load.joints, q, pulls, load.around)


fed_back = by_kind({NoLoad: _as_it_is, DescribedLoad: _without_load})
"""Differential pressures (Pa) less what holds the arm at angles (rad), tuples: `fed_back(load, q, dp)`."""
