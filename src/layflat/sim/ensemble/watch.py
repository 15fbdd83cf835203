"""What is noted of runs side by side, record by record: metrics of moves, totals, and traces where asked."""

from math import sqrt
from typing import NamedTuple

import numpy as np

from layflat.jit import composition, law
from layflat.lanes import gather, read_lanes, select, slots, width, write_lanes
from layflat.physics.arms import tip_in_space
from layflat.physics.joint import is_sound
from layflat.physics.valves import net_opening
from layflat.sim.cycle import Acting
from layflat.sim.ensemble.results import Runs, Totals, Traced
from layflat.sim.tally import COLUMNS, EMPTY, Tally, counted, emptied

ROOM = max(16, len(Acting._fields))  # numbers of a run that are gathered at a time, at most


class Watch(NamedTuple):
    """Number of the move in each lane, and room to turn lanes into numbers."""

    move: np.ndarray  # number of the move, (lanes,)
    end: np.ndarray  # its last record, (lanes,)
    scratch: np.ndarray  # (`ROOM`, lanes)


class Track(NamedTuple):
    """A joint's move: its goal (rad), the sign of its way, and the tally."""

    goal: float
    way: float
    tally: Tally


class Move(NamedTuple):
    """The arm's move: its first record, how many it has, and where the tip is to come (m)."""

    begin: float
    records: float
    goal_x: float
    goal_y: float
    goal_z: float


class Tip(NamedTuple):
    """Places of the tip one and two records ago (m), and its largest acceleration so far (m/s2)."""

    x_1: float
    y_1: float
    z_1: float
    x_2: float
    y_2: float
    z_2: float
    acceleration: float


class Course(NamedTuple):
    """Course of the whole arm; `diverged` is a cycle, or not a number."""

    move: Move
    tally: Tally
    tip: Tip
    diverged: float


NO_TRACK = Track(0.0, 0.0, EMPTY)
NO_MOVE = Move(0.0, 0.0, 0.0, 0.0, 0.0)
NO_COURSE = Course(NO_MOVE, EMPTY, Tip(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0), np.nan)  # before the first record


def new_watch(runs: Runs) -> Watch:
    """A watch over runs, in their precision."""
    lanes = len(runs.scenario)
    return Watch(np.zeros(lanes, np.int64), np.zeros(lanes, np.int64), np.zeros((ROOM, lanes), runs.parameters.dtype))


@composition
def some_lanes(watch, first, lanes):
    """The part of a watch that is over so many lanes, which go side by side from number `first` on."""
    last = first + lanes
    return Watch(watch.move[first:last], watch.end[first:last], watch.scratch[:, first:last])


@composition
def begin_moves(watch, moves, scenarios, arm, like, course, tracks, first):
    """Set out for the goals of the moves that the watch names; what goes on already just goes on."""
    scratch, any_number = watch.scratch, course[0].diverged
    for lane in range(width(any_number)):
        scenario, move = scenarios[first + lane], watch.move[lane]
        begin, end = moves.ends[scenario, move, 0], moves.ends[scenario, move, 1]
        watch.end[lane] = end
        scratch[0, lane], scratch[1, lane] = begin, end - begin + 1
    begins, records = read_lanes((0.0, 0.0), scratch, any_number)
    goals = slots(like, begins)
    for j in range(moves.goals.shape[2]):
        for lane in range(width(any_number)):
            scratch[0, lane] = moves.goals[scenarios[first + lane], watch.move[lane], j]
        goals[j] = read_lanes(0.0, scratch, any_number)
        tracks[j] = Track(goals[j], tracks[j].way, tracks[j].tally)
    x, y, z = tip_in_space(arm, gather(like, goals))
    c = course[0]
    course[0] = Course(Move(begins, records, x, y, z), c.tally, c.tip, c.diverged)


@composition
def _keep(watch, results, tally, first, j, k):
    # The tally of joint j (or of the tip) in the lanes whose move ends with record k.
    write_lanes(watch.scratch, tally)
    for lane in range(width(tally.overshoot)):
        if watch.end[lane] == k:
            for column in range(COLUMNS):
                results.tallies[first + lane, watch.move[lane], j, column] = watch.scratch[column, lane]


