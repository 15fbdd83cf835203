"""Records of runs in SIMD lanes: metrics of moves, totals, and traces where requested.

In these laws `first` is the number of the first lane's run, `scenarios` the number of the scenario of each run, `moves`
the `MoveArrays`, `arm` its parameters, k a control cycle, i a record of a move, j a joint. `progress` (of one
`ArmProgress`) and `joint_moves` are slots; laws without a result update them in place.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from layflat.jit import composition, law
from layflat.lanes import gather, read_lanes, select, slots, width, write_lanes
from layflat.physics.arms import tip_in_space
from layflat.physics.joint import is_sound
from layflat.physics.valves import net_opening
from layflat.sim.ensemble.results import Runs, Totals, Traced
from layflat.sim.loop import JointSignals
from layflat.sim.tally import COLUMNS, EMPTY_TALLY, Tally, reset_tally, update_tally

SCRATCH_ROWS = max(16, len(JointSignals._fields))  # max numbers of a run that are gathered at a time


class Watch(NamedTuple):
    """Present move of each lane, and a work array that turns lanes into numbers."""

    move: np.ndarray  # number of the move, (lanes,)
    end: np.ndarray  # its last record, (lanes,)
    scratch: np.ndarray  # (`SCRATCH_ROWS`, lanes)


class JointMove(NamedTuple):
    """Move of a joint: its goal (rad), the sign of its direction, and its tally."""

    goal: float
    direction: float
    tally: Tally


class ArmMove(NamedTuple):
    """Move of the arm: its first record, the number of its records, and the tip's goal (m)."""

    begin: float
    records: float
    goal_x: float
    goal_y: float
    goal_z: float


class TipHistory(NamedTuple):
    """Positions of the tip one and two records ago (m), and its maximum acceleration so far (m/s2)."""

    x_1: float
    y_1: float
    z_1: float
    x_2: float
    y_2: float
    z_2: float
    acceleration: float


class ArmProgress(NamedTuple):
    """Metrics of the whole arm so far; `diverged` is the control cycle of the divergence, or NaN."""

    move: ArmMove
    tally: Tally
    tip: TipHistory
    diverged: float


NO_JOINT_MOVE = JointMove(0.0, 0.0, EMPTY_TALLY)
NO_ARM_MOVE = ArmMove(0.0, 0.0, 0.0, 0.0, 0.0)
NO_PROGRESS = ArmProgress(
    NO_ARM_MOVE, EMPTY_TALLY, TipHistory(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0), np.nan
)  # before the first record


def new_watch(runs: Runs) -> Watch:
    """Return a watch over runs at their first moves, in their precision."""
    lanes = len(runs.scenario)
    return Watch(
        np.zeros(lanes, np.int64), np.zeros(lanes, np.int64), np.zeros((SCRATCH_ROWS, lanes), runs.parameters.dtype)
    )


@composition
def slice_watch(watch, first, lanes):
    """Return the part of a watch that covers `lanes` runs from number `first` on."""
    last = first + lanes
    return Watch(watch.move[first:last], watch.end[first:last], watch.scratch[:, first:last])


@composition
def begin_moves(watch, moves, scenarios, arm, progress, joint_moves, first):
    """Set goals and records of the moves that the watch names; moves in progress stay as they are."""
    scratch, any_number = watch.scratch, progress[0].diverged
    for lane in range(width(any_number)):
        scenario, move = scenarios[first + lane], watch.move[lane]
        begin, end = moves.ends[scenario, move, 0], moves.ends[scenario, move, 1]
        watch.end[lane] = end
        scratch[0, lane], scratch[1, lane] = begin, end - begin + 1
    begins, records = read_lanes((0.0, 0.0), scratch, any_number)
    goals = slots(joint_moves, begins)
    for j in range(moves.goals.shape[2]):
        for lane in range(width(any_number)):
            scratch[0, lane] = moves.goals[scenarios[first + lane], watch.move[lane], j]
        goals[j] = read_lanes(0.0, scratch, any_number)
        joint_moves[j] = JointMove(goals[j], joint_moves[j].direction, joint_moves[j].tally)
    x, y, z = tip_in_space(arm, gather(goals, goals))
    c = progress[0]
    progress[0] = ArmProgress(ArmMove(begins, records, x, y, z), c.tally, c.tip, c.diverged)


@composition
def _store_tally(watch, results, tally, first, j, k):
    """Store the tally of joint j (or of the tip) in the lanes whose move ends with record k."""
    write_lanes(watch.scratch, tally)
    for lane in range(width(tally.overshoot)):
        if watch.end[lane] == k:
            for column in range(COLUMNS):
                results.tallies[first + lane, watch.move[lane], j, column] = watch.scratch[column, lane]


