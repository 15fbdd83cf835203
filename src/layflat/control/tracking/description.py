"""What a machine's file says of the tracking law, and the settings that follow from it and from the machine.

| symbol | meaning | unit |
|---|---|---|
| K | torque per pressure | m3/rad |
| C | sonic conductance of an open valve | m3/(s Pa) |
| V | volume of air in a hose at mid-stroke, with what its wall gives way as the pressure changes | m3 |
| p_s, p_a | absolute pressures of supply and surroundings | Pa |
| T | control cycle | s |
"""

from collections.abc import Callable
from math import pi, radians
from typing import Annotated, Any, Literal, get_args

import numpy as np
from pydantic import Field

from layflat.control.kind import ControllerPart
from layflat.control.tracking.arrival import Tolerance
from layflat.control.tracking.estimation import Prior, Shapes
from layflat.control.tracking.law import Settings
from layflat.control.tracking.limits import ActuatorLimits, Margins, Parts
from layflat.control.tracking.model import ObserverTuning, Plant, step_count
from layflat.control.tracking.torques import Feedback
from layflat.description import units as u
from layflat.errors import MachineError
from layflat.physics.air import GAMMA, GAS_CONSTANT, REFERENCE_DENSITY, REFERENCE_TEMPERATURE
from layflat.physics.arrays import itemwise
from layflat.physics.flow import effective_pressure
from layflat.physics.hose import swept_volume, torque_per_pressure
from layflat.physics.joint import FILLED, Joint, Surroundings, has_second
from layflat.physics.sensor import Sensor
from layflat.physics.valves import VALVES

QUICKEST = 0.15  # bandwidth in a control cycle, at most
REACHED = 0.92  # share of the supply's pressure that a differential pressure comes to while a joint moves
EMPTIED = 0.2  # share of it that is left in a single hose meanwhile: the last of the air leaves slowly
LIGHTEST = 0.7  # of the stiffness of its hoses that feedback has at least, however light a joint is
EASING = 0.1  # share of the torque's rate at which a joint that arrived gives up what it does not need
SEEN = 0.1, 0.45  # periods of the dither in a control cycle between which samples show it
LATE = 0.5  # of its reserve that the arm keeps where it has to brake late
JERK = 0.8  # share of the torque's rate that is planned with: it falls as the hoses fill

Part = Annotated[float, Field(gt=0.0, le=1.0)]
PartOfLaw = Literal["feedback", "feedforward", "friction", "governor", "landing", "learning", "pressures"]
"""Feedback of angles, feed-forward of accelerations, torque against friction, slowing down where valves saturate,
setting out again from beside the goal, learning of loads, frictions and payload, correction by pressures."""


class TrackingControllerPart(ControllerPart):
    """The tracking law: all else follows from the machine that it is for."""

    kind: Literal["tracking"]
    bandwidth: u.Rate = Field(default=30.0, description="of angles about their reference, at most 0.15 in a cycle")
    torque_errors: u.Share = Field(default=0.008, description="error of the model's torques, over the greatest torque")
    pressure_trust: Part = Field(default=0.95, description="share of a pressure's innovation taken over in a cycle")
    valve_share: Part = Field(default=0.56, description="share of a missing torque that valves make up in a cycle")
    reserve: u.Share = Field(default=0.25, description="share of its torques that the arm plans without")
    quickest: u.Time = Field(default=0.08, description="no move is meant to take less")
    tolerance: u.Length = Field(default=0.0015, description="distance of the tip from its goal that is left as it is")
    angle_tolerance: u.PositiveAngle = Field(
        default=radians(1.0), description="angle of a joint from its goal that is left as it is"
    )
    blind_angle_tolerance: u.PositiveAngle = Field(
        default=radians(0.2), description="the same where so much does not take the tip out of its tolerance"
    )
    payload_spread: u.Mass = Field(
        default=0.0, description="by how much the payload may differ from the described (standard deviation); 0: known"
    )
    load_spread: u.Share = Field(default=0.007, description="load on a joint that may be there, over its torque")
    load_wander: u.Share = Field(default=0.04, description="by how much it changes in a second")
    friction_spread: u.Share = Field(default=0.25, description="by how much friction may differ from the described")
    angle_errors: u.Ratio = Field(default=7.0, description="errors of the model's angle over those of the sensor")
    without: tuple[PartOfLaw, ...] = Field(default=(), description="parts of the law that are left out, to compare")


