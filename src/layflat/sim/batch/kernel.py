"""Kernels of a batch: the beginning of arms at rest, and a control cycle of many arms, each in a lane.

In these laws `first` is the number of the first lane's arm, `zero` a zero in every lane, `case_like` and `carry_like`
the `Like` of a `Case` and of an `ArmCarry`.
"""

from typing import NamedTuple

import numpy as np

from layflat.jit import composition, portable_kernel
from layflat.lanes import gather, in_lanes, read_lanes, select, select_leaves, slots, width, write_lanes
from layflat.physics.adjustable import FULL_FRACTIONS
from layflat.physics.arms import tip_in_space
from layflat.physics.driver import ZERO_COMMANDS
from layflat.physics.joint import Drive, is_sound
from layflat.physics.plant import advance_arm, pack_joints
from layflat.physics.valves import net_opening, start_wave
from layflat.sim.batch.arrays import ArmCarry, SeenJoint
from layflat.sim.ensemble.kernel import initial_states
from layflat.sim.ensemble.noise import fill_cycle, seed_stream
from layflat.sim.loop import (
    NO_INJECTION,
    ZERO_JOINT_SIGNALS,
    ZERO_NOISE,
    ZERO_SHARED_SIGNALS,
    LoopState,
    control_cycle,
    initial_memory,
    sense_all,
    surroundings,
)


class RestStarts(NamedTuple):
    """Rest at which arms begin."""

    angles: np.ndarray  # rad, (joints, arms)
    pressures: np.ndarray  # absolute, Pa, (joints, 2, arms); NaN for those that hold the arm


@composition
def _read_noise(arrays, noise, first, zero):
    """Load the noise of the coming cycle into its slots."""
    for j in range(len(noise)):
        noise[j] = read_lanes(ZERO_NOISE, arrays.noise[0, j, :, first:], zero)


@composition
def _see(case, states, arrays, first, zero):
    """Write readings, openings and positions of the tip that belong to the states (slots)."""
    joints, noise = slots(case.joints), slots(case.joints, in_lanes(ZERO_NOISE, zero))
    last = first + width(zero)
    _read_noise(arrays, noise, first, zero)
    sensed = sense_all(joints, states, noise)
    angles, pressures, turned = slots(sensed.angle), slots(sensed.differential_pressure), slots(joints, zero)
    for j in range(len(joints)):
        opening = in_lanes(net_opening(joints[j].valve, states[j].valve), zero)
        write_lanes(arrays.seen[j, :, first:last], SeenJoint(angles[j], pressures[j], opening))
        turned[j] = states[j].motion.angle
    write_lanes(arrays.tips[:, first:last], tip_in_space(case.arm, gather(joints, turned)))


@portable_kernel(in_lanes=True)
def begin_arms(case_like, arrays, starts):
    """Begin all arms at rest: write what is carried, but voltages and reports, which are zero.

    Args: `Like` of a `Case`; `BatchArrays`; `RestStarts`.
    """
    lanes = width(case_like, arrays.parameters)
    for first in range(0, len(arrays.cycles), lanes):
        case = read_lanes(case_like, arrays.parameters[:, first:])
        like, zero = case.joints, 0.0 * case.air.ambient_pressure
        around = surroundings(case.air, read_lanes(ZERO_SHARED_SIGNALS, arrays.shared[:, first:], zero))
        rest = initial_states(case.arm, like, starts, first, around)
        joints, states = slots(like), slots(rest)
        lines, shares = slots(like, in_lanes(ZERO_COMMANDS, zero)), slots(like, in_lanes(FULL_FRACTIONS, zero))
        memory = initial_memory(case.settings, joints, states)
        begun = rest, gather(joints, lines), gather(joints, shares), memory
        write_lanes(arrays.carry[:, first : first + lanes], begun)


@portable_kernel(in_lanes=True)
def renew_noise(case_like, carry_like, arrays, ziggurat):
    """Start the noise of all arms from its hashed seeds in `arrays.streams`, and write what is seen with it.

    Args: `Like` of a `Case` and of an `ArmCarry`; `BatchArrays`; `Ziggurat`.
    """
    lanes = width(case_like, arrays.parameters)
    for first in range(0, len(arrays.cycles), lanes):
        case = read_lanes(case_like, arrays.parameters[:, first:])
        zero = 0.0 * case.air.ambient_pressure
        for arm in range(first, first + lanes):
            seed_stream(arrays.streams, arm)
            fill_cycle(arrays.streams, ziggurat, arrays.noise, 0, arm)
        _see(case, slots(read_lanes(carry_like, arrays.carry[:, first:], zero).states), arrays, first, zero)


@composition
def _is_first_of_its_cycle(cycles, first, arm):
    """Return whether no arm from `first` up to this one has begun as many cycles."""
    earlier = 0
    for other in range(first, arm):
        earlier += cycles[other] == cycles[arm]
    return earlier == 0


