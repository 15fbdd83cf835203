"""The compiled time loop of many runs side by side: the laws of `kernel.py`, a run per lane, and metrics as it goes."""

from layflat.control import wake
from layflat.jit import composition, kernel, law
from layflat.lanes import each, gather, in_lanes, read_lanes, select, slots, width
from layflat.physics.adjustable import FULL
from layflat.physics.delay import NOTHING_ASKED
from layflat.physics.joint import AirTaken, Drive, JointState
from layflat.physics.plant import advance, at_rest, together
from layflat.physics.valves import start_wave
from layflat.sim.cycle import (
    NOT_LED,
    NOTHING,
    NOTHING_AROUND,
    Acting,
    Around,
    Loop,
    Noise,
    control_cycle,
    is_number,
    sense_all,
    surroundings,
)
from layflat.sim.ensemble.watch import (
    NO_COURSE,
    NO_TRACK,
    begin_moves,
    note,
    note_divergence,
    note_totals,
    some_lanes,
    trace,
)

ITEMS: tuple[float, ...] = tuple(NOTHING)  # `each` takes items of plain tuples alone
ITEMS_AROUND: tuple[float, ...] = tuple(NOTHING_AROUND)
CALM = Noise(0.0, 0.0)


@composition
def _changes(runs, plan, first, k, zero):
    # Whether a cycle asks for something new in any lane: mostly it doesn't, and to gather it costs more than the law.
    found = 0
    for lane in range(width(zero)):
        found += plan.changes[runs.scenario[first + lane], k]
    return found > 0


@law
def _on_top(given, factor, added):
    return given * factor + added


@composition
def _acting(scratch, runs, plan, first, j, k, zero):
    # Gathered number by number: views of arrays would cost more than all the rest.
    for lane in range(width(zero)):
        for i in range(plan.by_joint.shape[3]):
            scratch[i, lane] = plan.by_joint[runs.scenario[first + lane], k, j, i]
    given = read_lanes(ITEMS, scratch, zero)
    factors = read_lanes(ITEMS, runs.factors[j, :, first:], zero)
    return Acting(*each(_on_top, given, factors, read_lanes(ITEMS, runs.added[j, :, first:], zero)))


@composition
def _noise(runs, first, j, k, zero):
    return read_lanes(CALM, runs.noise[k % len(runs.noise), j, :, first:], zero)


@law
def _given_or_usual(given, usual):
    return select(is_number(given), given, usual)


@composition
def _surroundings(scratch, air, runs, plan, first, k):
    zero = 0.0 * air.ambient_pressure
    for lane in range(width(zero)):
        for i in range(plan.shared.shape[2]):
            scratch[i, lane] = plan.shared[runs.scenario[first + lane], k, i]
    given, usual = read_lanes(ITEMS_AROUND, scratch, zero), read_lanes(ITEMS_AROUND, runs.shared[:, first:], zero)
    return surroundings(air, Around(*each(_given_or_usual, given, usual)))


@law
def _with_air_alone(state):
    return JointState(state.motion, state.valve, state.hose_a, state.hose_b, AirTaken(0.0))


@composition
def _at_rest(arm, like, runs, first, around):
    zero = 0.0 * around.ambient_pressure
    angles, firsts, seconds = slots(like, zero), slots(like, zero), slots(like, zero)
    for j in range(len(like)):
        angles[j] = read_lanes(0.0, runs.angles[j : j + 1, first:], zero)
        firsts[j], seconds[j] = read_lanes((0.0, 0.0), runs.pressures[j, :, first:], zero)
    states = at_rest(arm, like, gather(like, angles), gather(like, firsts), gather(like, seconds), around)
    return in_lanes(each(_with_air_alone, states), zero)


@composition
def run_lanes(case, first, runs, plan, moves, timing, results, watch):
    """Run runs side by side, as many as there are lanes, from number `first` on, through their scenarios from rest.

    `case` is any `Case`, or a `Like`: it gives the order of the runs' parameters. `watch` is over these runs, and new.
    """
    arm, like, settings, air = read_lanes(case, runs.parameters[:, first:])
    joints = slots(like)
    joined = together(arm, joints)
    cycles, n = plan.by_joint.shape[1], plan.by_joint.shape[2]
    h, zero = timing.cycle / timing.steps, 0.0 * air.ambient_pressure
    around = _surroundings(watch.scratch, air, runs, plan, first, 0)
    states = slots(_at_rest(arm, like, runs, first, around))
    acting, leads = slots(like, in_lanes(NOTHING, zero)), slots(like, in_lanes(NOT_LED, zero))
    noise = slots(like, in_lanes(CALM, zero))
    loop = Loop(
        acting,
        leads,
        noise,
        slots(like, Drive(zero, zero, zero, zero)),
        slots(like, in_lanes(NOTHING_ASKED, zero)),
        slots(like, start_wave(joints[0].valve, 0.0, h)),
        slots(like, zero),
        slots(like, in_lanes(FULL, zero)),
    )
    course, tracks = slots((in_lanes(NO_COURSE, zero),)), slots(like, in_lanes(NO_TRACK, zero))
    begin_moves(watch, moves, runs.scenario, arm, like, course, tracks, first)
    for j in range(n):
        leads[j] = read_lanes(NOT_LED, runs.leads[j, :, first:], zero)
    memory = in_lanes(wake(settings, sense_all(joints, like, states, noise)), zero)
    for k in range(cycles + 1):
        note(watch, results, moves, runs.scenario, arm, like, states, course, tracks, first, k, timing.cycle)
        if k == cycles:
            break
        if _changes(runs, plan, first, k, zero):
            around = _surroundings(watch.scratch, air, runs, plan, first, k)
            for j in range(n):
                acting[j] = _acting(watch.scratch, runs, plan, first, j, k, zero)
        for j in range(n):
            noise[j] = _noise(runs, first, j, k, zero)
        _, memory, _ = control_cycle(
            joints, like, settings, memory, states, loop, around, timing.cycle * k, timing.cycle, h
        )
        for j in range(n):
            trace(watch, results, joints[j], states[j], loop.voltages[j], first, j, k)
        advance(arm, joined, states, loop.drives, loop.waves, around, h, timing.steps)
        for j in range(n):
            note_divergence(states[j], course, k)
    note_totals(watch, results, states, course, first, n)


@kernel
def run_block(case, runs, plan, moves, timing, results, watch):
    """Run all runs of a block, as many at a time as there are lanes; the watch is as wide as the block."""
    lanes = width(case, runs.parameters)
    for first in range(0, len(runs.scenario), lanes):
        run_lanes(case, first, runs, plan, moves, timing, results, some_lanes(watch, first, lanes))
