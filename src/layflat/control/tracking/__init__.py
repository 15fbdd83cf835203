"""The tracking law: follows moving and resting demands with a model of the whole plant in the loop.

This module defines its table in a machine's file, and derives the law's settings from that table and the machine.

| symbol | meaning | unit |
|---|---|---|
| K | torque per pressure | m3/rad |
| C | sonic conductance of an open valve | m3/(s Pa) |
| V | volume of air in a hose at mid-stroke, with the equivalent volume of its wall's compliance | m3 |
| p_s, p_a | absolute pressures of supply and surroundings | Pa |
| T | control cycle | s |
"""

from collections.abc import Callable
from math import pi, radians
from typing import Annotated, Any, Literal, get_args

from pydantic import Field

from layflat.control.kind import ControlKind, ControllerPart
from layflat.control.tracking.arrival import Tolerance
from layflat.control.tracking.estimation import MatrixZeros, Prior
from layflat.control.tracking.law import SIGNALS, Report, Settings, step, wake
from layflat.control.tracking.limits import ActuatorLimits, LawParts, Margins
from layflat.control.tracking.model import ObserverTuning, PlantModel, step_count
from layflat.control.tracking.torques import Feedback
from layflat.description import units as u
from layflat.errors import MachineError
from layflat.lazy import numpy as np
from layflat.physics.air import GAMMA, GAS_CONSTANT, REFERENCE_DENSITY, REFERENCE_TEMPERATURE
from layflat.physics.arrays import itemwise
from layflat.physics.flow import effective_pressure
from layflat.physics.hose import swept_volume, torque_per_pressure
from layflat.physics.joint import REST_PRESSURE_RATIO, JointParameters, Surroundings, has_second
from layflat.physics.sensor import Sensor
from layflat.physics.valves import VALVE_KINDS

__all__ = ["MAX_BANDWIDTH", "LawPart", "TrackingControllerPart"]

MAX_BANDWIDTH = 0.15  # bandwidth times control cycle, 1
REACHED_SHARE = 0.92  # differential pressure that a moving joint reaches, over the supply's gauge pressure
RESIDUAL_SHARE = 0.2  # pressure left in a single hose of a moving joint, likewise: the last air leaves slowly
MIN_STIFFNESS_SHARE = 0.7  # min stiffness of the feedback over that of the hoses, whatever the joint's inertia
EASING_SHARE = 0.1  # rate at which the torque of a joint that has arrived falls to its load, over the torque's rate
SAMPLED_DITHER = 0.1, 0.45  # range of dither periods per control cycle in which samples resolve the dither
LATE_RESERVE = 0.5  # share of its reserve that the arm keeps if it brakes late
JERK_SHARE = 0.8  # planned rate of the torque over its rate at mid-stroke, since it falls as the hoses fill

PositiveFraction = Annotated[float, Field(gt=0.0, le=1.0)]
LawPart = Literal["feedback", "feedforward", "friction", "governor", "landing", "learning", "pressures"]
"""Parts of the law: feedback of angles; feed-forward of accelerations; compensation of friction; slowing of the
reference when valves saturate; new path from a stop outside the tolerance; estimation of loads, frictions and payload;
correction by pressures."""


