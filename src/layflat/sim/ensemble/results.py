"""Inputs and results of runs in SIMD lanes: arrays that the compiled loop reads and fills."""

from typing import NamedTuple

import numpy as np


class ScenarioArrays(NamedTuple):
    """Signals of scenarios over control cycles; NaN where the run's own value holds."""

    by_joint: np.ndarray  # items of `JointSignals`: (scenarios, cycles, joints, signals)
    shared: np.ndarray  # items of `SharedSignals`: (scenarios, cycles, signals)
    changes: np.ndarray  # whether any signal differs from the cycle before: (scenarios, cycles)


class Runs(NamedTuple):
    """Inputs that differ from run to run; the last axis is contiguous in memory."""

    parameters: np.ndarray  # every number of the machine in order: (numbers, runs)
    scenario: np.ndarray  # number of the run's scenario, (runs,)
    angles: np.ndarray  # at the start, rad, (joints, runs)
    pressures: np.ndarray  # at the start, absolute, Pa, (joints, 2, runs)
    factors: np.ndarray  # that multiply the items of `JointSignals`: (joints, signals, runs)
    added: np.ndarray  # terms that are then added: (joints, signals, runs)
    injections: np.ndarray  # items of `InjectionGains`: (joints, 4, runs)
    shared: np.ndarray  # items of `SharedSignals` where the scenario sets none: (signals, runs)
    noise: np.ndarray  # standard normal samples, (cycles, joints, 2, runs); one cycle of zeros for none


class MoveArrays(NamedTuple):
    """Moves of every scenario; scenarios with fewer moves than others are padded with moves from and to record -1."""

    ends: np.ndarray  # first and last record: (scenarios, moves, 2)
    goals: np.ndarray  # demands of the joints at the move's end, rad: (scenarios, moves, joints)
    band: float  # settling band of a joint, rad
    tip_band: float  # settling band of the tip, m


class Results(NamedTuple):
    """Results of runs, filled by the kernel."""

    tallies: np.ndarray  # (runs, moves, joints and the tip, columns of a tally)
    totals: np.ndarray  # (runs, columns of `Totals`)
    traces: np.ndarray  # (runs, records, joints, columns)
    traced: np.ndarray  # numbers of the columns of `Traced` that are kept
    every: int  # control cycles from one record of a trace to the next


class Totals(NamedTuple):
    """Metrics of a whole run."""

    air_taken: float  # kg
    peak_acceleration: float  # of the tip, m/s2
    diverged: float  # control cycle in which the run diverged; NaN where it did not


class Traced(NamedTuple):
    """Signals of a joint in a trace."""

    angle: float
    velocity: float
    pressure_a: float
    pressure_b: float
    valve_opening: float
    voltage: float


AIR_TAKEN, PEAK_ACCELERATION, DIVERGENCE_CYCLE = range(3)
