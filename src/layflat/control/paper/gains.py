"""Settings and memory of the controller of one joint, and the pressure that holds its arm.

Eq. (2) takes differential pressure for acceleration. Under gravity or against a spring it is not: a joint at rest needs
some, which would count as motion. The pressure that the described arm needs at its demand is therefore taken off the
one that is fed back where that is asked for; the paper's arm turns in a level plane and needs none.
"""

from typing import Any, NamedTuple

from layflat.control.average import SIGNALS as AVERAGED
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


class Phase(NamedTuple):
    """Gains of one phase of a move."""

    error_gain: float  # k_e, V/rad
    pressure_gain: float  # k_p, V/Pa


class Gains(NamedTuple):
    """Settings of the controller of one joint; phase 1 is far or fast, 2 near, 3 almost there."""

    far: Phase
    near: Phase
    close: Phase
    near_error: float
    near_speed: float
    close_error: float
    close_speed: float
    null: float  # N, the valve's nominal centre, V
    integral_gain: float  # of the short-term integral F, V/(rad s)
    integral_limit: float  # of F, V
    drift_time: float  # time constant of the long-term integral FL, s
    drift_limit: float  # of FL, V
    air_ripple: float  # rule 1: the pressure ripple that shows that air is there, Pa
    rest_speed: float  # rule 2: the speed under which the joint may be at rest, rad/s
    rest_time: float  # rule 2: how long it has to be so slow, s: a joint that turns back is not at rest
    load_pressure: float  # rule 3: the differential pressure under which there is no offset load, Pa
    voltage_low: float
    voltage_high: float
    averaged: float  # 1: signals are averaged over four cycles (a dither period); 0: the last sample alone is used


class Settings(NamedTuple):
    """Settings of the whole arm: `Gains` of every joint."""

    joints: tuple[Gains, ...]
    load: NoLoad | DescribedLoad = NoLoad()


class Memory(NamedTuple):
    """The last three samples of both signals (newest first), the last averaged angle, both integrals, time at rest."""

    angle_0: float
    angle_1: float
    angle_2: float
    pressure_0: float
    pressure_1: float
    pressure_2: float
    last_angle: float
    short_term: float
    long_term: float
    rest: float  # how long the joint has been slow, s


class Report(NamedTuple):
    """Signals of a joint that the law shows in a cycle; `SIGNALS` has units and meanings."""

    averaged_angle: float
    averaged_velocity: float
    averaged_pressure: float
    ripple: float
    phase: float
    short_term: float
    long_term: float
    learning: float


SIGNALS = {
    **AVERAGED,
    "phase": ("1", "phase of the controller"),
    "short_term": ("V", "short-term integral F"),
    "long_term": ("V", "long-term integral FL"),
    "learning": ("1", "1 while the long-term integral may build"),
}
"""Unit and meaning of what is reported."""


class Memories(NamedTuple):
    """Memory of the law, of every joint."""

    joints: tuple[Memory, ...]
