"""Limits of one joint as plain numbers, from a machine's description."""

from __future__ import annotations

from collections.abc import Callable
from math import cos, isfinite

import numpy as np
from numpy.typing import NDArray

from layflat.control.watch import Limits, Patience
from layflat.machine import Machine, parameters
from layflat.machine.model import SpoolValve
from layflat.machine.parameters.drives import drive_parts
from layflat.machine.parameters.drives import sensor as sensor_law
from layflat.physics.arm import OneLink, two_link_mass
from layflat.rig.safety.faults import TABLE, Fault

LIVELY = 0.3
"""Noise of a sensor, in counts, from which on it never reports the same count for 20 samples."""

RAIL = 2.0
"""Counts from the end of a converter's range, at which a sensor is taken to be open or shorted."""


NOISE = 2.0
"""Counts by which a sample may be wrong: a joint at a limit is found in spite of them."""

RIPPLE_AFTER = 4.0
"""Cycles that the ripple takes to show that there is none any more."""

ASLEEP = 0.29
"""A driven joint moves by a count within this time; sound ones, shaken by another, took 0.2 s, s."""

HELD = 0.6
"""The same by more than noise, which may go to and fro by a count, s."""


def limits(machine: Machine, name: str) -> Limits:
    """Limits of a joint.

    Raises:
        MachineError: the machine has no valve or sensors.
    """
    _, angle_part, pressure_part = drive_parts(machine)
    joint, safety, gauge = machine.joint[name], machine.safety, machine.supply.pressure_gauge
    angle, pressure = sensor_law(angle_part), sensor_law(pressure_part)
    working, mechanical = joint.stops.working_stroke / 2, joint.stops.mechanical_stroke / 2
    K = parameters.torque_constant(joint)
    friction = 2.0 * joint.brake.torque / K + parameters.loss_share(joint) * gauge
    seen = _dither_is_seen(machine)
    return Limits(
        angle.low + RAIL * angle.lsb,
        angle.high - RAIL * angle.lsb,
        angle.lsb,
        working + safety.overrun * (mechanical - working) - NOISE * angle.lsb,
        safety.speed - NOISE * angle.lsb / machine.cycle,
        min(safety.overpressure * gauge, pressure.high - RAIL * pressure.lsb),
        friction,
        safety.following_error,
        safety.following_time,
        safety.demand_speed,
        safety.surplus if joint.acting == "double" else float("inf"),
        machine.controller.air_ripple if machine.controller is not None and seen else 0.0,
        1.0 if seen or pressure.noise > LIVELY * pressure.lsb else 0.0,
    )


def coupling(machine: Machine) -> Callable[[NDArray[np.float64]], NDArray[np.float64]]:
    """How much of each other joint's differential pressure a joint at rest feels, (joints, joints), by angles, rad.

    While joint i turns and j is at rest, M_ii a_i = K_i p_i, and j has to bear M_ji a_i = M_ji / M_ii K_i p_i, with
    the payload of the description.
    """
    arm, n = parameters.arm(machine), len(machine.joints)
    found = np.zeros((n, n))
    if isinstance(arm, OneLink):
        return lambda _: found
    K_1, K_2 = (parameters.torque_constant(joint) for joint in machine.joints.values())
    payload, elbow = machine.arm.payload, machine.arm.elbow

    def at(angles: NDArray[np.float64]) -> NDArray[np.float64]:
        turned = float(angles[1]) if isfinite(angles[1]) else 0.0
        M_11, M_12, M_22, _ = two_link_mass(arm, payload, 0.0, cos(turned + elbow))
        found[0, 1], found[1, 0] = M_12 / M_22 * K_2 / K_1, M_12 / M_11 * K_1 / K_2
        return found

    return at


def patience(cycle: float) -> Patience:
    """How long conditions have to last: two cycles less than the table gives to find them."""

    def within(fault: Fault, cycles: float = 2.0) -> float:
        return TABLE[fault].seconds - cycles * cycle

    return Patience(
        rail=TABLE[Fault.ANGLE_AT_RAIL].cycles,
        fast=TABLE[Fault.OVER_SPEED].cycles,
        outside=TABLE[Fault.OUTSIDE_STROKE].cycles,
        pressed=TABLE[Fault.OVER_PRESSURE].cycles,
        frozen_pressure=within(Fault.PRESSURE_FROZEN),
        frozen_angle=within(Fault.ANGLE_FROZEN),
        following=within(Fault.FOLLOWING_ERROR),
        quiet=within(Fault.VALVE_UNRESPONSIVE, 2.0 + RIPPLE_AFTER),
        doubtful=2.5 * cycle,
        sure=7.5 * cycle,
        asleep=ASLEEP,
        held=HELD,
    )


def _dither_is_seen(machine: Machine) -> bool:
    """Whether the ripple that the controller computes, at a quarter of its rate, is that of the dither."""
    valve, controller = machine.valve, machine.controller
    if not isinstance(valve, SpoolValve) or controller is None or valve.dither.amplitude == 0.0:
        return False
    return abs(valve.dither.frequency * controller.cycle - 0.25) < 0.01
