"""What the controller of one joint is set to, and what it remembers from cycle to cycle."""

from typing import NamedTuple

from layflat.control.average import SIGNALS as AVERAGED
from layflat.control.paper.load import DescribedLoad, NoLoad


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
    """What the law shows of a joint in a cycle; `SIGNALS` has units and meanings."""

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
    """What the law remembers of every joint."""

    joints: tuple[Memory, ...]
