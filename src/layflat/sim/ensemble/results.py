"""What runs side by side are asked for, and what becomes of them: arrays that the compiled loop reads and fills."""

from typing import NamedTuple

import numpy as np


class Plan(NamedTuple):
    """Scenarios over control cycles; not a number: as usual in the run."""

    by_joint: np.ndarray  # items of `Acting`: (scenarios, cycles, joints, signals)
    shared: np.ndarray  # items of `Around`: (scenarios, cycles, signals)
    changes: np.ndarray  # whether any of these is other than in the cycle before: (scenarios, cycles)


class Runs(NamedTuple):
    """Inputs that differ from run to run; runs lie side by side in memory where they are the last axis."""

    parameters: np.ndarray  # every number of the machine in order, a column a run: (numbers, runs)
    scenario: np.ndarray  # which scenario, (runs,)
    angles: np.ndarray  # at the start, rad, (joints, runs)
    pressures: np.ndarray  # at the start, Pa, (joints, 2, runs)
    factors: np.ndarray  # of the items of `Acting`: (joints, signals, runs)
    added: np.ndarray  # to these products: (joints, signals, runs)
    leads: np.ndarray  # the numbers of `Lead`: (joints, 4, runs)
    shared: np.ndarray  # items of `Around` where the scenario gives none: (signals, runs)
    noise: np.ndarray  # standard normal samples, (cycles, joints, 2, runs); one cycle of zeros for none


class Moves(NamedTuple):
    """The moves of every scenario; a scenario of fewer moves than another ends in moves from and to record -1."""

    ends: np.ndarray  # first and last record: (scenarios, moves, 2)
    goals: np.ndarray  # what the joints are asked for at the end, rad: (scenarios, moves, joints)
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
    """Signals of a joint in a trace."""

    angle: float
    velocity: float
    pressure_a: float
    pressure_b: float
    valve_opening: float
    voltage: float


AIR, ACCELERATION, DIVERGED = range(3)
