"""The joints' part of a MuJoCo step: valve, air, losses and stops, before and after the arm moves.

MuJoCo's integrators move angles by the new velocities: q' = q + H v'. That is our own step (physics/step.py, drift -
kick - drift) seen from its middles: MuJoCo's angles are those half a step ahead, and the joint's are q - H v/2.
Nothing is lost: from rest on, both are the same, and of second order.

A step H of MuJoCo's that is longer than ours is cut into an odd number of steps h: the arm is kicked in the middle of
the one in the middle, the others coast with its velocity.

Python passes arrays of numbers, a row a joint, as in sim/stepping.py.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from layflat.jit import composition, kernel
from layflat.lanes import mapped, read_numbers, write_numbers
from layflat.physics.driven import DrivenOutputs, leak_through_hole
from layflat.physics.driver import CommandDelayLine
from layflat.physics.friction import slip_torques
from layflat.physics.joint import JointMotion, JointState, Surroundings, is_sound
from layflat.physics.sensor import read_sensor
from layflat.physics.step import PackedState, advance_to_midpoint, finish_step, pack_hoses, unpack_hoses
from layflat.physics.valves import driven_opening, start_wave, turn_wave


class CarriedState(NamedTuple):
    """State of a joint that is carried from step to step."""

    state: JointState
    line: CommandDelayLine
    opening: float  # to which the valve is driven, -1..1


class StepSpan(NamedTuple):
    """MuJoCo step: start time (s), length of its substeps (s), and number of substeps before the kick."""

    time: float
    step: float
    before: float


class JointKernels(NamedTuple):
    """Kernels for a class of joint. Their first arguments are rows of numbers: `JointParameters` and `CarriedState`.

    MuJoCo's arrays are whole, with the positions and degrees of freedom of the joints in them (`at`, (2, n)).
    """

    command: Callable[..., None]
    """`command(joints, kept, voltages, cycle)`: set the voltages of the valves' drivers for a control cycle (s)."""
    push: Callable[..., None]
    """`push(joints, kept, around, span, at, qpos, qvel, applied, loads, brakes, kick)`: write into the rows of `kick`
    (5, n) angles (rad), velocities (rad/s) and torques (N m) at the kick, and the torques of friction when sliding and
    when held (N m) with the torques of the brakes; add the torques and outer loads (N m) to what is applied.
    The velocities in `qvel` become those that Coriolis forces are to be taken at. No joint moves on yet."""
    settle: Callable[..., int]
    """`settle(joints, kept, around, span, at, qpos, qvel, kick, braked, loads, holes, seen)`: stop the joints of which
    the brakes left the velocity 0.0 where they were, and move on through the step; the brakes' impulses (N m s, with
    the velocities in `braked`, (2, n)) and outer loads are booked, hoses lose air through holes. Writes rows of
    `DrivenOutputs`; returns the joint that diverged (-1: none)."""
    sample: Callable[..., None]
    """`sample(joints, seen, noise, out)`: write the sensors' readings, angles and differential pressures, (2, n)."""


@composition
def _coast(joint, running, opening, wave, around, h):
    """Return a joint's state after a substep of h (s) at constant velocity."""
    mid = advance_to_midpoint(joint, running, opening, wave, around, h)
    motion = running.motion
    after = finish_step(joint, running, mid, motion.velocity, 0.0, 0.0, h)
    kept = JointMotion(after.motion.angle, motion.velocity, motion.velocity_change)
    return PackedState(kept, after.valve, after.hoses, after.ledger)


@composition
def _advance_to_kick(joint, kept, around, span, q, v):
    """Return the state before the middle substep, that substep's wave, and its midpoint.

    The kick is the velocity change in the middle of a step, at the angle q (rad); v (rad/s) is the velocity before it.
    """
    h, running = span.step, pack_hoses(kept.state)
    wave = start_wave(joint.valve, span.time, h)
    begin = JointMotion(q - (span.before + 0.5) * h * v, v, running.motion.velocity_change)
    running = PackedState(begin, running.valve, running.hoses, running.ledger)
    for _ in range(int(span.before)):
        running = _coast(joint, running, kept.opening, wave, around, h)
        wave = turn_wave(joint.valve, wave)
    return running, wave, advance_to_midpoint(joint, running, kept.opening, wave, around, h)


@composition
def _advance_step(joint, kept, around, span, q, v, after, impulse, load):
    """Return a joint's unpacked state after a whole step, with the velocity `after` (rad/s) from the kick on.

    Args: as `_advance_to_kick`; `impulse` of the brake (N m s) and outer `load` (N m), which are booked.
    """
    running, wave, mid = _advance_to_kick(joint, kept, around, span, q, v)
    running = finish_step(joint, running, mid, after, impulse, load, span.step)
    # The change of the velocity is extrapolated in the damping of the next step.
    for _ in range(int(span.before)):
        wave = turn_wave(joint.valve, wave)
        running = _coast(joint, running, kept.opening, wave, around, span.step)
    return unpack_hoses(running)


