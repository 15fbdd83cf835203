"""The whole plant: an arm with its joints, advanced by a number of steps under constant drives and moving dither.

The arms differ only in how torques become velocities; `advance` picks the right one by the kind of arm.
"""

from math import floor, pi

from layflat.jit import by_kind, law
from layflat.physics.arm import (
    OneLink,
    TwoLink,
    one_link_gravity,
    one_link_mass,
    two_link_coriolis,
    two_link_gravity,
    two_link_mass,
)
from layflat.physics.friction import brake_one, brake_two
from layflat.physics.joint import finish, middle
from layflat.physics.trig import sincos


@law
def dither_start(frequency, t, h):
    """Sine and cosine of the dither at t + h/2, and of its turn in one step of h."""
    cycles = frequency * (t + 0.5 * h)
    sin_0, cos_0 = sincos(2.0 * pi * (cycles - floor(cycles + 0.5)))
    sin_h, cos_h = sincos(2.0 * pi * frequency * h)
    return sin_0, cos_0, sin_h, cos_h


@law
def _step_two(arm, joints, state_1, state_2, drives, openings, around, h):
    joint_1, joint_2 = joints[0], joints[1]
    load_1, load_2 = drives[0].load_torque, drives[1].load_torque
    mid_1 = middle(joint_1, state_1, openings[0], around, h)
    mid_2 = middle(joint_2, state_2, openings[1], around, h)
    sin_2, cos_2 = sincos(mid_2.angle + arm.elbow)
    M_11, M_12, M_22, coupling = two_link_mass(arm, around.payload, sin_2, cos_2)
    g_1, g_2 = two_link_gravity(arm, around.payload, mid_1.angle, sin_2, cos_2)
    c_1, c_2 = two_link_coriolis(coupling, mid_1.velocity, mid_2.velocity)
    f_1 = h * (mid_1.torque + c_1 + g_1 + load_1)
    f_2 = h * (mid_2.torque + c_2 + g_2 + load_2)
    per_det = 1.0 / (M_11 * M_22 - M_12 * M_12)
    free_1 = state_1.velocity + (M_22 * f_1 - M_12 * f_2) * per_det
    free_2 = state_2.velocity + (M_11 * f_2 - M_12 * f_1) * per_det
    B_1, B_2 = h * drives[0].brake_torque, h * drives[1].brake_torque
    v_1, v_2, J_1, J_2 = brake_two(M_11, M_12, M_22, free_1, free_2, B_1, B_2)
    return (
        finish(joint_1, state_1, mid_1, v_1, J_1, load_1 + g_1, h),
        finish(joint_2, state_2, mid_2, v_2, J_2, load_2 + g_2, h),
    )


@law
def advance_two(arm, joints, states, drives, around, t, h, n):
    """States of both joints, as a list, after n steps of h from time t; each sequence holds one item a joint."""
    valve_1, valve_2 = joints[0].valve, joints[1].valve
    sin_1, cos_1, turn_s1, turn_c1 = dither_start(valve_1.dither_frequency, t, h)
    sin_2, cos_2, turn_s2, turn_c2 = dither_start(valve_2.dither_frequency, t, h)
    state_1, state_2 = states[0], states[1]
    for _ in range(n):
        openings = (
            drives[0].opening + valve_1.dither_amplitude * sin_1,
            drives[1].opening + valve_2.dither_amplitude * sin_2,
        )
        state_1, state_2 = _step_two(arm, joints, state_1, state_2, drives, openings, around, h)
        sin_1, cos_1 = sin_1 * turn_c1 + cos_1 * turn_s1, cos_1 * turn_c1 - sin_1 * turn_s1
        sin_2, cos_2 = sin_2 * turn_c2 + cos_2 * turn_s2, cos_2 * turn_c2 - sin_2 * turn_s2
    return [state_1, state_2]


@law
def _step_one(arm, joint, state, drive, opening, around, h):
    mid = middle(joint, state, opening, around, h)
    M = one_link_mass(arm, around.payload)
    load = drive.load_torque + one_link_gravity(arm, around.payload, mid.angle)
    free = state.velocity + h * (mid.torque + load) / M
    v, J = brake_one(M, free, h * drive.brake_torque)
    return finish(joint, state, mid, v, J, load, h)


@law
def advance_one(arm, joints, states, drives, around, t, h, n):
    """State of the only joint after n steps of h from time t, as a list of one."""
    joint, state = joints[0], states[0]
    sin_d, cos_d, turn_s, turn_c = dither_start(joint.valve.dither_frequency, t, h)
    for _ in range(n):
        opening = drives[0].opening + joint.valve.dither_amplitude * sin_d
        state = _step_one(arm, joint, state, drives[0], opening, around, h)
        sin_d, cos_d = sin_d * turn_c + cos_d * turn_s, cos_d * turn_c - sin_d * turn_s
    return [state]


advance = by_kind({OneLink: advance_one, TwoLink: advance_two})
"""Advance an arm of any kind: `advance(arm, joints, states, drives, around, t, h, n)`."""
