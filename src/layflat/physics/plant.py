"""The whole plant: an arm with its joints, advanced by a number of steps under constant drives.

The arms differ only in how torques become velocities; `advance` picks the right one by the kind of arm.
"""

import numpy as np

from layflat.jit import by_kind, composition, kernel
from layflat.lanes import halves, join
from layflat.physics.arm import (
    LevelTwoLink,
    OneLink,
    TwoLink,
    one_link_gravity,
    one_link_mass,
    one_link_tip,
    two_link_coriolis,
    two_link_gravity,
    two_link_mass,
    two_link_tip,
)
from layflat.physics.friction import brake_one, brake_two
from layflat.physics.step import at_hand, finish, middle, set_running
from layflat.physics.trig import sincos
from layflat.physics.valve import turn_wave


@composition
def _posture(arm, payload, q_1, q_2):
    """M_11, M_12, M_22, the Coriolis coefficient, and the torques of gravity, at these angles."""
    sines, cosines = sincos(join(q_1, q_2 + arm.elbow))
    (sin_1, sin_2), (cos_1, cos_2) = halves(sines), halves(cosines)
    M_11, M_12, M_22, coupling = two_link_mass(arm, payload, sin_2, cos_2)
    g_1, g_2 = two_link_gravity(arm, payload, sin_1, cos_1, sin_2, cos_2)
    return M_11, M_12, M_22, coupling, g_1, g_2


@composition
def _level_posture(arm, payload, q_1, q_2):  # noqa: ARG001  (as all postures)
    sin_2, cos_2 = sincos(q_2 + arm.elbow)
    M_11, M_12, M_22, coupling = two_link_mass(arm, payload, sin_2, cos_2)
    return M_11, M_12, M_22, coupling, 0.0, 0.0


posture = by_kind({TwoLink: _posture, LevelTwoLink: _level_posture})


@composition
def _step_two(arm, joints, running, drives, waves, around, h):
    mid = middle(joints, running, drives.opening, waves, join(around, around), h)
    (q_1, q_2), (led_1, led_2), (torque_1, torque_2) = halves(mid.angle), halves(mid.velocity), halves(mid.torque)
    v_1, v_2 = halves(running.motion.velocity)
    drive_1, drive_2 = halves(drives)
    M_11, M_12, M_22, coupling, g_1, g_2 = posture(arm, around.payload, q_1, q_2)
    c_1, c_2 = two_link_coriolis(coupling, led_1, led_2)
    load_1, load_2 = drive_1.load_torque + g_1, drive_2.load_torque + g_2
    # The air's torques come last: all else is ready before them.
    p_1 = M_11 * v_1 + M_12 * v_2 + h * (c_1 + load_1) + h * torque_1
    p_2 = M_12 * v_1 + M_22 * v_2 + h * (c_2 + load_2) + h * torque_2
    v_1, v_2, J_1, J_2 = brake_two(M_11, M_12, M_22, p_1, p_2, h * drive_1.brake_torque, h * drive_2.brake_torque)
    return finish(joints, running, mid, join(v_1, v_2), join(J_1, J_2), join(load_1, load_2), h)


@composition
def advance_two(arm, joints, states, drives, waves, around, h, n):
    """Advance states and waves (lists) of both joints by n steps of h; each sequence holds one item a joint."""
    both, drive, wave = join(joints[0], joints[1]), join(drives[0], drives[1]), join(waves[0], waves[1])
    running = set_running(join(states[0], states[1]))
    for _ in range(n):
        running = _step_two(arm, both, running, drive, wave, around, h)
        wave = turn_wave(wave)
    states[0], states[1] = halves(at_hand(running))
    waves[0], waves[1] = halves(wave)


@composition
def _step_one(arm, joint, running, drive, wave, around, h):
    mid = middle(joint, running, drive.opening, wave, around, h)
    M = one_link_mass(arm, around.payload)
    load = drive.load_torque + one_link_gravity(arm, around.payload, mid.angle)
    v, J = brake_one(M, M * running.motion.velocity + h * load + h * mid.torque, h * drive.brake_torque)
    return finish(joint, running, mid, v, J, load, h)


@composition
def advance_one(arm, joints, states, drives, waves, around, h, n):
    """Advance state and wave (lists of one) of the only joint by n steps of h."""
    joint, drive, wave, running = joints[0], drives[0], waves[0], set_running(states[0])
    for _ in range(n):
        running = _step_one(arm, joint, running, drive, wave, around, h)
        wave = turn_wave(wave)
    states[0], waves[0] = at_hand(running), wave


advance = by_kind({OneLink: advance_one, TwoLink: advance_two, LevelTwoLink: advance_two})
"""Advance an arm of any kind, in place: `advance(arm, joints, states, drives, waves, around, h, n)`."""


@composition
def _tip_of_one(arm, angles):
    return one_link_tip(arm, angles[0])


@composition
def _tip_of_two(arm, angles):
    return two_link_tip(arm, angles[0], angles[1])


tip = by_kind({OneLink: _tip_of_one, TwoLink: _tip_of_two, LevelTwoLink: _tip_of_two})
"""Position of the tip (m), x along link 1 at mid-stroke, from the joints' angles (a list): `tip(arm, angles)`."""


@kernel
def tips_along(arm, q):
    """Positions of the tip, (instants, 2), m, from angles (instants, joints), rad."""
    tips = np.empty((len(q), 2))
    for i in range(len(q)):
        tips[i, 0], tips[i, 1] = tip(arm, q[i])
    return tips
