"""From a described machine to the parameters of the laws: the one place where units of design become those of physics.

A number of the machine may be an array, an item a run (see sim/ensemble); then so are the parameters it decides.

| symbol | meaning | unit |
|---|---|---|
| s | travel of a hose: output angle from its collapsed state on | rad |
| S | full travel: (gamma - alpha_end) c R/r | rad |
| K | torque per pressure | m3/rad |
"""

from __future__ import annotations

from collections.abc import Callable
from math import degrees, pi, radians

import numpy as np
from numpy.polynomial.polynomial import polyfit

from layflat.control.gains import Gains, Phase
from layflat.errors import MachineError
from layflat.machine import parts
from layflat.machine.model import AngleSensor, Machine, PressureSensor, SpoolValve, SwitchingValves
from layflat.physics.arm import LevelTwoLink, OneLink, TwoLink
from layflat.physics.chamber import Chamber
from layflat.physics.flow import laminar_slope
from layflat.physics.hose import EvenStroke, Stroke, peeled_volume, roller_torque, roller_travel
from layflat.physics.joint import Hose, Joint, Surroundings
from layflat.physics.loss import Loss
from layflat.physics.sensor import Sensor
from layflat.physics.spool import Spool
from layflat.physics.spool_valve import SpoolValve as SpoolLaw
from layflat.physics.stop import Stops
from layflat.physics.switching_valve import Switch, SwitchingPair

Arm = OneLink | TwoLink | LevelTwoLink

NO_HOSE = Hose(EvenStroke(0.0), Chamber(1e-5, 0.0, 0.0), Loss(*([0.0] * 9)), 0.0)
"""In place of the second hose of a single-acting joint: it turns nothing."""


def full_travel(joint: parts.Joint) -> float:
    """S: output angle between the collapsed hose and its end of travel, rad."""
    hose, R = joint.hose, joint.cylinder.diameter / 2
    return _each(roller_travel, R, joint.output.radius, hose.wrap, hose.contact_end, hose.peel_ratio)


def travel_volume(joint: parts.Joint) -> float:
    """Volume that one hose sweeps over its full travel, m3."""
    hose, R = joint.hose, joint.cylinder.diameter / 2
    return _each(peeled_volume, R, hose.width / pi, hose.wrap, hose.contact_end, hose.peel_ratio)


def _each(law: Callable[..., float], *args: float) -> float:
    """A law of numbers, or of arrays item by item."""
    if any(isinstance(arg, np.ndarray) for arg in args):
        return np.vectorize(law, otypes=[float])(*args)  # type: ignore[no-any-return]
    return float(law(*args))


def stroke(joint: parts.Joint) -> EvenStroke | Stroke:
    """K over the travel of one hose: Eq. (1) for a roller, its mean for a cam."""
    S = full_travel(joint)
    if joint.output.kind == "cam":
        return EvenStroke(travel_volume(joint) / S)
    hose, R, r = joint.hose, joint.cylinder.diameter / 2, joint.output.radius
    t = 0.5 - 0.5 * np.cos(np.linspace(0.0, pi, 41))
    alphas = [hose.wrap - share * S * r / (hose.peel_ratio * R) for share in t]
    K = np.array([_each(roller_torque, 1.0, R, r, hose.width / pi, hose.wrap, alpha) for alpha in alphas])
    return Stroke(*(k / S**i for i, k in enumerate(polyfit(t, K, 4))))


def torque_constant(joint: parts.Joint) -> float:
    """Greatest K over the travel, m3/rad: maximum torque per gauge pressure."""
    curve = stroke(joint)
    if isinstance(curve, EvenStroke):
        return curve.k0
    s = np.multiply.outer(np.linspace(0.0, 1.0, 101), full_travel(joint))
    return np.max(sum(k * s**i for i, k in enumerate(curve)), axis=0)  # type: ignore[no-any-return]


def loss_share(joint: parts.Joint) -> float:
    """Loop height over greatest torque at the reference pressure, of hose, strap and rollers together."""
    share = joint.hose.loss_share * joint.cover.loss_factor + joint.strap.loss_share
    roller = joint.deflecting_roller
    if roller is not None:
        bend = joint.strap.thickness / roller.diameter
        share += roller.count * (roller.friction_share + roller.bending_share * bend)
    return share


