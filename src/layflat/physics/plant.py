"""The whole plant: an arm with its joints, advanced by a number of steps under constant drives."""

from layflat.jit import Law, composition, kernel, law
from layflat.lanes import abreast, apart, each, gather, halves, join, select, slots
from layflat.physics.algebra import multiply_symmetric
from layflat.physics.arms import ARM_KINDS, dynamics
from layflat.physics.friction import slip_torques, solve_friction
from layflat.physics.joint import joint_at_rest, pressures_at_rest, with_supply
from layflat.physics.step import advance_to_midpoint, finish_step, pack_hoses, unpack_hoses
from layflat.physics.valves import turn_wave


@law
def _zero_velocity(q):
    return 0.0 * q


@law
def _joint_state_at_rest(joint, q, p_1, p_2, pull, around):
    """Return the state of a joint at rest at q; a pressure that is nan is the one that balances `pull` (N m)."""
    a, b = pressures_at_rest(joint, q, pull, around)
    # A pressure that is not specified is nan.
    return joint_at_rest(joint, q, select(p_1 == p_1, p_1, a), select(p_2 == p_2, p_2, b), around)  # noqa: PLR0124


@composition
def states_at_rest(arm, joints, angles, firsts, seconds, around):
    """Return the states of joints at rest at angles (rad), tuples, with absolute pressures in hoses A and B (Pa).

    A pressure that is nan is replaced by the one that balances gravity and springs, within the supply's limits.
    """
    _, _, pulls = dynamics(arm, around.payload, angles, each(_zero_velocity, angles))
    return each(_joint_state_at_rest, joints, angles, firsts, seconds, pulls, around)


@composition
def _step_two(arm, joints, running, drives, waves, around, h):
    """Return the states of two joints, as lanes, after a step of h seconds, with masses and friction in closed form."""
    mid = advance_to_midpoint(joints, running, drives.opening, waves, with_supply(join(around, around), drives), h)
    torque_1, torque_2 = halves(mid.torque)
    before = running.motion.velocity
    sliding, held = slip_torques(joints.friction, drives.brake_torque, before, mid.velocity, mid.pull)
    (v_1, v_2), (B_1, B_2), (S_1, S_2) = halves(before), halves(sliding), halves(held)
    drive_1, drive_2 = halves(drives)
    M, (c_1, c_2), (g_1, g_2) = dynamics(arm, around.payload, halves(mid.angle), halves(mid.velocity))
    M_11, M_12, M_22 = M
    load_1, load_2 = drive_1.load_torque + g_1, drive_2.load_torque + g_2
    # The air's torques come last: all others are ready before them.
    p_1 = M_11 * v_1 + M_12 * v_2 + h * (c_1 + load_1) + h * torque_1
    p_2 = M_12 * v_1 + M_22 * v_2 + h * (c_2 + load_2) + h * torque_2
    limits = (h * B_1, h * B_2), (h * S_1, h * S_2)
    (w_1, w_2), (J_1, J_2) = solve_friction(joints.friction, M, (p_1, p_2), (v_1, v_2), limits[0], limits[1])
    return finish_step(joints, running, mid, join(w_1, w_2), join(J_1, J_2), join(load_1, load_2), h)


@composition
def _pack_two(arm, joints):  # noqa: ARG001  (signature of all arms)
    return join(joints[0], joints[1])


@composition
def advance_two(arm, both, states, drives, waves, around, h, n):
    """Advance states and waves (slots) of both joints by n steps of h seconds; each sequence holds one item a joint."""
    drive, wave = join(drives[0], drives[1]), join(waves[0], waves[1])
    running = pack_hoses(join(states[0], states[1]))
    for _ in range(n):
        running = _step_two(arm, both, running, drive, wave, around, h)
        wave = turn_wave(both.valve, wave)
    states[0], states[1] = halves(unpack_hoses(running))
    waves[0], waves[1] = halves(wave)


@composition
def _step_one(arm, joint, running, drive, wave, around, h):
    """Return the state of a single joint after a step of h seconds."""
    mid = advance_to_midpoint(joint, running, drive.opening, wave, with_supply(around, drive), h)
    M, (c,), (g,) = dynamics(arm, around.payload, (mid.angle,), (mid.velocity,))
    load = drive.load_torque + g
    before = running.motion.velocity
    sliding, held = slip_torques(joint.friction, drive.brake_torque, before, mid.velocity, mid.pull)
    p = M[0] * before + h * (c + load) + h * mid.torque
    (v,), (J,) = solve_friction(joint.friction, M, (p,), (before,), (h * sliding,), (h * held,))
    return finish_step(joint, running, mid, v, J, load, h)


