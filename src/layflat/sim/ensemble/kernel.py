"""The compiled time loop of many runs side by side: the laws of `kernel.py`, a run per lane, and metrics as it goes."""

from typing import NamedTuple

from layflat.control import wake
from layflat.jit import composition, kernel, law
from layflat.lanes import each, gather, in_lanes, read_lanes, select, slots, width
from layflat.physics.adjustable import FULL
from layflat.physics.delay import NOTHING_ASKED
from layflat.physics.joint import AirTaken, Drive, JointState, Surroundings
from layflat.physics.plant import advance, at_rest, together
from layflat.physics.valves import start_wave
from layflat.sim.cycle import NOT_LED, Acting, Lead, Loop, Noise, Wanted, control_cycle, is_number, sense_all
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


class Given(NamedTuple):
    """What a scenario gives of a joint in a control cycle: see `Plan.shapes`."""

    demand: Wanted
    opening: float
    voltage: float
    brake: float
    dither: float
    load: float
    drift: float


class Defaults(NamedTuple):
    """What a run adds to its scenario: a factor of the brake, what comes on top of load and drift, and a lead."""

    brake: float
    load: float
    drift: float
    lead: Lead


SHAPES = 10  # numbers of a joint in `Plan.shapes`
NOTHING = Given(Wanted(0.0, 0.0, 0.0, 0.0), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
CALM = Noise(0.0, 0.0)


@composition
def _usual(runs, first, j, zero):
    return read_lanes(Defaults(0.0, 0.0, 0.0, NOT_LED), runs.usual[j, :, first:], zero)


@composition
def _changes(runs, plan, first, k, zero):
    # Whether a cycle asks for something new in any lane: mostly it doesn't, and to gather it costs more than the law.
    found = 0
    for lane in range(width(zero)):
        found += plan.changes[runs.scenario[first + lane], k]
    return found > 0


@composition
def _acting(scratch, runs, plan, usual, joint, first, j, k):
    # Gathered number by number: views of arrays would cost more than all the rest.
    for lane in range(width(usual.load)):
        for i in range(SHAPES):
            scratch[i, lane] = plan.shapes[runs.scenario[first + lane], k, j, i]
    given = read_lanes(NOTHING, scratch, usual.load)
    return Acting(
        given.demand,
        given.opening,
        given.voltage,
        usual.lead,
        given.brake * usual.brake * joint.brake_torque,
        given.dither,
        given.load + usual.load,
        given.drift + usual.drift,
    )


@composition
def _noise(runs, first, j, k, zero):
    return read_lanes(CALM, runs.noise[k % len(runs.noise), j, :, first:], zero)


@composition
def _surroundings(scratch, air, runs, plan, first, k):
    p_a = air.ambient_pressure
    for lane in range(width(p_a)):
        for i in range(2):
            scratch[i, lane] = plan.shared[runs.scenario[first + lane], k, i]
    given_gauge, given_payload = read_lanes((0.0, 0.0), scratch, p_a)
    usual_gauge, usual_payload = read_lanes((0.0, 0.0), runs.usual_shared[:, first:], p_a)
    gauge = select(is_number(given_gauge), given_gauge, usual_gauge)
    payload = select(is_number(given_payload), given_payload, usual_payload)
    return Surroundings(gauge + p_a, air.supply_temperature, p_a, air.ambient_temperature, payload)


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
    cycles, n = plan.shapes.shape[1], plan.shapes.shape[2]
    h, zero = timing.cycle / timing.steps, 0.0 * air.ambient_pressure
    around = _surroundings(watch.scratch, air, runs, plan, first, 0)
    states = slots(_at_rest(arm, like, runs, first, around))
    idle = Acting(Wanted(zero, zero, zero, zero), zero, zero, in_lanes(NOT_LED, zero), zero, zero, zero, zero)
    acting, usual = slots(like, idle), slots(like, _usual(runs, first, 0, zero))
    noise = slots(like, in_lanes(CALM, zero))
    loop = Loop(
        acting,
        noise,
        slots(like, Drive(zero, zero, zero, zero)),
        slots(like, in_lanes(NOTHING_ASKED, zero)),
        slots(like, start_wave(joints[0].valve, 0.0, h)),
        slots(like, zero),
        slots(like, in_lanes(FULL, zero)),
    )
    course, tracks = slots((in_lanes(NO_COURSE, zero),)), slots(like, in_lanes(NO_TRACK, zero))
    begin_moves(watch, moves, runs.scenario, arm, like, course, tracks, first)
    for j in range(1, n):
        usual[j] = _usual(runs, first, j, zero)
    memory = in_lanes(wake(settings, sense_all(joints, like, states, noise)), zero)
    for k in range(cycles + 1):
        note(watch, results, moves, runs.scenario, arm, like, states, course, tracks, first, k, timing.cycle)
        if k == cycles:
            break
        if _changes(runs, plan, first, k, zero):
            around = _surroundings(watch.scratch, air, runs, plan, first, k)
            for j in range(n):
                acting[j] = _acting(watch.scratch, runs, plan, usual[j], joints[j], first, j, k)
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