def loss(joint: parts.Joint) -> Loss:
    """Elasto-slip elements of one hose with its strap."""
    at = joint.losses.reference_pressure_gauge
    # A loop is twice as high as the torque that opposes either way.
    limit = 0.5 * loss_share(joint) * torque_constant(joint) * at
    limits = [weight * limit for weight in joint.losses.weights]
    free = joint.losses.pressure_free
    stiffness = [y / d for y, d in zip(limits, joint.losses.deflections, strict=True)]
    return Loss(*stiffness, *(free * y for y in limits), *((1.0 - free) * y / at for y in limits))


def hose(joint: parts.Joint) -> Hose:
    """One hose in its joint."""
    chamber = Chamber(joint.hose.dead_volume, joint.hose.compliance, joint.hose.wall_conductance)
    return Hose(stroke(joint), chamber, loss(joint), full_travel(joint) / 2)


def _as_long(stroke: EvenStroke | Stroke) -> tuple[float, ...]:
    return (*stroke, *[0.0] * (len(Stroke._fields) - len(stroke)))


def stops(joint: parts.Joint) -> Stops:
    """End stops on both sides; squeezing begins where the opposite hose is collapsed."""
    limit = joint.stops.mechanical_stroke / 2
    squeeze = np.minimum(full_travel(joint) / 2, limit)
    return Stops(squeeze, joint.stops.squeeze_stiffness, limit, joint.stops.stop_stiffness, joint.stops.stop_damping)


def valve(described: SpoolValve | SwitchingValves) -> SpoolLaw | SwitchingPair:
    """A valve with its driver."""
    return spool_valve(described) if isinstance(described, SpoolValve) else switching_pair(described)


def spool_valve(described: SpoolValve) -> SpoolLaw:
    """Spool valve with its driver."""
    b = described.critical_ratio
    return SpoolLaw(
        Spool(2 * pi * described.natural_frequency, described.damping_ratio, described.friction),
        described.conductance,
        described.leakage,
        b,
        _each(laminar_slope, b),
        described.overlap,
        described.centre_voltage,
        described.volts_to_full,
        described.dither.amplitude,
        described.dither.frequency,
    )


def switching_pair(described: SwitchingValves) -> SwitchingPair:
    """Two on/off valves with their driver."""
    b = described.critical_ratio
    return SwitchingPair(
        Switch(
            described.opening_delay,
            described.opening_time,
            described.closing_delay,
            described.closing_time,
        ),
        described.conductance,
        described.leakage,
        b,
        _each(laminar_slope, b),
        described.centre_voltage,
        described.volts_to_full,
        described.frequency,
        described.dead_band,
        described.least_pulse,
    )


def sensor(described: AngleSensor | PressureSensor) -> Sensor:
    """A sensor centred on zero."""
    half = described.range / 2
    return Sensor(-half, half, described.range / 2**described.bits, described.offset, described.noise)


def drive_parts(machine: Machine) -> tuple[SpoolValve | SwitchingValves, AngleSensor, PressureSensor]:
    """Valve and sensors of a machine that moves by itself.

    Raises:
        MachineError: it has none, as the open-loop rigs.
    """
    if machine.valve is None or machine.angle_sensor is None or machine.pressure_sensor is None:
        raise MachineError(
            "has no valve or sensors: it is a rig for torque-angle loops",
            where=machine.origin,
            right="`layflat loop` sweeps it at constant pressure",
        )
    return machine.valve, machine.angle_sensor, machine.pressure_sensor


def joints(machine: Machine) -> tuple[Joint, ...]:
    """All laws of every joint, from base to tip; all with strokes of one kind, so that they can go side by side."""
    even = all(described.output.kind == "cam" for described in machine.joints.values())
    return tuple(_joint(machine, described, even=even) for described in machine.joints.values())