class TrackingControllerPart(ControllerPart):
    """Description of the tracking law; all its other settings follow from the machine."""

    kind: Literal["tracking"]
    bandwidth: u.Rate = Field(default=30.0, description="of angles about their reference, at most 0.15 in a cycle")
    torque_errors: u.Share = Field(default=0.008, description="error of the model's torques, over the greatest torque")
    observer_gain: PositiveFraction = Field(
        default=0.95, description="fraction of a pressure's innovation that corrects the estimate in a cycle"
    )
    valve_fraction: PositiveFraction = Field(
        default=0.56, description="fraction of a missing torque that valves make up in a cycle"
    )
    reserve: u.Share = Field(default=0.25, description="fraction of its torques that the arm plans without")
    min_duration: u.Time = Field(default=0.08, description="of a move")
    tolerance: u.Length = Field(default=0.0015, description="distance of the tip from its goal that is left as it is")
    angle_tolerance: u.PositiveAngle = Field(
        default=radians(1.0), description="angle of a joint from its goal that is left as it is"
    )
    blind_angle_tolerance: u.PositiveAngle = Field(
        default=radians(0.2), description="the same where so much does not take the tip out of its tolerance"
    )
    payload_std: u.Mass = Field(
        default=0.0, description="standard deviation of the payload about the described one; 0: it is known"
    )
    load_std: u.Share = Field(default=0.007, description="standard deviation of a load on a joint, over its torque")
    load_drift: u.Share = Field(default=0.04, description="standard deviation of its change in a second, likewise")
    friction_std: u.Share = Field(default=0.25, description="standard deviation of friction over the described one")
    angle_errors: u.Ratio = Field(default=7.0, description="errors of the model's angle over those of the sensor")
    disabled: tuple[LawPart, ...] = Field(default=(), description="parts of the law that are left out, to compare")


def tracking_settings(
    described: TrackingControllerPart, machine: Any, plant_parameters: Callable[[], tuple[Any, Any, Any]]
) -> Settings:
    """Return the settings of the law for a machine.

    Args:
        described: table of the controller.
        machine: the machine that it controls.
        plant_parameters: function that returns the parameters of the plant's laws: arm, joints and surroundings.

    Raises:
        MachineError: the law can't model the machine's valves.
    """
    plant = _plant_model(machine, *plant_parameters())
    joints, n = plant.joints, len(plant.joints)
    actuators = tuple(_actuator_limits(joint, plant.around) for joint in joints)
    T = described.cycle
    w = np.minimum(described.bandwidth, MAX_BANDWIDTH / T)
    error = np.sqrt(_sensor_variance(joints[0].angle_sensor))
    share, notch = described.observer_gain, _notch_weight(joints[0].valve, T)
    has = {part: float(part not in described.disabled) for part in get_args(LawPart)}
    share = share * has["pressures"]
    observer = tuple(ObserverTuning(described.torque_errors * a.torque, error, share, notch) for a in actuators)
    braking, late = 1.0 - described.reserve, 1.0 - LATE_RESERVE * described.reserve
    margins = Margins(braking, late, JERK_SHARE, described.min_duration, _tolerance(described))
    w = w * has["feedback"]
    feedback = tuple(
        Feedback(
            w * w,
            2.0 * w,
            described.valve_fraction,
            EASING_SHARE * a.rate,
            MIN_STIFFNESS_SHARE * has["feedback"] * a.rate / a.speed,
        )
        for a in actuators
    )
    parts = LawParts(has["feedforward"], has["friction"], has["governor"], has["landing"])
    m = 2 * n + 1
    shapes = MatrixZeros((0.0,) * (n * n), (0.0,) * (m * m), (0.0,) * (n * m))
    prior = _parameter_prior(described, joints, actuators, plant.around.payload, has["learning"])
    return Settings(plant, actuators, observer, feedback, margins, parts, prior, shapes)


def _tolerance(described: TrackingControllerPart) -> Tolerance:
    """Return the tolerances of arrival; the blind one of angles is at most the usual one."""
    angle = described.angle_tolerance
    return Tolerance(described.tolerance, angle, np.minimum(described.blind_angle_tolerance, angle))


def _plant_model(machine: Any, arm: Any, joints: tuple[Any, ...], around: Any) -> PlantModel:
    """Return the parameters of the law's model: valves replaced by averaged ones, steps, and whole cycles of delay.

    Raises:
        MachineError: the kind of valve has no averaged form.
    """
    kind = VALVE_KINDS.kind_of(joints[0].valve)
    if kind.mean is None:
        raise MachineError(
            f"a valve of kind {kind.name!r} has no mean that a model of the tracking law could go by",
            where=f"{machine.origin}: controller.kind",
            right='give a valve of kind "spool", or the controller "paper"',
        )
    mean = kind.mean.averaged
    whole = int(np.max([np.floor(np.max(joint.valve.delay) / machine.cycle + 1e-9) for joint in joints]))
    steps = (0.0,) * step_count(arm, joints, around, machine.cycle)
    return PlantModel(
        arm, tuple(joint._replace(valve=mean(joint.valve)) for joint in joints), around, steps, (0.0,) * whole
    )


