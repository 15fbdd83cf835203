"""The joints' halves of a step of MuJoCo's: what valve, air, losses and stops do before and after the arm is moved.

MuJoCo's integrators move angles by the new velocities: q' = q + H v'. That is our own step (physics/step.py, drift -
kick - drift) seen from its middles: MuJoCo's angles are those half a step ahead, and the joint's are q - H v/2.
Nothing is lost: from rest on, both are the same, and of second order.

A step H of MuJoCo's that is longer than ours is cut into an odd number of steps h: the arm is kicked in the middle of
the one in the middle, the others coast with its velocity.

What crosses from Python is arrays of numbers, a row a joint, as in sim/stepping.py.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from layflat.jit import composition, kernel
from layflat.lanes import mapped, read_numbers, write_numbers
from layflat.physics.delay import Line
from layflat.physics.driven import Outputs, through_hole
from layflat.physics.friction import levels
from layflat.physics.joint import JointState, Motion, Surroundings, is_sound
from layflat.physics.sensor import read_sensor
from layflat.physics.step import Running, finish, midpoint, pack, unpack
from layflat.physics.valves import driven, start_wave, turn_wave


class Carry(NamedTuple):
    """State of a joint that is kept from step to step."""

    state: JointState
    line: Line
    opening: float  # to which the valve is driven, -1..1


class Span(NamedTuple):
    """A step of MuJoCo's: when it begins (s), the step that it is cut into (s), and how many come before the kick."""

    time: float
    step: float
    before: float


class Kernels(NamedTuple):
    """Compiled for a kind of joint. The first arguments are rows of numbers: of `Joint`, and of `Carry`.

    MuJoCo's arrays are handed over whole, with the places and degrees of freedom of the joints in them (`at`,
    (2, n)).
    """

    command: Callable[..., None]
    """`command(joints, kept, voltages, cycle)`: the valves' drivers take voltages for a control cycle (s)."""
    push: Callable[..., None]
    """`push(joints, kept, around, span, at, qpos, qvel, applied, loads, brakes, kick)`: write into the rows of `kick`
    (5, n) angles (rad), velocities (rad/s) and torques (N m) at the kick, and the torques of friction when sliding and
    when held (N m) with the torques of the brakes; add the torques and outer loads (N m) to what is applied.
    The velocities in `qvel` become those that Coriolis forces are to be taken at. No joint moves on yet."""
    settle: Callable[..., int]
    """`settle(joints, kept, around, span, at, qpos, qvel, kick, braked, loads, holes, seen)`: stop the joints of which
    the brakes left the velocity 0.0 where they were, and move on through the step; the brakes' impulses (N m s, with
    the velocities in `braked`, (2, n)) and outer loads are booked, hoses lose air through holes. Writes rows of
    `Outputs`; returns the joint that diverged (-1: none)."""
    sample: Callable[..., None]
    """`sample(joints, seen, noise, out)`: what the sensors say, angles and differential pressures, (2, n)."""


@composition
def _coast(joint, running, opening, wave, around, h):
    # A step with the velocity that is there.
    mid = midpoint(joint, running, opening, wave, around, h)
    motion = running.motion
    after = finish(joint, running, mid, motion.velocity, 0.0, 0.0, h)
    kept = Motion(after.motion.angle, motion.velocity, motion.velocity_change)
    return Running(kept, after.valve, after.hoses, after.ledger)


@composition
def _to_kick(joint, kept, around, span, q, v):
    # Up to the kick at angle q: the state before the step in the middle, that step's wave, and its middle.
    h, running = span.step, pack(kept.state)
    wave = start_wave(joint.valve, span.time, h)
    begin = Motion(q - (span.before + 0.5) * h * v, v, running.motion.velocity_change)
    running = Running(begin, running.valve, running.hoses, running.ledger)
    for _ in range(int(span.before)):
        running = _coast(joint, running, kept.opening, wave, around, h)
        wave = turn_wave(joint.valve, wave)
    return running, wave, midpoint(joint, running, kept.opening, wave, around, h)


@composition
def _through(joint, kept, around, span, q, v, after, impulse, load):
    running, wave, mid = _to_kick(joint, kept, around, span, q, v)
    running = finish(joint, running, mid, after, impulse, load, span.step)
    # What the velocity changed by leads the damping of the next step.
    for _ in range(int(span.before)):
        wave = turn_wave(joint.valve, wave)
        running = _coast(joint, running, kept.opening, wave, around, span.step)
    return unpack(running)


