"""A machine moved on by any number of steps at a time: the plant of `kernel.py`, its state kept from call to call.

What crosses from Python is arrays of numbers: named tuples of a whole machine would take several times as long as the
physics of a control cycle. A compiled kernel has to know which tuple the numbers are, so there is one for each kind of
machine.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from layflat.arrays import Array
from layflat.jit import kernel, law
from layflat.lanes import mapped, read_numbers, slots, write_numbers
from layflat.physics.delay import NOTHING_ASKED, Line
from layflat.physics.driven import Inputs, Outputs, through_hole
from layflat.physics.joint import Drive, Joint, JointState, Surroundings, is_sound
from layflat.physics.plant import advance, at_rest, together
from layflat.physics.valves import driven, start_wave
from layflat.sim.cycle import Noise, sense


class Setting(NamedTuple):
    """Setting that holds while a plant is moved on."""

    arm: Any
    joints: tuple[Joint, ...]
    cycle: float  # s
    around: Surroundings


class Carry(NamedTuple):
    """State of a joint that is kept from call to call."""

    state: JointState
    wave: Any  # dither or carrier of the coming step
    line: Line
    opening: float  # to which the valve is driven, -1..1


class Stepping(NamedTuple):
    """The kernels of a kind of machine."""

    move: Callable[..., tuple[int, int]]
    """`move(setting, kept, given, seen, steps, at, last, due)` moves on from step `at` to step `last`.

    Args: the numbers of a `Setting`; those of `Carry`, `Inputs` and `Outputs`, a row a joint; steps per control cycle;
    steps until the voltages are handed on (the valves' delay counts these), below zero if they are new.
    Returns what is then left of these steps, and the joint that diverged (-1: none).
    """
    sample: Callable[..., None]
    """`sample(setting, kept, noise, out)` writes what the sensors say, angles and differential pressures, into
    out (2, joints); noise: standard normal samples, (joints, 2)."""


def kept_at_rest(setting: Setting, angles: Array, pressures: Array, h: float) -> list[Carry]:
    """All joints at rest at angles (joints,), rad, for steps of h (s).

    Pressures in hoses A and B, (joints, 2), are absolute, Pa; where they are not numbers they are what holds the arm.
    """
    firsts, seconds = (tuple(column) for column in pressures.T.tolist())
    states = at_rest(setting.arm, setting.joints, tuple(angles.tolist()), firsts, seconds, setting.around)
    joined = zip(setting.joints, states, strict=True)
    return [Carry(state, start_wave(joint.valve, 0.0, h), NOTHING_ASKED, 0.0) for joint, state in joined]


_known: dict[str, Stepping] = {}


def stepping(setting: Setting, kept: Carry) -> Stepping:
    """Kernels for machines whose numbers make up such tuples."""
    setting, kept = (mapped(like, lambda _: 0.0) for like in (setting, kept))
    # By text: tuples of different classes are equal where their items are.
    kind = repr((setting, kept))
    if kind not in _known:
        _known[kind] = Stepping(_mover(setting, kept), _sampler(setting, kept))
    return _known[kind]


def _mover(setting_like, kept_like):
    given_like = Inputs(0.0, 0.0, 0.0, 0.0)

    @kernel
    def move(setting, kept, given, seen, steps, at, last, due):
        arm, all_joints, cycle, around = read_numbers(setting_like, setting)
        n, h, p_a = len(kept), cycle / steps, around.ambient_pressure
        before, acting = read_numbers(kept_like, kept[0]), read_numbers(given_like, given[0])
        joints = slots(all_joints)
        joined = together(arm, joints)
        states, waves = slots(all_joints, before.state), slots(all_joints, before.wave)
        lines, acts = slots(all_joints, before.line), slots(all_joints, acting)
        drives = slots(all_joints, Drive(before.opening, joints[0].brake_torque, acting.load, around.supply_pressure))
        leaks = acting.hole_a + acting.hole_b > 0.0
        for j in range(1, n):
            before, acts[j] = read_numbers(kept_like, kept[j]), read_numbers(given_like, given[j])
            states[j], waves[j], lines[j] = before.state, before.wave, before.line
            drives[j] = Drive(before.opening, joints[j].brake_torque, acts[j].load, around.supply_pressure)
            leaks = leaks or acts[j].hole_a + acts[j].hole_b > 0.0
        diverged = -1
        while at < last and diverged < 0:
            if due <= 0:
                for j in range(n):
                    opening, lines[j] = driven(joints[j].valve, lines[j], acts[j].voltage, cycle)
                    drives[j] = Drive(opening, drives[j].brake_torque, drives[j].load_torque, around.supply_pressure)
                # Who drives in every cycle, but not to the instant, counts once a cycle; who stops is held.
                due = steps + (steps // 2 if due < 0 else 0)
            if at % steps == 0:
                for j in range(n):
                    waves[j] = start_wave(joints[j].valve, cycle * (at // steps), h)
            until = at + 1 if leaks else min(last, (at // steps + 1) * steps, at + due)
            advance(arm, joined, states, drives, waves, around, h, until - at)
            due, at = due - (until - at), until
            for j in range(n):
                if leaks:
                    states[j] = _leaked(joints[j], states[j], acts[j], p_a)
                if not is_sound(states[j]):
                    diverged = j
        for j in range(n):
            state = states[j]
            write_numbers(kept[j], Carry(state, waves[j], lines[j], drives[j].opening))
            a, b = state.hose_a.pressure, state.hose_b.pressure
            write_numbers(seen[j], Outputs(state.motion.angle, state.motion.velocity, a, b))
        return due, diverged

    return move


@law
def _leaked(joint, state, given, p_a):
    return JointState(
        state.motion,
        state.valve,
        through_hole(joint.hose_a, state.hose_a, given.hole_a, p_a),
        through_hole(joint.hose_b, state.hose_b, given.hole_b, p_a),
        state.ledger,
    )


def _sampler(setting_like, kept_like):
    @kernel
    def sample(setting, kept, noise, out):
        joints = slots(read_numbers(setting_like, setting).joints)
        for j in range(len(kept)):
            state = read_numbers(kept_like, kept[j]).state
            out[0, j], out[1, j] = sense(joints[j], state, Noise(noise[j, 0], noise[j, 1]))

    return sample
