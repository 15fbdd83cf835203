"""What runs side by side are asked for, and what becomes of them: arrays that the compiled loop reads and fills."""

from typing import NamedTuple

import numpy as np


class Moves(NamedTuple):
    """The moves of every scenario; a scenario of fewer moves than another ends in moves from and to record -1."""

    ends: np.ndarray  # first and last record: (scenarios, moves, 2)
    goals: np.ndarray  # what the joints are asked for at the end, rad: (scenarios, moves, joints)
    tips: np.ndarray  # where that puts the tip, m: (runs, moves, 3)
    band: float  # within this of its goal a joint has settled, rad
    tip_band: float  # the same of the tip, m


class Results(NamedTuple):
    """Filled in by the kernel."""

    tallies: np.ndarray  # (runs, moves, joints and the tip, columns of a tally)
    totals: np.ndarray  # (runs, columns of `Totals`)
    traces: np.ndarray  # (runs, records, joints, columns)
    traced: np.ndarray  # which columns of `Traced` are kept
    every: int  # control cycles from one record of a trace to the next


class Totals(NamedTuple):
    """Numbers of a whole run."""

    air_taken: float  # kg
    peak_acceleration: float  # of the tip, m/s2
    diverged: float  # cycle in which the run diverged; not a number where it did not


class Traced(NamedTuple):
    """What a trace shows of a joint."""

    angle: float
    velocity: float
    pressure_a: float
    pressure_b: float
    valve_opening: float
    voltage: float


AIR, ACCELERATION, DIVERGED = range(3)
