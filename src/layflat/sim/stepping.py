"""Kernels that advance a plant by any number of steps and keep its state from call to call.

Python passes arrays of numbers: named tuples of a whole machine would take several times as long as the physics of a
control cycle.
"""

from typing import Any, NamedTuple

from layflat.arrays import Array
from layflat.jit import law, portable_kernel
from layflat.lanes import read_numbers, slots, write_numbers
from layflat.physics.adjustable import FULL_FRACTIONS, DriveFractions, adjust_fractions, regulated_pressure
from layflat.physics.driven import DrivenInputs, DrivenOutputs, leak_through_hole
from layflat.physics.driver import ZERO_COMMANDS, CommandDelayLine
from layflat.physics.joint import Drive, JointParameters, JointState, Surroundings, is_sound
from layflat.physics.plant import advance_arm, pack_joints, states_at_rest
from layflat.physics.valves import driven_opening, start_wave, weaken_wave
from layflat.sim.loop import Noise, sense

ZERO_INPUTS = DrivenInputs(*[0.0] * len(DrivenInputs._fields))


class PlantSetting(NamedTuple):
    """Parameters of a plant that stay constant while it is advanced."""

    arm: Any
    joints: tuple[JointParameters, ...]
    cycle: float  # s
    around: Surroundings


class JointCarry(NamedTuple):
    """State of a joint that is carried from call to call."""

    state: JointState
    wave: Any  # dither or carrier of the coming step
    line: CommandDelayLine
    opening: float  # to which the valve is driven, -1..1
    means: DriveFractions  # of brake, dither and supply in this control cycle
    shares: DriveFractions  # at the start of the coming control cycle


@law
def joint_carry_at_rest(joint, state, h):
    """Return what is carried of a joint in a state of rest."""
    wave = start_wave(joint.valve, 0.0, h)
    return JointCarry(state, wave, ZERO_COMMANDS, 0.0, FULL_FRACTIONS, FULL_FRACTIONS)


def carry_at_rest(setting: PlantSetting, angles: Array, pressures: Array, h: float) -> list[JointCarry]:
    """Return the state of all joints at rest.

    Args:
        setting: parameters of the plant.
        angles: (joints,), rad.
        pressures: pressures of hoses A and B, (joints, 2), absolute, Pa; NaN for those that hold the arm.
        h: time step of the plant, s.
    """
    firsts, seconds = (tuple(column) for column in pressures.T.tolist())
    states = states_at_rest(setting.arm, setting.joints, tuple(angles.tolist()), firsts, seconds, setting.around)
    joined = zip(setting.joints, states, strict=True)
    return [joint_carry_at_rest(joint, state, h) for joint, state in joined]


@law
def _leak_air(joint, state, inputs, p_a):
    """Return a joint's state after a step with air lost through the holes of its hoses."""
    return JointState(
        state.motion,
        state.valve,
        leak_through_hole(joint.hose_a, state.hose_a, inputs.hole_a, p_a),
        leak_through_hole(joint.hose_b, state.hose_b, inputs.hole_b, p_a),
        state.ledger,
    )


@law
def _drive_of(joint, inputs, opening, means, around):
    """Return the drive of a joint, with mean fractions of brake and supply."""
    supply = regulated_pressure(means.supply, around.supply_pressure, around.ambient_pressure)
    return Drive(opening, means.brake * joint.brake_torque, inputs.load, supply)


@portable_kernel(results=2)
def move(setting_like, carry_like, setting, carries, inputs, outputs, steps, step, last, due):
    """Advance a plant from `step` to step `last`.

    Args: `Like` of a `PlantSetting` and of a `JointCarry`; numbers of the first; those of `JointCarry`, `DrivenInputs`
    and `DrivenOutputs`, a row per joint; steps per control cycle; number of the present step, and of the last one;
    steps until the voltages reach the valves' delay lines, which count these, below zero if the voltages are new.
    Returns the rest of these steps, and the first joint that diverged (-1: none).
    """
    arm, all_joints, cycle, around = read_numbers(setting_like, setting)
    n, h, p_a = len(carries), cycle / steps, around.ambient_pressure
    before, acting = read_numbers(carry_like, carries[0]), read_numbers(ZERO_INPUTS, inputs[0])
    joints = slots(all_joints)
    joined = pack_joints(arm, joints)
    states, waves = slots(all_joints, before.state), slots(all_joints, before.wave)
    lines, acts = slots(all_joints, before.line), slots(all_joints, acting)
    means, shares = slots(all_joints, before.means), slots(all_joints, before.shares)
    drives = slots(all_joints, _drive_of(joints[0], acting, before.opening, before.means, around))
    leaks = acting.hole_a + acting.hole_b > 0.0
    for j in range(1, n):
        before, acts[j] = read_numbers(carry_like, carries[j]), read_numbers(ZERO_INPUTS, inputs[j])
        states[j], waves[j], lines[j] = before.state, before.wave, before.line
        means[j], shares[j] = before.means, before.shares
        drives[j] = _drive_of(joints[j], acts[j], before.opening, before.means, around)
        leaks = leaks or acts[j].hole_a + acts[j].hole_b > 0.0
    diverged = -1
    while step < last and diverged < 0:
        if due <= 0:
            for j in range(n):
                opening, lines[j] = driven_opening(joints[j].valve, lines[j], acts[j].voltage, cycle)
                demand = DriveFractions(acts[j].brake, acts[j].dither, acts[j].supply)
                means[j], shares[j] = adjust_fractions(joints[j].adjustables, shares[j], demand, cycle)
                drives[j] = _drive_of(joints[j], acts[j], opening, means[j], around)
            # A caller that drives once per cycle, but not on time, counts once per cycle; else voltages hold.
            due = steps + (steps // 2 if due < 0 else 0)
        if step % steps == 0:
            for j in range(n):
                valve = joints[j].valve
                waves[j] = weaken_wave(valve, start_wave(valve, cycle * (step // steps), h), means[j].dither)
        until = step + 1 if leaks else min(last, (step // steps + 1) * steps, step + due)
        advance_arm(arm, joined, states, drives, waves, around, h, until - step)
        due, step = due - (until - step), until
        for j in range(n):
            if leaks:
                states[j] = _leak_air(joints[j], states[j], acts[j], p_a)
            if diverged < 0 and not is_sound(states[j]):
                diverged = j
    for j in range(n):
        state = states[j]
        write_numbers(carries[j], JointCarry(state, waves[j], lines[j], drives[j].opening, means[j], shares[j]))
        a, b = state.hose_a.pressure, state.hose_b.pressure
        write_numbers(outputs[j], DrivenOutputs(state.motion.angle, state.motion.velocity, a, b))
    return due, diverged


@portable_kernel()
def sample(setting_like, carry_like, setting, carries, noise, out):
    """Write the sensors' angles (rad) and differential pressures (Pa) to `out`, (2, joints).

    Args: as the first four of `move`; standard normal samples, (joints, 2); the readings, which are filled.
    """
    joints = slots(read_numbers(setting_like, setting).joints)
    for j in range(len(carries)):
        state = read_numbers(carry_like, carries[j]).state
        out[0, j], out[1, j] = sense(joints[j], state, Noise(noise[j, 0], noise[j, 1]))
