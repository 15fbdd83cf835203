"""The whole plant: an arm with its joints, advanced by a number of steps under constant drives."""

from layflat.jit import Law, composition, kernel, law
from layflat.lanes import abreast, apart, each, gather, halves, join, select, slots
from layflat.physics.algebra import times
from layflat.physics.arms import ARMS, dynamics
from layflat.physics.friction import levels, rub
from layflat.physics.joint import joint_at_rest, pressures_at_rest, supplied
from layflat.physics.step import finish, midpoint, pack, unpack
from layflat.physics.valves import turn_wave


@law
def _still(q):
    return 0.0 * q


@law
def _resting(joint, q, p_1, p_2, pull, around):
    a, b = pressures_at_rest(joint, q, pull, around)
    # What is not given is not a number.
    return joint_at_rest(joint, q, select(p_1 == p_1, p_1, a), select(p_2 == p_2, p_2, b), around)  # noqa: PLR0124


@composition
def at_rest(arm, joints, angles, firsts, seconds, around):
    """Return the states of joints at rest at angles (rad), tuples; pressures in hoses A and B (Pa) may be nan.

    Those are then what holds the arm against gravity and springs, as far as air can.
    """
    _, _, pulls = dynamics(arm, around.payload, angles, each(_still, angles))
    return each(_resting, joints, angles, firsts, seconds, pulls, around)


@composition
def _step_two(arm, joints, running, drives, waves, around, h):
    mid = midpoint(joints, running, drives.opening, waves, supplied(join(around, around), drives), h)
    torque_1, torque_2 = halves(mid.torque)
    before = running.motion.velocity
    sliding, held = levels(joints.friction, drives.brake_torque, before, mid.velocity, mid.pull)
    (v_1, v_2), (B_1, B_2), (S_1, S_2) = halves(before), halves(sliding), halves(held)
    drive_1, drive_2 = halves(drives)
    M, (c_1, c_2), (g_1, g_2) = dynamics(arm, around.payload, halves(mid.angle), halves(mid.velocity))
    M_11, M_12, M_22 = M
    load_1, load_2 = drive_1.load_torque + g_1, drive_2.load_torque + g_2
    # The air's torques come last: all else is ready before them.
    p_1 = M_11 * v_1 + M_12 * v_2 + h * (c_1 + load_1) + h * torque_1
    p_2 = M_12 * v_1 + M_22 * v_2 + h * (c_2 + load_2) + h * torque_2
    limits = (h * B_1, h * B_2), (h * S_1, h * S_2)
    (w_1, w_2), (J_1, J_2) = rub(joints.friction, M, (p_1, p_2), (v_1, v_2), limits[0], limits[1])
    return finish(joints, running, mid, join(w_1, w_2), join(J_1, J_2), join(load_1, load_2), h)


@composition
def _both(arm, joints):  # noqa: ARG001  (as of all arms)
    return join(joints[0], joints[1])


@composition
def advance_two(arm, both, states, drives, waves, around, h, n):
    """Advance states and waves (slots) of both joints by n steps of h; each sequence holds one item a joint."""
    drive, wave = join(drives[0], drives[1]), join(waves[0], waves[1])
    running = pack(join(states[0], states[1]))
    for _ in range(n):
        running = _step_two(arm, both, running, drive, wave, around, h)
        wave = turn_wave(both.valve, wave)
    states[0], states[1] = halves(unpack(running))
    waves[0], waves[1] = halves(wave)


@composition
def _step_one(arm, joint, running, drive, wave, around, h):
    mid = midpoint(joint, running, drive.opening, wave, supplied(around, drive), h)
    M, (c,), (g,) = dynamics(arm, around.payload, (mid.angle,), (mid.velocity,))
    load = drive.load_torque + g
    before = running.motion.velocity
    sliding, held = levels(joint.friction, drive.brake_torque, before, mid.velocity, mid.pull)
    p = M[0] * before + h * (c + load) + h * mid.torque
    (v,), (J,) = rub(joint.friction, M, (p,), (before,), (h * sliding,), (h * held,))
    return finish(joint, running, mid, v, J, load, h)


