"""The same plant, its laws compiled, given to SciPy's LSODA as an ordinary differential equation.

Brakes, spool friction and slipping elements are smoothed, as a general solver needs.
"""

from __future__ import annotations

from math import pi, tanh

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from layflat.jit import kernel, law
from layflat.machine import Machine, parameters
from layflat.physics.arms.planar import two_link_coriolis, two_link_mass
from layflat.physics.chamber import air_mass, energy, pressure, temperature, wall_heat
from layflat.physics.flow import root_temperature
from layflat.physics.hose import swept_volume, torque_per_pressure
from layflat.physics.valves import chamber_flow
from layflat.physics.valves.spool_laws import path_conductance

STATES = 14
"""Per joint: q, v, x, x', then E, m and three element torques of each hose."""
OPENINGS = 0.08, 0.06
"""Of the valves."""
AT_REST = 0.01
"""Speed over which a brake is smoothed, rad/s."""
SPOOL_AT_REST = 1.0
"""Speed over which the spool's friction is smoothed, 1/s."""


@law
def _hose(joint, hose, y, s, x, around):  # type: ignore[no-untyped-def]
    p_a = around.ambient_pressure
    volume = hose.chamber.dead_volume + swept_volume(hose.stroke, s)
    p = pressure(hose.chamber, y[0], volume, p_a)
    T = temperature(hose.chamber, p, y[1], volume, p_a)
    flow, heat, _ = chamber_flow(
        joint.valve,
        path_conductance(joint.valve, x),
        path_conductance(joint.valve, -x),
        p,
        root_temperature(T),
        around.supply_pressure,
        root_temperature(around.supply_temperature),
        around.ambient_pressure,
    )
    K = torque_per_pressure(hose.stroke, s)
    return K, p, heat + wall_heat(hose.chamber, T, around.ambient_temperature), flow


@kernel
def rates(t, y, arm, joints, openings, brakes, around):  # type: ignore[no-untyped-def]
    """Time derivatives of all states."""
    dy = np.zeros_like(y)
    torque = np.empty(2)
    for j in range(2):
        joint, s = joints[j], y[STATES * j : STATES * (j + 1)]
        out = dy[STATES * j : STATES * (j + 1)]
        spool, valve = joint.valve.spool, joint.valve
        u = openings[j] + valve.dither_amplitude * np.sin(2 * pi * valve.dither_frequency * t)
        wn = spool.natural_frequency
        out[0], out[2] = s[1], s[3]
        grip = spool.friction * tanh(s[3] / SPOOL_AT_REST)
        out[3] = wn * wn * (u - s[2] - grip) - 2 * spool.damping_ratio * wn * s[3]
        total = -joint.viscous_friction * s[1] - brakes[j] * tanh(s[1] / AT_REST)
        for k in range(2):
            hose = joint.hose_a if k == 0 else joint.hose_b
            way = 1.0 if k == 0 else -1.0
            at = 4 + 5 * k
            K, p, heat, flow = _hose(joint, hose, s[at : at + 2], hose.neutral + way * s[0], way * s[2], around)
            out[at] = heat - p * K * way * s[1]
            out[at + 1] = flow
            pressing = max(p - around.ambient_pressure, 0.0)
            loss = hose.loss
            for i in range(3):
                stiffness, limit = loss.stiffness[i], loss.base[i] + loss.slope[i] * pressing
                f = s[at + 2 + i]
                near_slip = max(f * (1.0 if s[1] > 0.0 else -1.0), 0.0) / limit
                out[at + 2 + i] = stiffness * s[1] * (1.0 - near_slip**4)
                total -= f
            total += way * K * (p - around.ambient_pressure)
        torque[j] = total
    q_2 = y[STATES] + arm.elbow
    m_11, m_12, m_22, h = two_link_mass(arm, around.payload, np.sin(q_2), np.cos(q_2))
    c_1, c_2 = two_link_coriolis(h, y[1], y[STATES + 1])
    f_1, f_2 = torque[0] + c_1, torque[1] + c_2
    det = m_11 * m_22 - m_12 * m_12
    dy[1] = (m_22 * f_1 - m_12 * f_2) / det
    dy[STATES + 1] = (m_11 * f_2 - m_12 * f_1) / det
    return dy


def run(machine: Machine, seconds: float, tolerance: float = 1e-5) -> NDArray[np.float64]:
    """Simulate from rest with constant openings; final states."""
    around = parameters.surroundings(machine)
    joints = parameters.joints(machine)
    y = np.zeros(2 * STATES)
    for j, joint in enumerate(joints):
        for k, hose in enumerate((joint.hose_a, joint.hose_b)):
            p, T, p_a = 0.75 * around.supply_pressure, around.ambient_temperature, around.ambient_pressure
            volume = hose.chamber.dead_volume + swept_volume(hose.stroke, hose.neutral)
            at = STATES * j + 4 + 5 * k
            y[at] = energy(hose.chamber, p, volume, p_a)
            y[at + 1] = air_mass(hose.chamber, p, T, volume, p_a)
    openings, brakes = np.array(OPENINGS), np.array([joint.brake_torque for joint in joints])
    extra = (parameters.arm(machine), joints, openings, brakes, around)
    found = solve_ivp(rates, (0.0, seconds), y, method="LSODA", args=extra, rtol=tolerance, atol=1e-3 * tolerance)
    return np.asarray(found.y[:, -1])
