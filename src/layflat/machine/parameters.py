"""Parameters of the laws from a described machine.

A number of the machine may be an array, an item a run (see sim/ensemble); then so are the parameters that depend on it.

| symbol | meaning | unit |
|---|---|---|
| s | travel of a hose: output angle from its collapsed state on | rad |
| S | full travel | rad |
| K | torque per pressure | m3/rad |
"""

from collections.abc import Sequence
from functools import partial
from math import degrees, inf, radians
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.control import CONTROL_LAWS
from layflat.control.paper import idle_gains
from layflat.control.paper.law import Settings
from layflat.errors import MachineError
from layflat.lanes import Like, mapped
from layflat.machine import parts, tube
from layflat.machine.model import AngleSensor, Machine, PressureSensor
from layflat.machine.tube import TubePart
from layflat.physics.adjustable import NOT_ADJUSTABLE, FractionLimits, JointFractionLimits
from layflat.physics.air_balance import RESIDUAL_SMOOTHING_TIME, AirObserverParameters
from layflat.physics.arms import ARM_KINDS, dynamics
from layflat.physics.arrays import itemwise
from layflat.physics.chamber import Chamber
from layflat.physics.flow import laminar_slope
from layflat.physics.friction import FRICTION, slip_torque
from layflat.physics.hose import ConstantStroke, PolynomialStroke
from layflat.physics.hysteresis import HYSTERESIS
from layflat.physics.hysteresis.kind import split_by_pressure
from layflat.physics.joint import Damping, HoseParameters, JointParameters, SecondHose, Surroundings, TwoHoses
from layflat.physics.sensor import Sensor
from layflat.physics.stops_and_springs import NoSpring, SpringParameters, StopParameters
from layflat.physics.valves import VALVE_KINDS, ValvePart

PRESSURE_OBSERVER_GAIN = 40.0  # of the pressure estimate, 1/s: fast compared with a move
DITHER_RATE = 1e3  # rate at which a driver's electronics change the fraction of the dither, 1/s


def full_travel(joint: parts.Joint) -> float:
    """Return S: output angle between the collapsed hose and its end of travel, rad."""
    return joint.geometry.full_travel(joint.output.radius)


def stroke(joint: parts.Joint) -> ConstantStroke | PolynomialStroke:
    """Return K over the travel of one hose: Eq. (1) for a roller, its mean for a cam."""
    geometry, r = joint.geometry, joint.output.radius
    return geometry.even_stroke(r) if joint.output.kind == "cam" else geometry.stroke(r)


def torque_constant(joint: parts.Joint) -> float:
    """Return the maximum of K over the travel, m3/rad: maximum torque per gauge pressure."""
    curve = stroke(joint)
    if isinstance(curve, ConstantStroke):
        return curve.k0
    S, t = full_travel(joint), np.linspace(0.0, 1.0, 101)
    return np.max(sum(np.multiply.outer(t**i, k * S**i) for i, k in enumerate(curve)), axis=0)  # type: ignore[no-any-return]


def loss_fraction(joint: parts.Joint) -> float:
    """Return loop height over maximum torque at the reference pressure, of hose, strap and rollers together."""
    share = joint.hose.loss_fraction * joint.cover.loss_factor + joint.strap.loss_fraction
    roller = joint.deflecting_roller
    if roller is not None:
        bend = joint.strap.thickness / roller.diameter
        share += roller.count * (roller.friction_fraction + roller.bending_fraction * bend)
    return share


def loss(joint: parts.Joint) -> tuple[Any, Damping]:
    """Return the parameters of the hysteresis of one hose with its strap, and their damping."""
    losses = joint.losses
    # A loop is twice as high as the torque against either direction.
    limit = 0.5 * loss_fraction(joint) * torque_constant(joint) * losses.reference_pressure_gauge
    return HYSTERESIS.parameters(losses, limit), Damping(*split_by_pressure(losses, losses.damping_time * limit))


def hose(joint: parts.Joint) -> HoseParameters:
    """Return the parameters of one hose in its joint, without its tube."""
    chamber = Chamber(joint.hose.dead_volume, joint.hose.compliance, joint.hose.wall_conductance)
    law, damping = loss(joint)
    return HoseParameters(stroke(joint), chamber, law, full_travel(joint) / 2, damping)


