"""One control cycle of a machine, up to where the plant moves on: sense, control, drive. All time loops share it."""

from typing import Any, NamedTuple

from layflat.control import Demand, Sensed, step
from layflat.jit import composition, law
from layflat.lanes import each, gather, in_lanes, select, slots
from layflat.physics.adjustable import adjusted, regulated
from layflat.physics.joint import Drive
from layflat.physics.sensor import read_sensor
from layflat.physics.valves import driven, start_wave, weaken_wave


class Wanted(NamedTuple):
    """What is asked of a joint in a control cycle."""

    angle: float  # rad
    velocity: float  # rad/s
    acceleration: float  # rad/s2
    stiffness: float  # N m/rad; 0: as it comes


class Lead(NamedTuple):
    """What draws a joint to what a log has of it."""

    voltage: float  # towards the demand, where the joint follows given voltages, V/rad
    pressure: float  # by which these fall with the differential pressure, V/Pa
    spring: float  # torque towards the demand, N m/rad
    damper: float  # torque towards the velocity of the demand, N m s/rad


NOT_LED = Lead(0.0, 0.0, 0.0, 0.0)


class Acting(NamedTuple):
    """What acts on a joint in a control cycle."""

    demand: Wanted
    opening: float  # in place of the controller, -1..1; not a number where it drives
    voltage: float  # in place of the controller, V; not a number where it drives
    lead: Lead
    brake: float  # torque at which the brake slips, N m
    dither: float  # share of the valve's dither
    load: float  # external torque, N m
    drift: float  # shift of the valve's centre, V


class Noise(NamedTuple):
    """Standard normal samples of a joint's sensors."""

    angle: float
    pressure: float


class Loop(NamedTuple):
    """What goes on in the joints between cycles: slots with an item a joint."""

    acting: Any
    noise: Any
    drives: Any
    lines: Any
    waves: Any
    voltages: Any
    shares: Any  # of what is adjusted, at the start of the coming cycle


@law
def is_number(given):
    """Whether something is given."""
    return given == given  # noqa: PLR0124


@law
def sense(joint, state, noise):
    """What a joint's sensors say: angle (rad) and differential pressure (Pa)."""
    return (
        read_sensor(joint.angle_sensor, state.motion.angle, noise.angle),
        read_sensor(joint.pressure_sensor, state.hose_a.pressure - state.hose_b.pressure, noise.pressure),
    )


@composition
def sense_all(joints, like, states, noise):
    """What the sensors of all joints say; `like` is a tuple of as many items."""
    zero = 0.0 * states[0].motion.angle
    angles, pressures = slots(like, zero), slots(like, zero)
    for j in range(len(like)):
        angles[j], pressures[j] = sense(joints[j], states[j], noise[j])
    return Sensed(gather(like, angles), gather(like, pressures))


@law
def _asked(acting):
    wanted = acting.demand
    return wanted.angle, wanted.velocity, wanted.acceleration, wanted.stiffness


@composition
def _demanded(like, acting):
    angles, velocities, accelerations, stiffnesses = each(_asked, gather(like, acting))
    return Demand(angles, velocities, accelerations, stiffnesses)


@composition
def _drive(joint, state, line, acting, asked, shares, around, cycle):
    """Drive of a joint for a control cycle, the voltage behind it, and the line of commands after it."""
    valve = joint.valve
    voltage = select(is_number(acting.opening), valve.centre_voltage + valve.volts_to_full * acting.opening, asked)
    lead, wanted, motion = acting.lead, acting.demand, state.motion
    behind, difference = wanted.angle - motion.angle, state.hose_a.pressure - state.hose_b.pressure
    led = acting.voltage + lead.voltage * behind - lead.pressure * difference
    voltage = select(is_number(acting.voltage), led, voltage)
    opening, line = driven(valve, line, voltage - acting.drift, cycle)
    supply = regulated(shares.supply, around.supply_pressure, around.ambient_pressure)
    load = acting.load + lead.spring * behind + lead.damper * (wanted.velocity - motion.velocity)
    return Drive(opening, shares.brake * acting.brake, load, supply), voltage, line


@composition
def control_cycle(joints, like, settings, memory, states, loop, around, time, cycle, h):
    """Begin the control cycle at a time (s): returns what was sensed, memory, and report; drives are set in the loop.

    Args: joints (slots), and a tuple `like` of as many items; settings and memory of the control law; states (slots);
    `Loop`, of which `acting` and `noise` hold what is so in this cycle; `Surroundings`; lengths of the cycle and of a
    step of the plant, s.
    """
    zero = 0.0 * states[0].motion.angle
    sensed = sense_all(joints, like, states, loop.noise)
    after, command, report = step(settings, memory, sensed, _demanded(like, loop.acting), cycle)
    asked, commanded = slots(in_lanes(command.voltage, zero)), slots(in_lanes(command.shares, zero))
    for j in range(len(like)):
        joint, state = joints[j], states[j]
        shares, loop.shares[j] = adjusted(joint.adjustables, loop.shares[j], commanded[j], cycle)
        loop.drives[j], loop.voltages[j], loop.lines[j] = _drive(
            joint, state, loop.lines[j], loop.acting[j], asked[j], shares, around, cycle
        )
        loop.waves[j] = weaken_wave(
            joint.valve, start_wave(joint.valve, time, h), shares.dither * loop.acting[j].dither
        )
    return sensed, in_lanes(after, zero), in_lanes(report, zero)