@composition
def _only(arm, joints):  # noqa: ARG001  (as of all arms)
    return joints[0]


@composition
def advance_one(arm, joint, states, drives, waves, around, h, n):
    """Advance state and wave (slots of one) of the only joint by n steps of h."""
    drive, wave, running = drives[0], waves[0], pack(states[0])
    for _ in range(n):
        running = _step_one(arm, joint, running, drive, wave, around, h)
        wave = turn_wave(joint.valve, wave)
    states[0], waves[0] = unpack(running), wave


@law
def _scaled(x, h):
    return h * x


@law
def _sum(x, y):
    return x + y


@law
def _pushed(momentum, of_velocities, load, torque, h):
    # The air's torque comes last, as in `_step_two`.
    return momentum + h * (of_velocities + load) + h * torque


@composition
def _step_many(arm, like, joints, running, drives, waves, around, h):
    surroundings = abreast(gather(like, slots(like, around)))
    mid = midpoint(joints, running, drives.opening, waves, supplied(surroundings, drives), h)
    before = running.motion.velocity
    sliding, held = levels(joints.friction, drives.brake_torque, before, mid.velocity, mid.pull)
    M, moving, pulls = dynamics(arm, around.payload, apart(mid.angle, like), apart(mid.velocity, like))
    v, loads = apart(before, like), each(_sum, apart(drives.load_torque, like), pulls)
    p = each(_pushed, times(M, v), moving, loads, apart(mid.torque, like), h)
    limits = apart(_scaled(sliding, h), like), apart(_scaled(held, h), like)
    w, J = rub(joints.friction, M, p, v, limits[0], limits[1])
    return finish(joints, running, mid, abreast(w), abreast(J), abreast(loads), h)


@composition
def _all(arm, joints):  # noqa: ARG001  (as of all arms)
    return abreast(gather(joints, joints))


@composition
def advance_many(arm, all_joints, states, drives, waves, around, h, n):
    """Advance states and waves (slots) of all joints by n steps of h, however many there are."""
    like = gather(states, states)
    drive, wave = abreast(gather(like, drives)), abreast(gather(like, waves))
    running = pack(abreast(gather(like, states)))
    for _ in range(n):
        running = _step_many(arm, like, all_joints, running, drive, wave, around, h)
        wave = turn_wave(all_joints.valve, wave)
    after, waves_after = slots(apart(unpack(running), like)), slots(apart(wave, like))
    for j in range(len(like)):
        states[j], waves[j] = after[j], waves_after[j]


_TOGETHER = {1: _only, 2: _both}
_ADVANCES = {1: advance_one, 2: advance_two}
_together = ARMS.law(lambda laws: _TOGETHER.get(laws.joints, _all))
_advance = ARMS.law(lambda laws: _ADVANCES.get(laws.joints, advance_many))


def _together_inlined(arm, joints):
    """All joints of an arm (slots) as `advance` takes them: found once for all its calls."""
    return _together(arm, joints)


def _inlined(arm, joints, states, drives, waves, around, h, n):
    """Advance an arm of any kind, in place: joints `together`; states and waves are slots with an item a joint."""
    _advance(arm, joints, states, drives, waves, around, h, n)


@kernel
def _advanced(arm, joints, states, drives, waves, around, h, n):
    after, wave = slots(states), slots(waves)
    _advance(arm, _together(arm, slots(joints)), after, slots(drives), wave, around, h, n)
    return gather(states, after), gather(states, wave)


def _as_they_are(arm, joints):  # noqa: ARG001  (as what is inlined)
    return tuple(joints)


def _from_python(arm, joints, states, drives, waves, around, h, n):
    # Steps are too many to be interpreted: they are compiled even where a loop in Python calls them.
    states[:], waves[:] = _advanced(arm, joints, tuple(states), tuple(drives), tuple(waves), around, h, n)


together = Law(_together_inlined, _as_they_are)
advance = Law(_inlined, _from_python)