def _actuator_limits(joint: JointParameters, around: Surroundings) -> ActuatorLimits:
    """Return the limits of a joint at mid-stroke, with hoses as full as leaks leave them, a single hose half full.

    Two hoses yield torque in both directions, and one fills while the other is vented; a single hose does either.
    """
    hose, valve, p_s, p_a = joint.hose_a, joint.valve, around.supply_pressure, around.ambient_pressure
    second = has_second(joint.second)
    p = second * (REST_PRESSURE_RATIO * p_s) + (1.0 - second) * (0.5 * (p_s + p_a))
    K = torque_per_pressure(hose.stroke, hose.neutral)
    V = hose.chamber.dead_volume + swept_volume(hose.stroke, hose.neutral) + GAMMA * hose.chamber.compliance * p
    b, s = valve.critical_ratio, valve.laminar_slope
    filled, vented = itemwise(effective_pressure, p_s, p, b, s), itemwise(effective_pressure, p, p_a, b, s)
    flows = filled + vented if second else np.minimum(filled, vented)
    fed = valve.conductance * (REFERENCE_DENSITY * GAS_CONSTANT * REFERENCE_TEMPERATURE)
    torque, residual = REACHED_SHARE * K * (p_s - p_a), RESIDUAL_SHARE * K * (p_s - p_a)
    torque, middle = (torque, 0.0) if second else (0.5 * (torque - residual), 0.5 * (torque + residual))
    return ActuatorLimits(torque, middle, GAMMA * K * fed * flows / V, fed / K)


def _notch_weight(valve: Any, T: float) -> float:
    """Return the weight of the last innovation with which the mean of three has zero gain at the dither frequency.

    It is 0 where samples do not resolve the dither.
    """
    periods = valve.dither_frequency * T
    sampled = (periods > SAMPLED_DITHER[0]) & (periods < SAMPLED_DITHER[1])
    return sampled * -2.0 * np.cos(2.0 * pi * periods)  # type: ignore[no-any-return]


def _sensor_variance(sensor: Sensor) -> float:
    """Return the variance of a sensor's reading: noise, and a uniform distribution over a count."""
    return sensor.lsb * sensor.lsb / 12.0 + sensor.noise * sensor.noise


def _parameter_prior(
    described: TrackingControllerPart,
    joints: tuple[JointParameters, ...],
    actuators: tuple[ActuatorLimits, ...],
    payload: float,
    learns: float,
) -> Prior:
    """Return the prior of loads, friction and payload (kg); `learns` is 1, or 0 where parameters stay as described."""
    n = len(joints)
    torques, brakes = [actuator.torque for actuator in actuators], [joint.brake_torque for joint in joints]
    return Prior(
        (*[0.0] * (2 * n), payload),
        (
            *[learns * described.load_std * torque for torque in torques],
            *[learns * described.friction_std * brake for brake in brakes],
            learns * described.payload_std,
        ),
        (*[learns * described.load_drift * torque for torque in torques], *[0.0] * (n + 1)),
        (*[-0.5 * torque for torque in torques], *[-0.6 * brake for brake in brakes], 0.0),
        (*[0.5 * torque for torque in torques], *brakes, np.maximum(5.0, 3.0 * payload)),
        described.angle_errors * described.angle_errors * _sensor_variance(joints[0].angle_sensor),
    )


KIND = ControlKind(
    name="tracking",
    description=TrackingControllerPart,
    parameters=tracking_settings,
    models_plant=True,
    parameter_types=(Settings,),
    wake=wake,
    step=step,
    report=Report,
    signals=SIGNALS,
    plans=True,
    gives_up="given_up",
)