@composition
def _end_moves(watch, results, moves, scenarios, arm, progress, joint_moves, first, k):
    """Store the tallies of moves that end with record k, and begin the next move in their lanes."""
    n = moves.goals.shape[2]
    over = 0
    for lane in range(width(progress[0].diverged)):
        over += watch.end[lane] == k
    if over == 0:
        return
    for j in range(n):
        _store_tally(watch, results, joint_moves[j].tally, first, j, k)
    _store_tally(watch, results, progress[0].tally, first, n, k)
    for lane in range(width(progress[0].diverged)):
        if watch.end[lane] == k and watch.move[lane] + 1 < moves.ends.shape[1]:
            watch.move[lane] += 1
    begin_moves(watch, moves, scenarios, arm, progress, joint_moves, first)


@law
def _update_joint_move(joint_move, angle, is_first, i, records, band):
    """Return a joint's move after record i of `records`, at an angle (rad); in the first one its direction is set.

    `band` is the settling band, rad.
    """
    error = angle - joint_move.goal
    direction = select(is_first, select(error < 0.0, 1.0, select(error > 0.0, -1.0, 0.0)), joint_move.direction)
    return JointMove(
        joint_move.goal,
        direction,
        update_tally(reset_tally(joint_move.tally, is_first), i, records, error, direction, band),
    )


@law
def _distance(x, y, z):
    return sqrt(x * x + y * y + z * z)


@law
def _update_tip(before, x, y, z, k, cycle):
    """Return the history of the tip after its position in record k (m), records `cycle` seconds apart."""
    a_x, a_y = x - 2.0 * before.x_1 + before.x_2, y - 2.0 * before.y_1 + before.y_2
    a_z = z - 2.0 * before.z_1 + before.z_2
    # Second differences need two earlier records.
    now = select(k >= 2, 1.0 / (cycle * cycle), 0.0) * _distance(a_x, a_y, a_z)
    return TipHistory(x, y, z, before.x_1, before.y_1, before.z_1, max(before.acceleration, now))


@composition
def record_metrics(watch, results, moves, scenarios, arm, states, progress, joint_moves, first, k, cycle):
    """Update the metrics of the joints' and the tip's present moves with control cycle k, and store those that end.

    `cycle` is the control period, s; `joint_moves` and `progress` are updated in place.
    """
    move, tally, before, diverged = progress[0]
    i = k - move.begin
    is_first = i == 0.0
    angles = slots(states, states[0].motion.angle)
    for j in range(moves.goals.shape[2]):
        angles[j] = states[j].motion.angle
        joint_moves[j] = _update_joint_move(joint_moves[j], angles[j], is_first, i, move.records, moves.band)
    x, y, z = tip_in_space(arm, gather(angles, angles))
    distance = _distance(x - move.goal_x, y - move.goal_y, z - move.goal_z)
    tally = update_tally(reset_tally(tally, is_first), i, move.records, distance, 1.0, moves.tip_band)
    progress[0] = ArmProgress(move, tally, _update_tip(before, x, y, z, k, cycle), diverged)
    _end_moves(watch, results, moves, scenarios, arm, progress, joint_moves, first, k)


@composition
def record_trace(watch, results, joint, state, voltage, first, j, k):
    """Write the traces of joint j in control cycle k, every `results.every` cycles."""
    if k % results.every != 0 or len(results.traced) == 0:
        return
    motion, opening = state.motion, net_opening(joint.valve, state.valve)
    sample = Traced(motion.angle, motion.velocity, state.hose_a.pressure, state.hose_b.pressure, opening, voltage)
    write_lanes(watch.scratch, sample)
    for lane in range(width(motion.angle)):
        for column in range(len(results.traced)):
            results.traces[first + lane, k // results.every, j, column] = watch.scratch[results.traced[column], lane]


@composition
def record_divergence(state, progress, k):
    """Store control cycle k as that of the divergence where a joint has diverged for the first time."""
    c = progress[0]
    diverged = select(is_sound(state) | (c.diverged <= k), c.diverged, k)
    progress[0] = ArmProgress(c.move, c.tally, c.tip, diverged)


@composition
def write_totals(watch, results, states, progress, first, n):
    """Write the `Totals` of all lanes, of n joints each, into the results at the run's end."""
    air = states[0].ledger.air_taken
    for j in range(1, n):
        air = air + states[j].ledger.air_taken
    write_lanes(watch.scratch, Totals(air, progress[0].tip.acceleration, progress[0].diverged))
    for lane in range(width(air)):
        for column in range(3):
            results.totals[first + lane, column] = watch.scratch[column, lane]
