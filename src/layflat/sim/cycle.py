"""One control cycle of a machine, up to where the plant moves on: sense, control, drive. All time loops share it."""

from typing import Any, NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.control import Demand, Sensed, step
from layflat.jit import composition, law
from layflat.lanes import each, gather, in_lanes, select, slots
from layflat.physics.adjustable import adjusted, regulated
from layflat.physics.joint import Drive, Surroundings
from layflat.physics.sensor import read_sensor
from layflat.physics.valves import driven, start_wave, weaken_wave


class Lead(NamedTuple):
    """Gains that draw a joint to its log."""

    voltage: float  # towards the demand, where the joint follows given voltages, V/rad
    pressure: float  # by which these fall with the differential pressure, V/Pa
    spring: float  # torque towards the demand, N m/rad
    damper: float  # torque towards the velocity of the demand, N m s/rad


NOT_LED = Lead(0.0, 0.0, 0.0, 0.0)


class Acting(NamedTuple):
    """Signals of a joint in a control cycle: rows of the table in motion/scenario.py."""

    demand: float
    demand_velocity: float
    demand_acceleration: float
    demand_stiffness: float
    opening: float  # not a number where the controller or a voltage drives
    voltage: float  # likewise
    brake: float
    dither: float
    load: float
    drift: float


class Around(NamedTuple):
    """Signals in a control cycle that all joints share, likewise."""

    supply: float
    payload: float
    ambient: float


NOTHING, NOTHING_AROUND = Acting(*[0.0] * len(Acting._fields)), Around(*[0.0] * len(Around._fields))
DEMANDS = ("demand", "demand_velocity", "demand_acceleration", "demand_stiffness")  # in the order of `Demand`


class Signals(NamedTuple):
    """A scenario over control cycles; before it is a run's, what is not a number there is as the machine has it."""

    by_joint: np.ndarray  # items of `Acting`, (cycles, joints, signals)
    shared: np.ndarray  # items of `Around`, (cycles, signals)

    def named(self, name: str) -> Array:
        """Return a signal, (cycles, joints), or (cycles,) of one that all joints share."""
        if name in Around._fields:
            return self.shared[:, Around._fields.index(name)]
        return self.by_joint[:, :, Acting._fields.index(name)]


class Noise(NamedTuple):
    """Standard normal samples of a joint's sensors."""

    angle: float
    pressure: float


class Loop(NamedTuple):
    """State of the loop between cycles: slots with an item a joint."""

    acting: Any
    leads: Any
    noise: Any
    drives: Any
    lines: Any
    waves: Any
    voltages: Any
    shares: Any  # of what is adjusted, at the start of the coming cycle


@law
def is_number(given):
    """Return whether something is given."""
    return given == given  # noqa: PLR0124


@law
def surroundings(air, shared):
    """Surroundings of the joints in a control cycle: as a machine has them, and the signals that all joints share."""
    p_a = shared.ambient
    return Surroundings(shared.supply + p_a, air.supply_temperature, p_a, air.ambient_temperature, shared.payload)


@law
def sense(joint, state, noise):
    """Return what a joint's sensors say: angle (rad) and differential pressure (Pa)."""
    return (
        read_sensor(joint.angle_sensor, state.motion.angle, noise.angle),
        read_sensor(joint.pressure_sensor, state.hose_a.pressure - state.hose_b.pressure, noise.pressure),
    )


@composition
def sense_all(joints, like, states, noise):
    """Return what the sensors of all joints say; `like` is a tuple of as many items."""
    zero = 0.0 * states[0].motion.angle
    angles, pressures = slots(like, zero), slots(like, zero)
    for j in range(len(like)):
        angles[j], pressures[j] = sense(joints[j], states[j], noise[j])
    return Sensed(gather(like, angles), gather(like, pressures))


@law
def _asked(acting):
    return acting.demand, acting.demand_velocity, acting.demand_acceleration, acting.demand_stiffness


@composition
def _demanded(like, acting):
    angles, velocities, accelerations, stiffnesses = each(_asked, gather(like, acting))
    return Demand(angles, velocities, accelerations, stiffnesses)


@composition
def _drive(joint, state, line, acting, lead, asked, shares, around, cycle):
    """Drive of a joint for a control cycle, the voltage behind it, and the line of commands after it."""
    valve = joint.valve
    voltage = select(is_number(acting.opening), valve.centre_voltage + valve.volts_to_full * acting.opening, asked)
    motion = state.motion
    behind, difference = acting.demand - motion.angle, state.hose_a.pressure - state.hose_b.pressure
    led = acting.voltage + lead.voltage * behind - lead.pressure * difference
    voltage = select(is_number(acting.voltage), led, voltage)
    opening, line = driven(valve, line, voltage - acting.drift, cycle)
    supply = regulated(shares.supply, around.supply_pressure, around.ambient_pressure)
    load = acting.load + lead.spring * behind + lead.damper * (acting.demand_velocity - motion.velocity)
    return Drive(opening, shares.brake * (acting.brake * joint.brake_torque), load, supply), voltage, line


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
            joint, state, loop.lines[j], loop.acting[j], loop.leads[j], asked[j], shares, around, cycle
        )
        loop.waves[j] = weaken_wave(
            joint.valve, start_wave(joint.valve, time, h), shares.dither * loop.acting[j].dither
        )
    return sensed, in_lanes(after, zero), in_lanes(report, zero)