@composition
def _end_moves(watch, results, moves, scenarios, arm, like, course, tracks, first, k):
    n = moves.goals.shape[2]
    over = 0
    for lane in range(width(course[0].diverged)):
        over += watch.end[lane] == k
    if over == 0:
        return
    for j in range(n):
        _keep(watch, results, tracks[j].tally, first, j, k)
    _keep(watch, results, course[0].tally, first, n, k)
    for lane in range(width(course[0].diverged)):
        if watch.end[lane] == k and watch.move[lane] + 1 < moves.ends.shape[1]:
            watch.move[lane] += 1
    begin_moves(watch, moves, scenarios, arm, like, course, tracks, first)


@law
def _tracked(track, angle, begins, i, records, band):
    error = angle - track.goal
    way = select(begins, select(error < 0.0, 1.0, select(error > 0.0, -1.0, 0.0)), track.way)
    return Track(track.goal, way, counted(emptied(track.tally, begins), i, records, error, way, band))


@law
def _distance(x, y, z):
    return sqrt(x * x + y * y + z * z)


@law
def _followed(before, x, y, z, k, cycle):
    a_x, a_y = x - 2.0 * before.x_1 + before.x_2, y - 2.0 * before.y_1 + before.y_2
    a_z = z - 2.0 * before.z_1 + before.z_2
    # Two records ago there has to have been one.
    now = select(k >= 2, 1.0 / (cycle * cycle), 0.0) * _distance(a_x, a_y, a_z)
    return Tip(x, y, z, before.x_1, before.y_1, before.z_1, max(before.acceleration, now))


@composition
def note(watch, results, moves, scenarios, arm, like, states, course, tracks, first, k, cycle):
    """Record k of the runs from number `first` on."""
    move, tally, before, diverged = course[0]
    i = k - move.begin
    begins = i == 0.0
    angles = slots(like, states[0].motion.angle)
    for j in range(moves.goals.shape[2]):
        angles[j] = states[j].motion.angle
        tracks[j] = _tracked(tracks[j], angles[j], begins, i, move.records, moves.band)
    x, y, z = tip_in_space(arm, gather(like, angles))
    away = _distance(x - move.goal_x, y - move.goal_y, z - move.goal_z)
    tally = counted(emptied(tally, begins), i, move.records, away, 1.0, moves.tip_band)
    course[0] = Course(move, tally, _followed(before, x, y, z, k, cycle), diverged)
    _end_moves(watch, results, moves, scenarios, arm, like, course, tracks, first, k)


@composition
def trace(watch, results, joint, state, voltage, first, j, k):
    """Record of joint j in control cycle k, where it is due."""
    if k % results.every != 0 or len(results.traced) == 0:
        return
    motion, opening = state.motion, net_opening(joint.valve, state.valve)
    seen = Traced(motion.angle, motion.velocity, state.hose_a.pressure, state.hose_b.pressure, opening, voltage)
    write_lanes(watch.scratch, seen)
    for lane in range(width(motion.angle)):
        for column in range(len(results.traced)):
            results.traces[first + lane, k // results.every, j, column] = watch.scratch[results.traced[column], lane]


@composition
def note_divergence(state, course, k):
    """Note where a joint has diverged in control cycle k for the first time."""
    c = course[0]
    diverged = select(is_sound(state) | (c.diverged <= k), c.diverged, k)
    course[0] = Course(c.move, c.tally, c.tip, diverged)


@composition
def note_totals(watch, results, states, course, first, n):
    """Write the totals of whole runs."""
    air = states[0].ledger.air_taken
    for j in range(1, n):
        air = air + states[j].ledger.air_taken
    write_lanes(watch.scratch, Totals(air, course[0].tip.acceleration, course[0].diverged))
    for lane in range(width(air)):
        for column in range(3):
            results.totals[first + lane, column] = watch.scratch[column, lane]