@composition
def _start_waves(joints, waves, cycles, scratch, first, cycle, h, zero):
    """Write the waves of the valves' drivers at the start of each arm's cycle into their slots.

    A time is a number, the same in all lanes, since in lanes of single precision it would be rounded. So the waves are
    computed for every distinct time, and each lane takes those of its own.
    """
    lanes = width(zero)
    for arm in range(first, first + lanes):
        if _is_first_of_its_cycle(cycles, first, arm):
            for lane in range(lanes):
                scratch[0, lane] = 1.0 if cycles[first + lane] == cycles[arm] else 0.0
            chosen = read_lanes(0.0, scratch, zero) > 0.0
            for j in range(len(joints)):
                wave = start_wave(joints[j].valve, cycle * cycles[arm], h)
                waves[j] = select_leaves(chosen, wave, waves[j])


@composition
def _are_sound(states):
    """Return whether no joint (slots) has diverged."""
    sound = is_sound(states[0])
    for j in range(1, len(states)):
        sound = sound & is_sound(states[j])
    return sound


@composition
def _hold_diverged(sound, arrays, scratch, first, zero):
    """Mark arms that have diverged, and return which lanes go on."""
    write_lanes(scratch[:, : width(zero)], select(sound, zero + 1.0, zero))
    for lane in range(width(zero)):
        if scratch[0, lane] == 0.0:
            arrays.diverged[first + lane] = True
        if arrays.diverged[first + lane]:
            scratch[0, lane] = 0.0
    return read_lanes(0.0, scratch, zero) > 0.0


@composition
def _step_lanes(case_like, carry_like, arrays, timing, ziggurat, scratch, first):
    """Move the arms of a group of lanes by one control cycle."""
    case = read_lanes(case_like, arrays.parameters[:, first:])
    like, zero, h = case.joints, 0.0 * case.air.ambient_pressure, timing.cycle / timing.steps
    carry = read_lanes(carry_like, arrays.carry[:, first:], zero)
    joints, states = slots(like), slots(carry.states)
    loop = LoopState(
        slots(like, in_lanes(ZERO_JOINT_SIGNALS, zero)),
        slots(like, in_lanes(NO_INJECTION, zero)),
        slots(like, in_lanes(ZERO_NOISE, zero)),
        slots(like, Drive(zero, zero, zero, zero)),
        slots(carry.lines),
        slots(like, start_wave(joints[0].valve, 0.0, h)),
        slots(like, zero),
        slots(carry.shares),
    )
    for j in range(len(like)):
        loop.acting[j] = read_lanes(ZERO_JOINT_SIGNALS, arrays.acting[j, :, first:], zero)
        loop.injections[j] = read_lanes(NO_INJECTION, arrays.injections[j, :, first:], zero)
    _read_noise(arrays, loop.noise, first, zero)
    _start_waves(joints, loop.waves, arrays.cycles, scratch, first, timing.cycle, h, zero)
    around = surroundings(case.air, read_lanes(ZERO_SHARED_SIGNALS, arrays.shared[:, first:], zero))
    _, memory, report = control_cycle(joints, case.settings, carry.memory, states, loop, around, timing.cycle)
    advance_arm(case.arm, pack_joints(case.arm, joints), states, loop.drives, loop.waves, around, h, timing.steps)
    moved = ArmCarry(
        gather(like, states), gather(like, loop.lines), gather(like, loop.shares), memory,
        gather(like, loop.voltages), report,
    )  # fmt: skip
    goes_on = _hold_diverged(_are_sound(states), arrays, scratch, first, zero)
    after = select_leaves(goes_on, moved, carry)
    write_lanes(arrays.carry[:, first : first + width(zero)], after)
    for arm in range(first, first + width(zero)):
        if not arrays.diverged[arm]:
            arrays.cycles[arm] += 1
            fill_cycle(arrays.streams, ziggurat, arrays.noise, 0, arm)
    _see(case, slots(after.states), arrays, first, zero)


@portable_kernel(in_lanes=True)
def step_arms(case_like, carry_like, arrays, timing, ziggurat, scratch, first, last, cycles):
    """Move arms by some control cycles; an arm that diverges keeps its state from before, and is marked.

    Args: `Like` of a `Case` and of an `ArmCarry`; `BatchArrays`; `Timing`; `Ziggurat`; work array, (1, lanes); numbers
    of the first arm and of the one after the last, which bound whole groups of lanes; number of control cycles.
    """
    lanes = width(case_like, arrays.parameters)
    for group in range(first, last, lanes):
        for _ in range(cycles):
            _step_lanes(case_like, carry_like, arrays, timing, ziggurat, scratch, group)