def missing_hose(hose: HoseParameters) -> HoseParameters:
    """Return the parameters in place of hose B of a single-acting joint with this hose A: without torque."""
    return HoseParameters(ConstantStroke(0.0), Chamber(1e-5, 0.0, 0.0), mapped(hose.loss, lambda _: 0.0), 0.0)


def polynomial_stroke(stroke: ConstantStroke | PolynomialStroke) -> PolynomialStroke:
    """Return a stroke as a polynomial over the travel."""
    return PolynomialStroke(*stroke, *[0.0] * (len(PolynomialStroke._fields) - len(stroke)))


def sensor(described: AngleSensor | PressureSensor) -> Sensor:
    """Return the parameters of a sensor whose range is centred on zero."""
    half = described.range / 2
    return Sensor(-half, half, described.range / 2**described.bits, described.offset, described.noise)


def valve_and_sensors(machine: Machine) -> tuple[ValvePart, AngleSensor, PressureSensor]:
    """Return valve and sensors of a machine; raise MachineError if one of them is missing."""
    if machine.valve is None or machine.angle_sensor is None or machine.pressure_sensor is None:
        raise MachineError(
            "has no valve or sensors: it is a rig for torque-angle loops",
            where=machine.origin,
            right="`layflat joint sweep` sweeps it at constant pressure",
        )
    return machine.valve, machine.angle_sensor, machine.pressure_sensor


def joints(machine: Machine) -> tuple[JointParameters, ...]:
    """Return the parameters of every joint, from base to tip, all of one structure, as lanes need.

    Raises:
        MachineError: no valve or sensors, or friction, losses or tubes of different kinds or numbers of elements.
    """
    even = all(described.output.kind == "cam" for described in machine.joints.values())
    rubbing = frictions(machine)
    values = tuple(
        _joint_parameters(machine, name, rubbing[name], even=even)._replace(spring=spring, second=second)
        for name, spring, second in zip(machine.joints, springs(machine), second_hoses(machine), strict=True)
    )
    first = next(iter(machine.joints))
    for name, joint in zip(machine.joints, values, strict=True):
        if Like.from_tuple(joint) is not Like.from_tuple(values[0]):
            what = f"has losses or a tube of another kind, or of another number of elements, than joint.{first}"
            right = "give all joints the same kinds, with as many elements"
            raise MachineError(what, where=f"{machine.origin}: joint.{name}", right=right)
    return values


def friction(joint: parts.Joint) -> Any:
    """Return the parameters of the friction of a joint's output shaft; Coulomb friction by default."""
    if joint.friction is None:
        return FRICTION.named(FRICTION.usual).plain
    return FRICTION.parameters(joint.friction)


def frictions(machine: Machine) -> dict[str, Any]:
    """Return the parameters of each joint's friction, by joint, all of one kind, so that joints fit into lanes.

    Beside another kind, a joint with Coulomb friction gets that kind's parameters that are Coulomb friction.

    Raises:
        MachineError: the joints have friction of different kinds.
    """
    by_joint = {name: friction(joint) for name, joint in machine.joints.items()}
    kinds = {kind.name: kind for kind in map(FRICTION.kind_of, by_joint.values()) if kind.name != FRICTION.usual}
    if not kinds:
        return by_joint
    kind, *others = kinds.values()
    plain = [name for name, values in by_joint.items() if FRICTION.kind_of(values).name == FRICTION.usual]
    if others or (plain and kind.plain is None):
        names = ", ".join(sorted({FRICTION.kind_of(values).name for values in by_joint.values()}))
        raise MachineError(
            f"has joints with friction of the kinds {names}",
            where=f"{machine.origin}: joint",
            right="give all joints friction of one kind",
        )
    return by_joint | dict.fromkeys(plain, kind.plain)


def static_friction(joint: parts.Joint, gauge: float) -> float:
    """Return the torque up to which the shaft is held at rest with both hoses at a gauge pressure (Pa), N m."""
    pull = 2.0 * torque_constant(joint) * gauge
    return itemwise(partial(slip_torque, friction(joint)), joint.brake.torque, 0.0, pull)


