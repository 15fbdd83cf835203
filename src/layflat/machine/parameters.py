"""From a described machine to the parameters of the laws: the one place where units of design become those of physics.

A number of the machine may be an array, an item a run (see sim/ensemble); then so are the parameters it decides.

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
from layflat.control.paper.description import idle_gains
from layflat.control.paper.gains import Settings
from layflat.errors import MachineError
from layflat.lanes import mapped
from layflat.machine import parts, tube
from layflat.machine.model import AngleSensor, Machine, PressureSensor
from layflat.machine.single_acting import second_hoses, springs
from layflat.machine.tube import Line
from layflat.physics.adjustable import FIXED, Adjustable, Adjustables
from layflat.physics.air_balance import SMOOTHING, AirParts
from layflat.physics.arms import ARMS, dynamics
from layflat.physics.arrays import itemwise
from layflat.physics.chamber import Chamber
from layflat.physics.flow import laminar_slope
from layflat.physics.friction import FRICTION, level
from layflat.physics.hose import ConstantStroke, Stroke
from layflat.physics.hysteresis import HYSTERESIS
from layflat.physics.hysteresis.kind import over_pressure
from layflat.physics.joint import Damping, Hose, Joint, Surroundings
from layflat.physics.sensor import Sensor
from layflat.physics.stops_and_springs import Stops
from layflat.physics.valves import VALVES, ValvePart

FOLLOW = 40.0  # rate at which estimate in the hoses' pressures follows what is measured: fast beside a move, 1/s
DITHER_RATE = 1e3  # at which a driver's electronics change the share of their dither, 1/s


def full_travel(joint: parts.Joint) -> float:
    """S: output angle between the collapsed hose and its end of travel, rad."""
    return joint.geometry.full_travel(joint.output.radius)


def stroke(joint: parts.Joint) -> ConstantStroke | Stroke:
    """K over the travel of one hose: Eq. (1) for a roller, its mean for a cam."""
    geometry, r = joint.geometry, joint.output.radius
    return geometry.even_stroke(r) if joint.output.kind == "cam" else geometry.stroke(r)


def torque_constant(joint: parts.Joint) -> float:
    """Greatest K over the travel, m3/rad: maximum torque per gauge pressure."""
    curve = stroke(joint)
    if isinstance(curve, ConstantStroke):
        return curve.k0
    S, t = full_travel(joint), np.linspace(0.0, 1.0, 101)
    return np.max(sum(np.multiply.outer(t**i, k * S**i) for i, k in enumerate(curve)), axis=0)  # type: ignore[no-any-return]


def loss_share(joint: parts.Joint) -> float:
    """Loop height over greatest torque at the reference pressure, of hose, strap and rollers together."""
    share = joint.hose.loss_share * joint.cover.loss_factor + joint.strap.loss_share
    roller = joint.deflecting_roller
    if roller is not None:
        bend = joint.strap.thickness / roller.diameter
        share += roller.count * (roller.friction_share + roller.bending_share * bend)
    return share


def loss(joint: parts.Joint) -> tuple[Any, Damping]:
    """Parameters of the hysteresis of one hose with its strap, and of what they damp."""
    losses = joint.losses
    # A loop is twice as high as the torque that opposes either way.
    limit = 0.5 * loss_share(joint) * torque_constant(joint) * losses.reference_pressure_gauge
    return HYSTERESIS.parameters(losses, limit), Damping(*over_pressure(losses, losses.damping_time * limit))


def hose(joint: parts.Joint) -> Hose:
    """One hose in its joint."""
    chamber = Chamber(joint.hose.dead_volume, joint.hose.compliance, joint.hose.wall_conductance)
    law, damping = loss(joint)
    return Hose(stroke(joint), chamber, law, full_travel(joint) / 2, damping)


def no_hose(hose: Hose) -> Hose:
    """In place of the second hose of a single-acting joint that has this one: it turns nothing."""
    return Hose(ConstantStroke(0.0), Chamber(1e-5, 0.0, 0.0), mapped(hose.loss, lambda _: 0.0), 0.0)


def long_stroke(stroke: ConstantStroke | Stroke) -> Stroke:
    """The same stroke as one that may change over its travel."""
    return Stroke(*stroke, *[0.0] * (len(Stroke._fields) - len(stroke)))


def sensor(described: AngleSensor | PressureSensor) -> Sensor:
    """A sensor centred on zero."""
    half = described.range / 2
    return Sensor(-half, half, described.range / 2**described.bits, described.offset, described.noise)


def drive_parts(machine: Machine) -> tuple[ValvePart, AngleSensor, PressureSensor]:
    """Valve and sensors of a machine that moves by itself; raise MachineError if it has none, as the open-loop rigs."""
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
    rubbing = frictions(machine)
    return tuple(
        _joint(machine, name, rubbing[name], even=even)._replace(spring=spring, second=second)
        for name, spring, second in zip(machine.joints, springs(machine), second_hoses(machine), strict=True)
    )


def friction(joint: parts.Joint) -> Any:
    """Parameters of the friction of a joint's output shaft; of Coulomb friction where nothing is said."""
    if joint.friction is None:
        return FRICTION.named(FRICTION.usual).plain
    return FRICTION.parameters(joint.friction)