@composition
def _leak_hoses(joint, state, hole_a, hole_b, p_a):
    """Return a joint's state after its hoses lost fractions hole_a, hole_b of their gauge pressure; ambient p_a, Pa."""
    a = leak_through_hole(joint.hose_a, state.hose_a, hole_a, p_a) if hole_a > 0.0 else state.hose_a
    b = leak_through_hole(joint.hose_b, state.hose_b, hole_b, p_a) if hole_b > 0.0 else state.hose_b
    return JointState(state.motion, state.valve, a, b, state.ledger)


@kernel
def extrapolate(dofs, v, bias, extrapolated, applied, qvel):
    """Apply the change of Coriolis forces due to extrapolated velocities, and restore the joints' velocities.

    Args: joints' degrees of freedom and velocities (n,); forces at velocities that are not extrapolated, and that are,
    (nv,); applied forces and velocities in the data, (nv,).
    """
    for i in range(len(extrapolated)):
        applied[i] += bias[i] - extrapolated[i]
    for j in range(len(v)):
        qvel[dofs[j]] = v[j]


_kernels_by_type: dict[str, JointKernels] = {}


def joint_kernels(joint: Any, kept: CarriedState) -> JointKernels:
    """Return the kernels for joints whose parameters and states have the structure of these tuples."""
    # By text: tuples of different classes are equal where their items are.
    joint, kept = (mapped(like, lambda _: 0.0) for like in (joint, kept))
    kind = repr((joint, kept))
    if kind not in _kernels_by_type:
        _kernels_by_type[kind] = JointKernels(*_build_kernels(joint, kept))
    return _kernels_by_type[kind]


def _build_kernels(joint_like, kept_like):
    """Return the compiled kernels of `JointKernels` for one class of joint parameters and state."""
    around_like, span_like = Surroundings(0.0, 0.0, 0.0, 0.0, 0.0), StepSpan(0.0, 0.0, 0.0)

    @kernel
    def command(joints, kept, voltages, cycle):
        """Kernel of `JointKernels.command`."""
        for j in range(len(joints)):
            joint, before = read_numbers(joint_like, joints[j]), read_numbers(kept_like, kept[j])
            opening, line = driven_opening(joint.valve, before.line, voltages[j], cycle)
            write_numbers(kept[j], CarriedState(before.state, line, opening))

    @kernel
    def push(joints, kept, around, span, at, qpos, qvel, applied, loads, brakes, kick):
        """Kernel of `JointKernels.push`."""
        places, dofs, q, v, torques = at[0], at[1], kick[0], kick[1], kick[2]
        air, cut = read_numbers(around_like, around), read_numbers(span_like, span)
        for j in range(len(joints)):
            joint, before = read_numbers(joint_like, joints[j]), read_numbers(kept_like, kept[j])
            q[j], v[j] = qpos[places[j]], qvel[dofs[j]]
            _, _, mid = _advance_to_kick(joint, before, air, cut, q[j], v[j])
            torques[j] = mid.torque
            kick[3, j], kick[4, j] = slip_torques(joint.friction, brakes[j], v[j], mid.velocity, mid.pull)
            applied[dofs[j]] += mid.torque + loads[j]
            qvel[dofs[j]] = v[j] + 0.5 * before.state.motion.velocity_change

    @kernel
    def settle(joints, kept, around, span, at, qpos, qvel, kick, braked, loads, holes, seen):
        """Kernel of `JointKernels.settle`."""
        places, dofs, q, v, impulses, after = at[0], at[1], kick[0], kick[1], braked[0], braked[1]
        air, cut = read_numbers(around_like, around), read_numbers(span_like, span)
        diverged = -1
        for j in range(len(joints)):
            joint, before = read_numbers(joint_like, joints[j]), read_numbers(kept_like, kept[j])
            if after[j] == 0.0:
                qpos[places[j]], qvel[dofs[j]] = q[j], 0.0
            state = _advance_step(joint, before, air, cut, q[j], v[j], qvel[dofs[j]], impulses[j], loads[j])
            state = _leak_hoses(joint, state, holes[j, 0], holes[j, 1], air.ambient_pressure)
            if not is_sound(state):
                diverged = j
            write_numbers(kept[j], CarriedState(state, before.line, before.opening))
            motion = state.motion
            write_numbers(
                seen[j], DrivenOutputs(motion.angle, motion.velocity, state.hose_a.pressure, state.hose_b.pressure)
            )
        return diverged

    @kernel
    def sample(joints, seen, noise, out):
        """Kernel of `JointKernels.sample`."""
        for j in range(len(joints)):
            joint = read_numbers(joint_like, joints[j])
            out[0, j] = read_sensor(joint.angle_sensor, seen[j, 0], noise[j, 0])
            out[1, j] = read_sensor(joint.pressure_sensor, seen[j, 2] - seen[j, 3], noise[j, 1])

    return command, push, settle, sample