def held_pressure(joint: parts.Joint, gauge: float) -> float:
    """Return the differential pressure (Pa) up to which friction and losses hold the shaft at a gauge pressure (Pa)."""
    return static_friction(joint, gauge) / torque_constant(joint) + 0.5 * loss_fraction(joint) * gauge


def _hose_behind_tube(line: TubePart, hose: HoseParameters) -> HoseParameters:
    """Return the parameters of a hose behind a tube."""
    chamber = hose.chamber._replace(dead_volume=hose.chamber.dead_volume + 0.5 * tube.volume(line))
    return hose._replace(chamber=chamber, line=tube.parameters(line))


def _valve(machine: Machine, name: str) -> Any:
    """Return the parameters of the valve of a joint, with its size, and the delay of its tube."""
    law, line = VALVE_KINDS.parameters(valve_and_sensors(machine)[0]), machine.lines[name]
    size = machine.joint[name].valve_size
    delay = law.delay + (0.0 if line is None else tube.delay(line))
    return law._replace(conductance=size * law.conductance, leakage=size * law.leakage, delay=delay)


def _joint_parameters(machine: Machine, name: str, rubbing: Any, *, even: bool) -> JointParameters:
    """Return the parameters of a joint's laws, with friction `rubbing`; strokes are polynomials unless `even`."""
    described, (valve, angle_sensor, pressure_sensor) = machine.joint[name], valve_and_sensors(machine)
    pulling = hose(described)
    pushing = pulling if described.acting == "double" else missing_hose(pulling)
    line = machine.lines[name]
    if line is not None:
        pulling, pushing = _hose_behind_tube(line, pulling), _hose_behind_tube(line, pushing)
    if not even:
        pulling, pushing = (h._replace(stroke=polynomial_stroke(h.stroke)) for h in (pulling, pushing))
    return JointParameters(
        pulling, pushing, _valve(machine, name), stops(described), described.brake.viscous, described.brake.torque,
        rubbing, sensor(angle_sensor), sensor(pressure_sensor), fraction_limits(described, valve.min_dither),
    )  # fmt: skip


def fraction_limits(joint: parts.Joint, min_dither: float) -> JointFractionLimits:
    """Return the limits of the brake, dither and supply fractions of a joint."""
    calliper, regulator = joint.brake.calliper, joint.regulator
    brake = NOT_ADJUSTABLE if calliper is None else _stroke_limits(calliper.released_fraction, calliper.stroke_time)
    supply = NOT_ADJUSTABLE if regulator is None else _stroke_limits(regulator.min_fraction, regulator.stroke_time)
    dither = FractionLimits(min_dither, DITHER_RATE)
    return JointFractionLimits(brake, dither, supply)


def _stroke_limits(lower: float, stroke_time: float) -> FractionLimits:
    return FractionLimits(lower, 1.0 / stroke_time)


def stops(joint: parts.Joint) -> StopParameters:
    """Return the parameters of the end stops; squeezing begins with the opposite hose collapsed, or at the stop."""
    limit = joint.stops.mechanical_stroke / 2
    squeeze = np.minimum(full_travel(joint) / 2, limit)
    return StopParameters(
        squeeze, joint.stops.squeeze_stiffness, limit, joint.stops.stop_stiffness, joint.stops.stop_damping
    )


def check_inside_stroke(machine: Machine, name: str, angle: float, where: str) -> float:
    """Return an angle if it lies inside the working stroke of a joint.

    Args:
        machine: the machine.
        name: name of the joint.
        angle: angle from mid-stroke, rad.
        where: argument or key of the angle, for the message.

    Raises:
        MachineError: the angle lies outside.
    """
    half = machine.joint[name].stops.working_stroke / 2
    if not abs(angle) <= half + radians(1e-9):
        raise MachineError(
            f"{degrees(angle):.6g} deg is outside the working stroke of joint {name!r}",
            where=where,
            right=f"stay within +-{degrees(half):.6g} deg",
        )
    return angle


def arm(machine: Machine) -> Any:
    """Return the parameters of the arm's kind, without payload."""
    return ARM_KINDS.parameters(machine.arm, list(machine.joints.values()))