def settings(
    described: TrackingControllerPart, machine: Any, plant_parameters: Callable[[], tuple[Any, Any, Any]]
) -> Settings:
    """Return the settings of the law for a machine; raise MachineError for valves and joints that it can't model."""
    plant = _plant(machine, *plant_parameters())
    joints, n = plant.joints, len(plant.joints)
    actuators = tuple(_ability(joint, plant.around) for joint in joints)
    T = described.cycle
    w = np.minimum(described.bandwidth, QUICKEST / T)
    error = np.sqrt(_variance(joints[0].angle_sensor))
    share, notch = described.pressure_trust, _notch(joints[0].valve, T)
    has = {part: float(part not in described.without) for part in get_args(PartOfLaw)}
    share = share * has["pressures"]
    observer = tuple(ObserverTuning(described.torque_errors * a.torque, error, share, notch) for a in actuators)
    kept, late = 1.0 - described.reserve, 1.0 - LATE * described.reserve
    margins = Margins(kept, late, JERK, described.quickest, _tolerance(described))
    w = w * has["feedback"]
    feedback = tuple(
        Feedback(w * w, 2.0 * w, described.valve_share, EASING * a.rate, LIGHTEST * has["feedback"] * a.rate / a.speed)
        for a in actuators
    )
    parts = Parts(has["feedforward"], has["friction"], has["governor"], has["landing"])
    m = 2 * n + 1
    shapes = Shapes((0.0,) * (n * n), (0.0,) * (m * m), (0.0,) * (n * m))
    prior = _unknowns(described, joints, actuators, plant.around.payload, has["learning"])
    return Settings(plant, actuators, observer, feedback, margins, parts, prior, shapes)


def _tolerance(described: TrackingControllerPart) -> Tolerance:
    angle = described.angle_tolerance
    return Tolerance(described.tolerance, angle, np.minimum(described.blind_angle_tolerance, angle))


def _plant(machine: Any, arm: Any, joints: tuple[Any, ...], around: Any) -> Plant:
    kind = VALVES.of(joints[0].valve)
    if kind.mean is None:
        raise MachineError(
            f"a valve of kind {kind.name!r} has no mean that a model of the tracking law could go by",
            where=f"{machine.origin}: controller.kind",
            right='give a valve of kind "spool", or the controller "paper"',
        )
    mean = kind.mean.averaged
    whole = int(np.max([np.floor(np.max(joint.valve.delay) / machine.cycle + 1e-9) for joint in joints]))
    steps = (0.0,) * step_count(arm, joints, around, machine.cycle)
    return Plant(arm, tuple(joint._replace(valve=mean(joint.valve)) for joint in joints), around, steps, (0.0,) * whole)


def _ability(joint: Joint, around: Surroundings) -> ActuatorLimits:
    """Return what a joint can do at mid-stroke, its hoses as full as leaks leave them, a single one half full.

    Two hoses give torque both ways, and one fills while the other is vented; a single one does either.
    """
    hose, valve, p_s, p_a = joint.hose_a, joint.valve, around.supply_pressure, around.ambient_pressure
    second = has_second(joint.second)
    p = second * (FILLED * p_s) + (1.0 - second) * (0.5 * (p_s + p_a))
    K = torque_per_pressure(hose.stroke, hose.neutral)
    V = hose.chamber.dead_volume + swept_volume(hose.stroke, hose.neutral) + GAMMA * hose.chamber.compliance * p
    b, s = valve.critical_ratio, valve.laminar_slope
    filled, vented = itemwise(effective_pressure, p_s, p, b, s), itemwise(effective_pressure, p, p_a, b, s)
    flows = filled + vented if second else np.minimum(filled, vented)
    fed = valve.conductance * (REFERENCE_DENSITY * GAS_CONSTANT * REFERENCE_TEMPERATURE)
    torque, least = REACHED * K * (p_s - p_a), EMPTIED * K * (p_s - p_a)
    torque, middle = (torque, 0.0) if second else (0.5 * (torque - least), 0.5 * (torque + least))
    return ActuatorLimits(torque, middle, GAMMA * K * fed * flows / V, fed / K)


def _notch(valve: Any, T: float) -> float:
    """Return the weight of the last innovation with which the dither drops out of the mean of three."""
    periods = valve.dither_frequency * T
    seen = (periods > SEEN[0]) & (periods < SEEN[1])
    return seen * -2.0 * np.cos(2.0 * pi * periods)  # type: ignore[no-any-return]


def _variance(sensor: Sensor) -> float:
    """Return the variance of what a sensor says: noise, and an even spread over a count."""
    return sensor.lsb * sensor.lsb / 12.0 + sensor.noise * sensor.noise


def _unknowns(
    described: TrackingControllerPart,
    joints: tuple[Joint, ...],
    actuators: tuple[ActuatorLimits, ...],
    payload: float,
    learns: float,
) -> Prior:
    n = len(joints)
    torques, rubs = [actuator.torque for actuator in actuators], [joint.brake_torque for joint in joints]
    return Prior(
        (*[0.0] * (2 * n), payload),
        (
            *[learns * described.load_spread * torque for torque in torques],
            *[learns * described.friction_spread * rub for rub in rubs],
            learns * described.payload_spread,
        ),
        (*[learns * described.load_wander * torque for torque in torques], *[0.0] * (n + 1)),
        (*[-0.5 * torque for torque in torques], *[-0.6 * rub for rub in rubs], 0.0),
        (*[0.5 * torque for torque in torques], *rubs, np.maximum(5.0, 3.0 * payload)),
        described.angle_errors * described.angle_errors * _variance(joints[0].angle_sensor),
    )