@composition
def _pack_one(arm, joints):  # noqa: ARG001  (signature of all arms)
    return joints[0]


@composition
def advance_one(arm, joint, states, drives, waves, around, h, n):
    """Advance state and wave (slots of one) of the only joint by n steps of h seconds."""
    drive, wave, running = drives[0], waves[0], pack_hoses(states[0])
    for _ in range(n):
        running = _step_one(arm, joint, running, drive, wave, around, h)
        wave = turn_wave(joint.valve, wave)
    states[0], waves[0] = unpack_hoses(running), wave


@law
def _scaled(x, h):
    return h * x


@law
def _sum(x, y):
    return x + y


@law
def _momentum_without_friction(momentum, of_velocities, load, torque, h):
    """Return the momentum p of turning.py after a step of h seconds under torques (N m) without friction."""
    # The air's torque comes last, as in `_step_two`.
    return momentum + h * (of_velocities + load) + h * torque


@composition
def _step_many(arm, like, joints, running, drives, waves, around, h):
    """Return the states of any number of joints, as lanes, after a step of h seconds; `like` has an item a joint."""
    surroundings = abreast(gather(like, slots(like, around)))
    mid = advance_to_midpoint(joints, running, drives.opening, waves, with_supply(surroundings, drives), h)
    before = running.motion.velocity
    sliding, held = slip_torques(joints.friction, drives.brake_torque, before, mid.velocity, mid.pull)
    M, moving, pulls = dynamics(arm, around.payload, apart(mid.angle, like), apart(mid.velocity, like))
    v, loads = apart(before, like), each(_sum, apart(drives.load_torque, like), pulls)
    p = each(_momentum_without_friction, multiply_symmetric(M, v), moving, loads, apart(mid.torque, like), h)
    limits = apart(_scaled(sliding, h), like), apart(_scaled(held, h), like)
    w, J = solve_friction(joints.friction, M, p, v, limits[0], limits[1])
    return finish_step(joints, running, mid, abreast(w), abreast(J), abreast(loads), h)


@composition
def _pack_many(arm, joints):  # noqa: ARG001  (signature of all arms)
    return abreast(gather(joints, joints))


@composition
def advance_many(arm, all_joints, states, drives, waves, around, h, n):
    """Advance states and waves (slots) of any number of joints by n steps of h seconds."""
    like = gather(states, states)
    drive, wave = abreast(gather(like, drives)), abreast(gather(like, waves))
    running = pack_hoses(abreast(gather(like, states)))
    for _ in range(n):
        running = _step_many(arm, like, all_joints, running, drive, wave, around, h)
        wave = turn_wave(all_joints.valve, wave)
    after, waves_after = slots(apart(unpack_hoses(running), like)), slots(apart(wave, like))
    for j in range(len(like)):
        states[j], waves[j] = after[j], waves_after[j]


_PACK_LAWS = {1: _pack_one, 2: _pack_two}
_ADVANCE_LAWS = {1: advance_one, 2: advance_two}
_pack_joints = ARM_KINDS.law(lambda laws: _PACK_LAWS.get(laws.joints, _pack_many))
_advance = ARM_KINDS.law(lambda laws: _ADVANCE_LAWS.get(laws.joints, advance_many))


def _pack_inlined(arm, joints):
    """Return all joints of an arm (slots) in the form that `advance_arm` takes, which its calls share."""
    return _pack_joints(arm, joints)


def _advance_inlined(arm, joints, states, drives, waves, around, h, n):
    """Advance an arm of any kind by n steps of h seconds, in place.

    Args: joints as `pack_joints` returns them; states and waves are slots with an item a joint.
    """
    _advance(arm, joints, states, drives, waves, around, h, n)


@kernel
def _advance_kernel(arm, joints, states, drives, waves, around, h, n):
    """Return states and waves after n steps of h seconds; all sequences are tuples with an item a joint."""
    after, wave = slots(states), slots(waves)
    _advance(arm, _pack_joints(arm, slots(joints)), after, slots(drives), wave, around, h, n)
    return gather(states, after), gather(states, wave)


def _pack_interpreted(arm, joints):  # noqa: ARG001  (signature of the inlined law)
    return tuple(joints)


def _advance_from_python(arm, joints, states, drives, waves, around, h, n):
    """Advance states and waves in place by n steps, compiled even when Python calls it: they are too many for that."""
    states[:], waves[:] = _advance_kernel(arm, joints, tuple(states), tuple(drives), tuple(waves), around, h, n)


pack_joints = Law(_pack_inlined, _pack_interpreted)
advance_arm = Law(_advance_inlined, _advance_from_python)
