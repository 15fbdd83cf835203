"""What is noted of runs side by side, record by record: metrics of moves, totals, and traces where asked."""

from math import sqrt
from typing import NamedTuple

import numpy as np

from layflat.jit import composition, law
from layflat.lanes import read_lanes, select, slots, width, write_lanes
from layflat.physics.plant import tip
from layflat.physics.valve import net_opening
from layflat.sim.tally import COLUMNS, EMPTY, Tally, counted, emptied


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
    """Which move goes on in each lane, and room to turn lanes into numbers."""

    move: np.ndarray
    """Number of the move, (lanes,)"""
    end: np.ndarray
    """Its last record, (lanes,)"""
    scratch: np.ndarray
    """(rows enough for anything, lanes)"""


class Track(NamedTuple):
    """A joint's move: its goal (rad), the sign of its way, and the tally."""

    goal: float
    way: float
    tally: Tally


class Course(NamedTuple):
    """What goes on with the whole arm: its move, where the tip is to come (m), and the tip's places before."""

    begin: float
    """First record of the move."""
    records: float
    """How many it has."""
    goal_x: float
    goal_y: float
    tally: Tally
    x_1: float
    y_1: float
    x_2: float
    y_2: float
    """One and two records ago, m"""
    acceleration: float
    """Largest so far, m/s2"""
    diverged: float
    """Cycle, or not a number"""


NO_TRACK = Track(0.0, 0.0, EMPTY)
NO_COURSE = Course(0.0, 0.0, 0.0, 0.0, EMPTY, 0.0, 0.0, 0.0, 0.0, 0.0, np.nan)
"""Before the first record."""


def new_watch(lanes: int) -> Watch:
    """A watch over so many lanes of runs."""
    return Watch(np.zeros(lanes, np.int64), np.zeros(lanes, np.int64), np.zeros((8, lanes)))


@law
def one_lane(watch, lane):
    """The part of a watch that is over a single lane."""
    return Watch(watch.move[lane : lane + 1], watch.end[lane : lane + 1], watch.scratch[:, lane : lane + 1])


@composition
def begin_moves(watch, moves, scenarios, course, tracks, first):
    """Set out for the goals of the moves that the watch names; what goes on already just goes on."""
    scratch = watch.scratch
    for lane in range(width()):
        run, m = first + lane, watch.move[lane]
        begin, end = moves.ends[scenarios[run], m, 0], moves.ends[scenarios[run], m, 1]
        watch.end[lane] = end
        scratch[0, lane], scratch[1, lane] = begin, end - begin + 1
        scratch[2, lane], scratch[3, lane] = moves.tips[run, m, 0], moves.tips[run, m, 1]
    begin, records, goal_x, goal_y = read_lanes((0.0, 0.0, 0.0, 0.0), scratch)
    c = course[0]
    course[0] = Course(begin, records, goal_x, goal_y, c.tally, c.x_1, c.y_1, c.x_2, c.y_2, c.acceleration, c.diverged)
    for j in range(moves.goals.shape[2]):
        for lane in range(width()):
            scratch[0, lane] = moves.goals[scenarios[first + lane], watch.move[lane], j]
        tracks[j] = Track(read_lanes(0.0, scratch), tracks[j].way, tracks[j].tally)


@composition
def _keep(watch, results, tally, first, j, k):
    # The tally of joint j (or of the tip) in the lanes whose move ends with record k.
    write_lanes(watch.scratch, tally)
    for lane in range(width()):
        if watch.end[lane] == k:
            for column in range(COLUMNS):
                results.tallies[first + lane, watch.move[lane], j, column] = watch.scratch[column, lane]


@composition
def _end_moves(watch, results, moves, scenarios, course, tracks, first, k):
    n = moves.goals.shape[2]
    over = 0
    for lane in range(width()):
        over += watch.end[lane] == k
    if over == 0:
        return
    for j in range(n):
        _keep(watch, results, tracks[j].tally, first, j, k)
    _keep(watch, results, course[0].tally, first, n, k)
    for lane in range(width()):
        if watch.end[lane] == k and watch.move[lane] + 1 < moves.ends.shape[1]:
            watch.move[lane] += 1
    begin_moves(watch, moves, scenarios, course, tracks, first)


@composition
def note(watch, results, moves, scenarios, arm, states, course, tracks, first, k, cycle):
    """Record k of the runs from number `first` on."""
    c = course[0]
    i = k - c.begin
    begins = i == 0.0
    angles = slots(states, states[0].motion.angle)
    for j in range(moves.goals.shape[2]):
        angles[j] = states[j].motion.angle
        goal, way, tally = tracks[j]
        error = angles[j] - goal
        way = select(begins, select(error < 0.0, 1.0, select(error > 0.0, -1.0, 0.0)), way)
        tracks[j] = Track(goal, way, counted(emptied(tally, begins), i, c.records, error, way, moves.band))
    x, y = tip(arm, angles)
    away = sqrt((x - c.goal_x) * (x - c.goal_x) + (y - c.goal_y) * (y - c.goal_y))
    tally = counted(emptied(c.tally, begins), i, c.records, away, 1.0, moves.tip_band)
    a_x, a_y = x - 2.0 * c.x_1 + c.x_2, y - 2.0 * c.y_1 + c.y_2
    seen = select(k >= 2, 1.0 / (cycle * cycle), 0.0)
    fastest = max(c.acceleration, seen * sqrt(a_x * a_x + a_y * a_y))
    course[0] = Course(c.begin, c.records, c.goal_x, c.goal_y, tally, x, y, c.x_1, c.y_1, fastest, c.diverged)
    _end_moves(watch, results, moves, scenarios, course, tracks, first, k)


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
def note_divergence(state, course, k):
    """Note where a joint has left all meaning (not a number included) in control cycle k for the first time."""
    sane = (abs(state.motion.angle) < 10.0) & (abs(state.motion.velocity) < 1e4)
    sound = sane & (state.hose_a.mass > 0.0) & (state.hose_b.mass > 0.0)
    c = course[0]
    diverged = select(sound | (c.diverged <= k), c.diverged, k)
    course[0] = Course(
        c.begin, c.records, c.goal_x, c.goal_y, c.tally, c.x_1, c.y_1, c.x_2, c.y_2, c.acceleration, diverged
    )


@composition
def note_totals(watch, results, states, course, first, n):
    """What there is to say of whole runs."""
    air = states[0].ledger.air_taken
    for j in range(1, n):
        air = air + states[j].ledger.air_taken
    write_lanes(watch.scratch, Totals(air, course[0].acceleration, course[0].diverged))
    for lane in range(width()):
        for column in range(3):
            results.totals[first + lane, column] = watch.scratch[column, lane]
