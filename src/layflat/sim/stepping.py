"""Kernels that advance a plant by any number of steps and keep its state from call to call.

Python passes arrays of numbers: named tuples of a whole machine would take several times as long as the physics of a
control cycle. A compiled kernel must know which tuple the numbers form, so each kind of machine has its own kernels.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from layflat.arrays import Array
from layflat.jit import kernel, law
from layflat.lanes import mapped, read_numbers, slots, write_numbers
from layflat.physics.driven import DrivenInputs, DrivenOutputs, leak_through_hole
from layflat.physics.driver import ZERO_COMMANDS, CommandDelayLine
from layflat.physics.joint import Drive, JointParameters, JointState, Surroundings, is_sound
from layflat.physics.plant import advance_arm, pack_joints, states_at_rest
from layflat.physics.valves import driven_opening, start_wave
from layflat.sim.loop import Noise, sense


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


class PlantKernels(NamedTuple):
    """Compiled kernels of one kind of machine."""

    move: Callable[..., tuple[int, int]]
    """`move(setting, carries, inputs, outputs, steps, step, last, due)` advances from `step` to step `last`.

    Args: the numbers of a `PlantSetting`; those of `JointCarry`, `Inputs` and `Outputs`, a row per joint; steps per
    control cycle; number of the present step, and of the last one; steps until the voltages reach the valves' delay
    lines, which count these, below zero if the voltages are new.
    Returns the rest of these steps, and the joint that diverged (-1: none).
    """
    sample: Callable[..., None]
    """`sample(setting, carries, noise, out)` writes the sensors' angles (rad) and differential pressures (Pa) to `out`.

    Args: the numbers of a `PlantSetting`; those of `JointCarry`, a row per joint; standard normal samples, (joints, 2);
    the readings, (2, joints), which are filled.
    """


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
    return [JointCarry(state, start_wave(joint.valve, 0.0, h), ZERO_COMMANDS, 0.0) for joint, state in joined]


_compiled_kernels: dict[str, PlantKernels] = {}


def plant_kernels(setting: PlantSetting, carry: JointCarry) -> PlantKernels:
    """Return the kernels of machines whose numbers form tuples of these types, made once for each."""
    setting, carry = (mapped(like, lambda _: 0.0) for like in (setting, carry))
    # By text: tuples of different classes compare equal if their items do.
    kind = repr((setting, carry))
    if kind not in _compiled_kernels:
        _compiled_kernels[kind] = PlantKernels(_make_move(setting, carry), _make_sample(setting, carry))
    return _compiled_kernels[kind]


def _make_move(setting_like, carry_like):
    """Return the kernel `PlantKernels.move` for plants whose numbers form tuples like these."""
    inputs_like = DrivenInputs(0.0, 0.0, 0.0, 0.0)

    @kernel
    def move(setting, carries, inputs, outputs, steps, step, last, due):
        """Kernel of `PlantKernels.move`."""
        arm, all_joints, cycle, around = read_numbers(setting_like, setting)
        n, h, p_a = len(carries), cycle / steps, around.ambient_pressure
        before, acting = read_numbers(carry_like, carries[0]), read_numbers(inputs_like, inputs[0])
        joints = slots(all_joints)
        joined = pack_joints(arm, joints)
        states, waves = slots(all_joints, before.state), slots(all_joints, before.wave)
        lines, acts = slots(all_joints, before.line), slots(all_joints, acting)
        drives = slots(all_joints, Drive(before.opening, joints[0].brake_torque, acting.load, around.supply_pressure))
        leaks = acting.hole_a + acting.hole_b > 0.0
        for j in range(1, n):
            before, acts[j] = read_numbers(carry_like, carries[j]), read_numbers(inputs_like, inputs[j])
            states[j], waves[j], lines[j] = before.state, before.wave, before.line
            drives[j] = Drive(before.opening, joints[j].brake_torque, acts[j].load, around.supply_pressure)
            leaks = leaks or acts[j].hole_a + acts[j].hole_b > 0.0
        diverged = -1
        while step < last and diverged < 0:
            if due <= 0:
                for j in range(n):
                    opening, lines[j] = driven_opening(joints[j].valve, lines[j], acts[j].voltage, cycle)
                    drives[j] = Drive(opening, drives[j].brake_torque, drives[j].load_torque, around.supply_pressure)
                # A caller that drives once per cycle, but not on time, counts once per cycle; else voltages hold.
                due = steps + (steps // 2 if due < 0 else 0)
            if step % steps == 0:
                for j in range(n):
                    waves[j] = start_wave(joints[j].valve, cycle * (step // steps), h)
            until = step + 1 if leaks else min(last, (step // steps + 1) * steps, step + due)
            advance_arm(arm, joined, states, drives, waves, around, h, until - step)
            due, step = due - (until - step), until
            for j in range(n):
                if leaks:
                    states[j] = _leak_air(joints[j], states[j], acts[j], p_a)
                if not is_sound(states[j]):
                    diverged = j
        for j in range(n):
            state = states[j]
            write_numbers(carries[j], JointCarry(state, waves[j], lines[j], drives[j].opening))
            a, b = state.hose_a.pressure, state.hose_b.pressure
            write_numbers(outputs[j], DrivenOutputs(state.motion.angle, state.motion.velocity, a, b))
        return due, diverged

    return move


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


def _make_sample(setting_like, carry_like):
    """Return the kernel `PlantKernels.sample` for plants whose numbers form tuples like these."""

    @kernel
    def sample(setting, carries, noise, out):
        """Kernel of `PlantKernels.sample`."""
        joints = slots(read_numbers(setting_like, setting).joints)
        for j in range(len(carries)):
            state = read_numbers(carry_like, carries[j]).state
            out[0, j], out[1, j] = sense(joints[j], state, Noise(noise[j, 0], noise[j, 1]))

    return sample