def _joint(machine: Machine, described: parts.Joint, *, even: bool) -> Joint:
    valve_part, angle_sensor, pressure_sensor = drive_parts(machine)
    pulling, pushing = hose(described), hose(described) if described.acting == "double" else NO_HOSE
    if not even:
        pulling, pushing = (h._replace(stroke=Stroke(*_as_long(h.stroke))) for h in (pulling, pushing))
    return Joint(
        pulling,
        pushing,
        valve(valve_part),
        stops(described),
        described.brake.viscous,
        described.brake.torque,
        sensor(angle_sensor),
        sensor(pressure_sensor),
    )


def arm(machine: Machine) -> Arm:
    """Masses of the arm, without payload."""
    g_x = machine.arm.gravity * np.cos(machine.arm.gravity_direction)
    g_y = machine.arm.gravity * np.sin(machine.arm.gravity_direction)
    joints = list(machine.joints.values())
    first = joints[0].link
    own_1 = first.rotor_inertia + first.inertia + first.mass * first.centre**2
    if len(joints) == 1:
        return OneLink(own_1, first.mass * first.centre, first.length, g_x, g_y)
    second, carried = joints[1].link, joints[1].body.mass
    own_2 = second.rotor_inertia + second.inertia + second.mass * second.centre**2
    masses = (
        own_1 + own_2 + (carried + second.mass) * first.length**2,
        second.mass * first.length * second.centre,
        own_2,
    )
    if np.all(machine.arm.gravity == 0.0):
        return LevelTwoLink(*masses, first.length, second.length, machine.arm.elbow)
    return TwoLink(
        *masses,
        first.mass * first.centre + (carried + second.mass) * first.length,
        second.mass * second.centre,
        first.length,
        second.length,
        machine.arm.elbow,
        g_x,
        g_y,
    )


def surroundings(machine: Machine) -> Surroundings:
    """Air outside and at the supply, and the payload."""
    air = machine.supply
    return Surroundings(
        air.pressure, air.temperature, air.ambient_pressure, air.ambient_temperature, machine.arm.payload
    )


def gains(machine: Machine, name: str) -> Gains:
    """Settings of one joint's controller.

    Raises:
        MachineError: the machine has no controller, or the joint no gains.
    """
    own, shared, valve_part = machine.joint[name].gains, machine.controller, machine.valve
    if own is None or shared is None or valve_part is None:
        raise MachineError(
            "has no controller gains", where=f"{machine.origin}: joint.{name}.gains", right="copy those of paper-arm"
        )
    span = valve_part.volts_to_full
    return Gains(
        Phase(own.far.error, own.far.pressure),
        Phase(own.near.error, own.near.pressure),
        Phase(own.close.error, own.close.pressure),
        own.near_below.error,
        own.near_below.speed,
        own.close_below.error,
        own.close_below.speed,
        valve_part.centre_voltage,
        own.integral,
        own.integral_limit,
        shared.drift_time,
        shared.drift_limit,
        shared.air_ripple,
        shared.rest_speed,
        shared.rest_time,
        shared.load_pressure,
        valve_part.centre_voltage - span,
        valve_part.centre_voltage + span,
        1.0 if shared.averaged else 0.0,
    )


def idle_gains(machine: Machine) -> Gains:
    """Settings of a controller that only watches, for open-loop runs of machines without gains."""
    valve_part, _, _ = drive_parts(machine)
    nothing, centre = Phase(0.0, 0.0), valve_part.centre_voltage
    span = valve_part.volts_to_full
    thresholds = (1.0, 1.0, 0.1, 0.1)
    drift = (1.0, 0.0, 0.0, 1.0, 1.0, 1.0)
    return Gains(nothing, nothing, nothing, *thresholds, centre, 0.0, 0.0, *drift, centre - span, centre + span, 1.0)


def check_inside_stroke(machine: Machine, name: str, angle: float, where: str) -> float:
    """An angle (rad) that the joint can reach.

    Raises:
        MachineError: it lies outside the working stroke.
    """
    half = machine.joint[name].stops.working_stroke / 2
    if not abs(angle) <= half + radians(1e-9):
        raise MachineError(
            f"{degrees(angle):.6g} deg is outside the working stroke of joint {name!r}",
            where=where,
            right=f"stay within +-{degrees(half):.6g} deg",
        )
    return angle