def frictions(machine: Machine) -> dict[str, Any]:
    """Return the parameters of each joint's friction, by joint, all of one kind, so that joints can go side by side.

    Beside another kind, a joint with Coulomb friction gets that kind's parameters that are Coulomb friction.

    Raises:
        MachineError: the joints have friction of different kinds.
    """
    found = {name: friction(joint) for name, joint in machine.joints.items()}
    kinds = {kind.name: kind for kind in map(FRICTION.of, found.values()) if kind.name != FRICTION.usual}
    if not kinds:
        return found
    kind, *others = kinds.values()
    plain = [name for name, of in found.items() if FRICTION.of(of).name == FRICTION.usual]
    if others or (plain and kind.plain is None):
        names = ", ".join(sorted({FRICTION.of(of).name for of in found.values()}))
        raise MachineError(
            f"has joints with friction of the kinds {names}",
            where=f"{machine.origin}: joint",
            right="give all joints friction of one kind",
        )
    return found | dict.fromkeys(plain, kind.plain)


def static_friction(joint: parts.Joint, gauge: float) -> float:
    """Torque up to which the shaft is held at rest with both hoses at a gauge pressure (Pa), N m."""
    pull = 2.0 * torque_constant(joint) * gauge
    return itemwise(partial(level, friction(joint)), joint.brake.torque, 0.0, pull)


def held_pressure(joint: parts.Joint, gauge: float) -> float:
    """Differential pressure (Pa) to which friction and losses hold the shaft, hoses being at a gauge pressure (Pa)."""
    return static_friction(joint, gauge) / torque_constant(joint) + 0.5 * loss_share(joint) * gauge


def _behind(line: Line, hose: Hose) -> Hose:
    """A hose behind a tube."""
    chamber = hose.chamber._replace(dead_volume=hose.chamber.dead_volume + 0.5 * tube.volume(line))
    return hose._replace(chamber=chamber, line=tube.parameters(line))


def _valve(machine: Machine, name: str) -> Any:
    """Parameters of the valve of a joint, of its size; its tube delays what it does."""
    law, size, line = VALVES.parameters(drive_parts(machine)[0]), machine.joint[name].valve_size, machine.lines[name]
    delay = law.delay + (0.0 if line is None else tube.delay(line))
    return law._replace(conductance=size * law.conductance, leakage=size * law.leakage, delay=delay)


def _joint(machine: Machine, name: str, rubbing: Any, *, even: bool) -> Joint:
    described, (valve, angle_sensor, pressure_sensor) = machine.joint[name], drive_parts(machine)
    pulling = hose(described)
    pushing = pulling if described.acting == "double" else no_hose(pulling)
    line = machine.lines[name]
    if line is not None:
        pulling, pushing = _behind(line, pulling), _behind(line, pushing)
    if not even:
        pulling, pushing = (h._replace(stroke=long_stroke(h.stroke)) for h in (pulling, pushing))
    return Joint(
        pulling,
        pushing,
        _valve(machine, name),
        stops(described),
        described.brake.viscous,
        described.brake.torque,
        rubbing,
        sensor(angle_sensor),
        sensor(pressure_sensor),
        adjustables(described, valve.least_dither),
    )