@composition
def _leaked(joint, state, hole_a, hole_b, p_a):
    a = through_hole(joint.hose_a, state.hose_a, hole_a, p_a) if hole_a > 0.0 else state.hose_a
    b = through_hole(joint.hose_b, state.hose_b, hole_b, p_a) if hole_b > 0.0 else state.hose_b
    return JointState(state.motion, state.valve, a, b, state.ledger)


@kernel
def extrapolate(dofs, v, bias, extrapolated, applied, qvel):
    """Apply what Coriolis forces change by where velocities are extrapolated, and give the joints their own ones back.

    Args: joints' degrees of freedom and velocities (n,); forces at velocities that are not extrapolated, and that are,
    (nv,); what is applied, and the velocities in the data, (nv,).
    """
    for i in range(len(extrapolated)):
        applied[i] += bias[i] - extrapolated[i]
    for j in range(len(v)):
        qvel[dofs[j]] = v[j]


_known: dict[str, Kernels] = {}


def halves_of(joint: Any, kept: Carry) -> Kernels:
    """Kernels for joints whose numbers make up such tuples (of plain floats)."""
    # By text: tuples of different classes are equal where their items are.
    joint, kept = (mapped(like, lambda _: 0.0) for like in (joint, kept))
    kind = repr((joint, kept))
    if kind not in _known:
        _known[kind] = Kernels(*_compiled(joint, kept))
    return _known[kind]


def _compiled(joint_like, kept_like):
    around_like, span_like = Surroundings(0.0, 0.0, 0.0, 0.0, 0.0), Span(0.0, 0.0, 0.0)

    @kernel
    def command(joints, kept, voltages, cycle):
        for j in range(len(joints)):
            joint, before = read_numbers(joint_like, joints[j]), read_numbers(kept_like, kept[j])
            opening, line = driven(joint.valve, before.line, voltages[j], cycle)
            write_numbers(kept[j], Carry(before.state, line, opening))

    @kernel
    def push(joints, kept, around, span, at, qpos, qvel, applied, loads, brakes, kick):
        places, dofs, q, v, torques = at[0], at[1], kick[0], kick[1], kick[2]
        air, cut = read_numbers(around_like, around), read_numbers(span_like, span)
        for j in range(len(joints)):
            joint, before = read_numbers(joint_like, joints[j]), read_numbers(kept_like, kept[j])
            q[j], v[j] = qpos[places[j]], qvel[dofs[j]]
            _, _, mid = _to_kick(joint, before, air, cut, q[j], v[j])
            torques[j] = mid.torque
            kick[3, j], kick[4, j] = levels(joint.friction, brakes[j], v[j], mid.velocity, mid.pull)
            applied[dofs[j]] += mid.torque + loads[j]
            qvel[dofs[j]] = v[j] + 0.5 * before.state.motion.velocity_change

    @kernel
    def settle(joints, kept, around, span, at, qpos, qvel, kick, braked, loads, holes, seen):
        places, dofs, q, v, impulses, after = at[0], at[1], kick[0], kick[1], braked[0], braked[1]
        air, cut = read_numbers(around_like, around), read_numbers(span_like, span)
        diverged = -1
        for j in range(len(joints)):
            joint, before = read_numbers(joint_like, joints[j]), read_numbers(kept_like, kept[j])
            if after[j] == 0.0:
                qpos[places[j]], qvel[dofs[j]] = q[j], 0.0
            state = _through(joint, before, air, cut, q[j], v[j], qvel[dofs[j]], impulses[j], loads[j])
            state = _leaked(joint, state, holes[j, 0], holes[j, 1], air.ambient_pressure)
            if not is_sound(state):
                diverged = j
            write_numbers(kept[j], Carry(state, before.line, before.opening))
            motion = state.motion
            write_numbers(seen[j], Outputs(motion.angle, motion.velocity, state.hose_a.pressure, state.hose_b.pressure))
        return diverged

    @kernel
    def sample(joints, seen, noise, out):
        for j in range(len(joints)):
            joint = read_numbers(joint_like, joints[j])
            out[0, j] = read_sensor(joint.angle_sensor, seen[j, 0], noise[j, 0])
            out[1, j] = read_sensor(joint.pressure_sensor, seen[j, 2] - seen[j, 3], noise[j, 1])

    return command, push, settle, sample