def mass_and_pull(arm: Any, payload: float, angles: Sequence[float] | Array) -> tuple[Array, Array]:
    """Return mass matrix (..., joints, joints), kg m2, and gravity and spring torques (..., joints), N m, of an arm.

    Args:
        arm: parameters of a kind of arm.
        payload: kg.
        angles: rad, (..., joints), of any number of configurations.
    """
    q = np.asarray(angles, dtype=float)
    *places, n = q.shape
    # Scalars stay scalars: users' laws may be plain Python.
    by_joint = tuple(q[..., j] if places else float(q[j]) for j in range(n))
    upper, _, pulls = dynamics(arm, payload, by_joint, (0.0,) * n)
    mass = np.zeros((*places, n, n))
    for row, column, item in zip(*np.triu_indices(n), upper, strict=True):
        mass[..., row, column] = mass[..., column, row] = item
    return mass, np.stack([np.broadcast_to(pull, places) for pull in pulls], axis=-1)


def surroundings(machine: Machine) -> Surroundings:
    """Return pressures and temperatures of supply and ambient air, and the payload, as parameters of the laws."""
    air = machine.supply
    return Surroundings(
        air.pressure, air.temperature, air.ambient_pressure, air.ambient_temperature, machine.arm.payload
    )


def plant(machine: Machine) -> tuple[Any, Any, Any]:
    """Return the parameters of arm, joints (a tuple, from base to tip) and surroundings of a machine.

    Raises:
        MachineError: it has no valve or sensors.
    """
    return arm(machine), joints(machine), surroundings(machine)


def control(machine: Machine, *, closed_loop: bool = True) -> Any:
    """Return the settings of the control law; in an open loop without controller or gains, those of an idle one.

    Raises:
        MachineError: the machine has no valve or sensors, or, in closed loop, no controller or gains.
    """
    valve_and_sensors(machine)
    law = machine.control_law
    lacking = law.gains is not None and any(joint.gains is None for joint in machine.joints.values())
    if not closed_loop and (machine.controller is None or lacking):
        return idle_control(machine)
    if machine.controller is None:
        raise MachineError("has no controller", where=machine.origin, right="copy that of paper-arm, gains included")
    modelled = (partial(plant, machine),) if law.models_plant else ()
    return CONTROL_LAWS.parameters(machine.controller, machine, *modelled)


def idle_control(machine: Machine) -> Settings:
    """Return the settings of a law that only observes: all its gains are zero.

    Raises:
        MachineError: the machine has no valve or sensors.
    """
    valve, _, _ = valve_and_sensors(machine)
    return Settings(tuple(idle_gains(valve) for _ in machine.joints))


def air_observer_parameters(machine: Machine, name: str) -> AirObserverParameters:
    """Return the parameters of the observer of a joint's air; the torque of a hose with a roller is averaged.

    Raises:
        MachineError: the machine has no valve or sensors.
    """
    valve, _, _ = valve_and_sensors(machine)
    joint, line = machine.joint[name], machine.lines[name]
    return AirObserverParameters(
        joint.hose.dead_volume + (0.0 if line is None else tube.volume(line)),
        joint.geometry.even_stroke(joint.output.radius).k0,
        full_travel(joint) / 2,
        joint.valve_size * valve.conductance,
        joint.valve_size * valve.leakage,
        inf if line is None else tube.conductance(line),
        valve.critical_ratio,
        float(laminar_slope(valve.critical_ratio)),
        valve.covered,
        valve.dithered.amplitude if valve.dithered is not None else 0.0,
        PRESSURE_OBSERVER_GAIN,
        RESIDUAL_SMOOTHING_TIME,
        machine.safety.speed,
    )


def springs(machine: Machine) -> list[NoSpring | SpringParameters]:
    """Return the parameters of each joint's spring, all of one class, so that joints fit into lanes."""
    described = [joint.spring for joint in machine.joints.values()]
    if not any(described):
        return [NoSpring() for _ in described]
    return [SpringParameters(part.torque, part.stiffness) if part else SpringParameters(0.0, 0.0) for part in described]


def second_hoses(machine: Machine) -> list[TwoHoses | SecondHose]:
    """Return whether each joint has hose B, as parameters of one class: `TwoHoses` if all have it."""
    double = [joint.acting == "double" for joint in machine.joints.values()]
    return [TwoHoses() if all(double) else SecondHose(float(has_second)) for has_second in double]
