"""What is noted of runs side by side, record by record: metrics of moves, totals, and traces where asked."""

from math import hypot
from typing import NamedTuple

import numpy as np

from layflat.jit import composition, law
from layflat.lanes import select, slots, width, write_lanes
from layflat.physics.plant import tip
from layflat.physics.valve import net_opening
from layflat.sim.tally import add, clear


class Moves(NamedTuple):
    """The moves of every scenario; a scenario of fewer moves than another ends in moves from and to record -1."""

    ends: np.ndarray
    """First and last record: (scenarios, moves, 2)"""
    goals: np.ndarray
    """What the joints are asked for at the end, rad: (scenarios, moves, joints)"""
    tips: np.ndarray
    """Where that puts the tip, m: (runs, moves, 2)"""
    band: float
    """Within this of its goal a joint has settled, rad."""
    tip_band: float
    """The same of the tip, m."""


class Results(NamedTuple):
    """Filled in by the kernel."""

    tallies: np.ndarray
    """(runs, moves, joints and the tip, columns of a tally)"""
    totals: np.ndarray
    """(runs, columns of `Totals`)"""
    traces: np.ndarray
    """(runs, records, joints, columns)"""
    traced: np.ndarray
    """Which columns of `Traced` are kept"""
    every: int
    """Control cycles from one record of a trace to the next."""


class Totals(NamedTuple):
    """Numbers of a whole run."""

    air_taken: float
    """kg"""
    peak_acceleration: float
    """Of the tip, m/s2."""
    diverged: float
    """Cycle in which the run left all meaning; not a number where it did not."""


class Traced(NamedTuple):
    """What a trace shows of a joint."""

    angle: float
    velocity: float
    pressure_a: float
    pressure_b: float
    valve_opening: float
    voltage: float


AIR, ACCELERATION, DIVERGED = range(3)


class Watch(NamedTuple):
    """What has to be kept from record to record, a column a lane."""

    move: np.ndarray
    """Number of the move that goes on, (lanes,)"""
    ways: np.ndarray
    """Sign of its way, (joints, lanes)"""
    angles: np.ndarray
    """rad, (joints, lanes)"""
    places: np.ndarray
    """Where the tip is, and was one and two records ago, m: (3, 2, lanes)"""
    scratch: np.ndarray
    """(rows enough for anything, lanes)"""


def new_watch(joints: int, lanes: int) -> Watch:
    """A watch over so many lanes of runs."""
    return Watch(
        np.zeros(lanes, np.int64),
        np.zeros((joints, lanes)),
        np.zeros((joints, lanes)),
        np.zeros((3, 2, lanes)),
        np.zeros((8, lanes)),
    )


@law
def one_lane(watch, lane):
    """The part of a watch that is over a single lane."""
    return Watch(
        watch.move[lane : lane + 1],
        watch.ways[:, lane : lane + 1],
        watch.angles[:, lane : lane + 1],
        watch.places[:, :, lane : lane + 1],
        watch.scratch[:, lane : lane + 1],
    )


@law
def _note_move(watch, moves, tallies, scenario, run, lane, k):
    m = watch.move[lane]
    begin, end = moves.ends[scenario, m, 0], moves.ends[scenario, m, 1]
    if k < begin or end < k:
        return
    n, i, count = len(watch.angles), k - begin, end - begin + 1
    for j in range(n):
        error = watch.angles[j, lane] - moves.goals[scenario, m, j]
        if i == 0:
            watch.ways[j, lane] = 1.0 if error < 0.0 else -1.0 if error > 0.0 else 0.0
            clear(tallies[m, j])
        add(tallies[m, j], i, count, error, watch.ways[j, lane], moves.band)
    if i == 0:
        clear(tallies[m, n])
    x, y = watch.places[0, 0, lane], watch.places[0, 1, lane]
    add(tallies[m, n], i, count, hypot(x - moves.tips[run, m, 0], y - moves.tips[run, m, 1]), 1.0, moves.tip_band)
    if k == end and m + 1 < moves.ends.shape[1]:
        watch.move[lane] = m + 1


@law
def _note_acceleration(watch, totals, lane, k, cycle):
    new, last, before = watch.places[0], watch.places[1], watch.places[2]
    if k >= 2:
        x = new[0, lane] - 2.0 * last[0, lane] + before[0, lane]
        y = new[1, lane] - 2.0 * last[1, lane] + before[1, lane]
        totals[ACCELERATION] = max(totals[ACCELERATION], hypot(x, y) / (cycle * cycle))
    for i in range(2):
        before[i, lane], last[i, lane] = last[i, lane], new[i, lane]


@composition
def note(watch, results, moves, scenarios, arm, states, first, k, cycle):
    """Record k of the runs from number `first` on."""
    angles = slots(states, states[0].motion.angle)
    for j in range(len(watch.angles)):
        angles[j] = states[j].motion.angle
        write_lanes(watch.angles[j : j + 1], angles[j])
    write_lanes(watch.places[0], tip(arm, angles))
    for lane in range(width()):
        run = first + lane
        _note_move(watch, moves, results.tallies[run], scenarios[run], run, lane, k)
        _note_acceleration(watch, results.totals[run], lane, k, cycle)


@composition
def trace(watch, results, state, voltage, first, j, k):
    """Record of joint j in control cycle k, where it is due."""
    if k % results.every != 0 or len(results.traced) == 0:
        return
    motion, opening = state.motion, net_opening(state.valve)
    seen = Traced(motion.angle, motion.velocity, state.hose_a.pressure, state.hose_b.pressure, opening, voltage)
    write_lanes(watch.scratch, seen)
    for lane in range(width()):
        for column in range(len(results.traced)):
            results.traces[first + lane, k // results.every, j, column] = watch.scratch[results.traced[column], lane]


@composition
def note_divergence(watch, results, state, first, k):
    """Note where a joint has left all meaning (not a number included) in control cycle k for the first time."""
    sane = (abs(state.motion.angle) < 10.0) & (abs(state.motion.velocity) < 1e4)
    sound = sane & (state.hose_a.mass > 0.0) & (state.hose_b.mass > 0.0)
    write_lanes(watch.scratch, select(sound, 0.0, 1.0))
    for lane in range(width()):
        totals = results.totals[first + lane]
        if watch.scratch[0, lane] > 0.0 and not totals[DIVERGED] <= k:
            totals[DIVERGED] = k


@composition
def note_air(watch, results, state, first):
    """Add the air that a joint has taken."""
    write_lanes(watch.scratch, state.ledger.air_taken)
    for lane in range(width()):
        results.totals[first + lane, AIR] += watch.scratch[0, lane]