def adjustables(joint: parts.Joint, least_dither: float) -> Adjustables:
    """Return what a controller can adjust of a joint besides its valve's opening."""
    dither = Adjustable(least_dither, DITHER_RATE)
    return Adjustables(_adjustable(joint.brake.calliper), dither, _adjustable(joint.regulator))


def _adjustable(described: parts.Calliper | parts.Regulator | None) -> Adjustable:
    return FIXED if described is None else Adjustable(described.least, 1.0 / described.stroke_time)


def stops(joint: parts.Joint) -> Stops:
    """End stops on both sides; squeezing begins where the opposite hose is collapsed."""
    limit = joint.stops.mechanical_stroke / 2
    squeeze = np.minimum(full_travel(joint) / 2, limit)
    return Stops(squeeze, joint.stops.squeeze_stiffness, limit, joint.stops.stop_stiffness, joint.stops.stop_damping)


def check_inside_stroke(machine: Machine, name: str, angle: float, where: str) -> float:
    """An angle (rad) that the joint can reach; raise MachineError if it lies outside the working stroke."""
    half = machine.joint[name].stops.working_stroke / 2
    if not abs(angle) <= half + radians(1e-9):
        raise MachineError(
            f"{degrees(angle):.6g} deg is outside the working stroke of joint {name!r}",
            where=where,
            right=f"stay within +-{degrees(half):.6g} deg",
        )
    return angle


def arm(machine: Machine) -> Any:
    """Masses of the arm, without payload: parameters of its kind."""
    return ARMS.parameters(machine.arm, list(machine.joints.values()))


def mass_and_pull(arm: Any, payload: float, angles: Sequence[float] | Array) -> tuple[Array, Array]:
    """Mass matrix (..., joints, joints), kg m2, and torques that come of the angles (..., joints), N m, of an arm.

    Args:
        arm: parameters of a kind of arm.
        payload: kg.
        angles: rad, (..., joints): one posture, or any number.
    """
    q = np.asarray(angles, dtype=float)
    *places, n = q.shape
    # Scalars as they are: laws of one's own may be plain Python.
    each = tuple(q[..., j] if places else float(q[j]) for j in range(n))
    upper, _, pulls = dynamics(arm, payload, each, (0.0,) * n)
    mass = np.zeros((*places, n, n))
    for row, column, item in zip(*np.triu_indices(n), upper, strict=True):
        mass[..., row, column] = mass[..., column, row] = item
    return mass, np.stack([np.broadcast_to(pull, places) for pull in pulls], axis=-1)


def surroundings(machine: Machine) -> Surroundings:
    """Air outside and at the supply, and the payload."""
    air = machine.supply
    return Surroundings(
        air.pressure, air.temperature, air.ambient_pressure, air.ambient_temperature, machine.arm.payload
    )


def plant(machine: Machine) -> tuple[Any, Any, Any]:
    """Parameters of the laws of its arm, its joints (a tuple, from base to tip) and what is around them.

    Raises:
        MachineError: it has no valve or sensors.
    """
    return arm(machine), joints(machine), surroundings(machine)


def control(machine: Machine, *, closed_loop: bool = True) -> Any:
    """Settings of the machine's control law; of one that only watches where an open-loop run needs no more.

    Raises:
        MachineError: the machine has no valve, controller or gains.
    """
    valve, _, _ = drive_parts(machine)
    law = machine.control_law
    lacking = law.gains is not None and any(joint.gains is None for joint in machine.joints.values())
    if not closed_loop and (machine.controller is None or lacking):
        return Settings(tuple(idle_gains(valve) for _ in machine.joints))
    if machine.controller is None:
        raise MachineError("has no controller", where=machine.origin, right="copy that of paper-arm, gains included")
    modelled = (partial(plant, machine),) if law.models_plant else ()
    return CONTROL_LAWS.parameters(machine.controller, machine, *modelled)


def air_parts(machine: Machine, name: str) -> AirParts:
    """Return what the watch over a joint's air has to know; a hose with a roller counts with its mean torque.

    Raises:
        MachineError: the machine has no valve or sensors.
    """
    valve, _, _ = drive_parts(machine)
    joint, line = machine.joint[name], machine.lines[name]
    return AirParts(
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
        FOLLOW,
        SMOOTHING,
        machine.safety.speed,
    )
