"""What a rig is watched by, as plain numbers, from the description of a machine with valve and sensors.

Raises MachineError where it has none.
"""

from math import erf, hypot, inf, sqrt

from layflat.machine import Machine, parameters
from layflat.machine.parameters import drive_parts
from layflat.machine.parameters import sensor as sensor_law
from layflat.motion.limits import abilities
from layflat.motion.rates import JERK, SURGE
from layflat.physics.air import GAMMA
from layflat.physics.joint import FILLED
from layflat.physics.sensor import Sensor
from layflat.rig.abilities import demand_limits, payloads, resting_angles
from layflat.rig.safety import moving
from layflat.rig.safety.cycle_numbers import Rig, Settings
from layflat.rig.safety.demands import Gate
from layflat.rig.safety.detectors import (
    angle_frozen,
    doubt,
    following,
    joint,
    outside,
    pressure_frozen,
    rail,
    supply,
    valve_unresponsive,
)  # fmt: skip
from layflat.rig.safety.faults import Fault

LIVELY = 0.3  # noise of a sensor, in counts, from which on it never reports the same count for 20 samples
RAIL = 2.0  # counts from the end of a converter's range, at which a sensor is taken to be open or shorted
GRAIN = 3.5  # standard deviations of noise that are taken for a count, where a count is less
SELDOM = 1e-12  # chance from which on samples are never all the same: at 200 a second, once in a million hours
NOISE = 2.0  # counts by which a sample may be wrong: a joint at a limit is found in spite of them
# Cycles less than the table of faults gives to find one, and that the ripple takes to show that there is none.
SPARE, RIPPLE_AFTER = 2.0, 4.0
NEVER = 4.5  # standard errors of the pressure that its ripple would have to be without dither
PAUSES = (
    0.65  # of the time to find that a ripple is gone in which a law that plans leaves the spool room for its dither
)
# Residual of air around a joint at rest, as an opening of its valve, besides that of filling: sound ones had 0.054.
STILL = 0.1
HIDES = 1.5  # times what friction of a joint in motion is, it may be at rest
LANDS = 0.05  # error within which a law that plans its motion stops a joint as soon as it can, rad
AVERAGED = 3.5  # cycles after which an average of four samples has none of before
STOPS = 2.0  # times what friction alone takes, a joint may lose of its speed in a cycle: the others and its air help
FLUNG = 2.0  # of the speed that its valve feeds, up to which a joint with less payload than the law expects may go
THROWN = 0.05  # time that a joint's stop takes to throw it back, and more, s
SPEED_IS_GIVEN = "demand_speed"  # in a machine's file: then laws that plan their motion keep to it, too
# Cycles of the same sample after which a sensor may be frozen, and after which it is, where it does not fit.
DOUBTFUL, SURE = 2.5, 7.5


def rig_settings(machine: Machine) -> Rig:
    """Settings of the machine as a whole."""
    valve, _, _ = drive_parts(machine)
    safety, source, span, cycle = machine.safety, machine.supply, valve.volts_to_full, machine.cycle
    lost = Fault.SUPPLY_LOST.seconds - RIPPLE_AFTER * cycle
    return Rig(
        cycle,
        valve.centre_voltage,
        1.0 / span,
        source.ambient_pressure,
        *payloads(machine),
        valve.centre_voltage - span,
        valve.centre_voltage + span,
        safety.demand_lead,
        safety.demand_margin,
        1.0 if plans(machine) else 0.0,
        supply.Limits(
            low=source.ambient_pressure + safety.supply_low * source.pressure_gauge,
            high=source.ambient_pressure + safety.overpressure * source.pressure_gauge,
            patience=max(lost - SPARE * cycle, cycle),
        ),
    )


def joint_settings(machine: Machine, name: str) -> Settings:
    """Settings of a joint."""
    stops = machine.joint[name].stops
    averaged = getattr(machine.controller, "averaged", True)
    return Settings(
        joint_limits(machine, name),
        parameters.air_parts(machine, name),
        Gate(0.5 * stops.working_stroke, 0.5 * stops.mechanical_stroke, demand_pace(machine, name)),
        demands_move(machine, name),
        parameters.torque_constant(machine.joint[name]),
        1.0 if averaged else 0.0,
    )


def plans(machine: Machine) -> bool:
    """Return whether the machine's control law, if it has one, plans its own motion."""
    return machine.controller is not None and machine.control_law.plans


def demand_pace(machine: Machine, name: str) -> float:
    """Speed with which a joint goes on to its demand at least, rad/s."""
    most = machine.safety.demand_speed
    if not plans(machine):
        return most
    own = float(demand_limits(machine).pace[list(machine.joints).index(name)])
    return min(own, most) if SPEED_IS_GIVEN in machine.safety.model_fields_set else own


def demands_move(machine: Machine, name: str) -> moving.Limits:
    """Return what demands of a joint may do; nothing counts of it where the control law does not plan its motion."""
    safety, working = machine.safety, 0.5 * machine.joint[name].stops.working_stroke
    if not plans(machine):
        return moving.Limits(working, safety.demand_speed, 0.0, 0.0, 0.0, machine.cycle, SURGE, JERK)
    found, j = demand_limits(machine), list(machine.joints).index(name)
    pace = safety.demand_speed if SPEED_IS_GIVEN in safety.model_fields_set else inf
    speed, acceleration, braking = (float(of[j]) for of in (found.speed, found.acceleration, found.braking))
    speed = min(speed, pace, safety.speed)
    return moving.Limits(working, pace, speed, acceleration, braking, machine.cycle, SURGE, JERK)


def least_ripple(machine: Machine) -> float:
    """Amplitude of a pressure that shows that there is air, Pa: of the law's description, or what noise never makes."""
    _, _, pressure = drive_parts(machine)
    noise = sensor_law(pressure)
    own = getattr(machine.controller, "air_ripple", None)
    return float(own) if own is not None else NEVER * hypot(noise.noise, noise.lsb / sqrt(12.0))


def speed_limit(machine: Machine, name: str) -> float:
    """Speed above which a joint runs away, rad/s.

    A law that plans its motion may use all that an open valve feeds, unless the machine's file says what it may. Where
    it is not told the payload, a joint may be far lighter than the law can know, and be flung.
    """
    safety = machine.safety
    if not plans(machine) or "speed" in safety.model_fields_set:
        return safety.speed
    lightest, heaviest = payloads(machine)
    fed = float(abilities(machine).speed[list(machine.joints).index(name)])
    return max(safety.speed, FLUNG * fed if lightest < heaviest else fed)


def residual_of_warmth(machine: Machine, name: str) -> float:
    """Residual per speed (s/rad) of air that is compressed so fast that it keeps all of its warmth.

    Derived: the air balance takes air for isothermal, and misses (gamma - 1) p K v of either hose; a residual of 1 is
    half of what an open valve feeds a hose, p_s C p_0, and w = C p_0 / K. So it is 2 (gamma - 1) p / p_s over w.
    """
    fastest = float(abilities(machine).speed[list(machine.joints).index(name)])
    return 2.0 * (GAMMA - 1.0) * FILLED / fastest


def held_back_for(machine: Machine, name: str) -> float:
    """Time for which a joint is slow in spite of its pressure that something holds back, s.

    Of a law that plans its motion such a pressure is meant to move the joint: in twice the time that it takes from one
    end of what is slow to the other, in the worst posture.
    """
    j = list(machine.joints).index(name)
    able, limits = abilities(machine), demand_limits(machine)
    opposes = float(able.friction[j] + able.loss[j])
    share = (following.STRAINS * float(able.torque[j]) - opposes) / (float(able.torque[j]) - opposes)
    takes = 2.0 * following.SLOW / (share * float(limits.braking[j])) if share > 0.0 else inf
    return max(min(2.0 * takes, following.LONG), SURE * machine.cycle)


def never_rests(sensor: Sensor, samples: float) -> bool:
    """Return whether the noise of a sound sensor never leaves it at one count for so many samples."""
    # Most likely it stays at a count whose middle it measures.
    return sensor.noise > 0.0 and erf(0.5 * sensor.lsb / (sqrt(2.0) * sensor.noise)) ** samples < SELDOM


def rests_from(machine: Machine, name: str) -> float:
    """Speed from which a joint may be at rest within a control cycle, with the least payload, rad/s."""
    resting = demand_limits(machine).resting[list(machine.joints).index(name)]
    return STOPS * float(resting) * machine.cycle


def joint_limits(machine: Machine, name: str) -> joint.Limits:
    """Limits of the detectors of a joint."""
    valve, angle_part, pressure_part = drive_parts(machine)
    j = list(machine.joints).index(name)
    part, safety, gauge, cycle = machine.joint[name], machine.safety, machine.supply.pressure_gauge, machine.cycle
    angle, pressure = sensor_law(angle_part), sensor_law(pressure_part)
    working, mechanical = part.stops.working_stroke / 2, part.stops.mechanical_stroke / 2
    friction, grain = 2.0 * parameters.held_pressure(part, gauge), max(angle.lsb, GRAIN * angle.noise)
    dither, sure = valve.dithered if machine.controller is not None else None, SURE * cycle
    patience = Fault.ANGLE_FROZEN.seconds - SPARE * cycle
    # Whether the ripple that is estimated, at a quarter of the loop's rate, is that of the dither.
    seen = dither is not None and abs(dither.frequency * cycle - 0.25) < 0.01
    return joint.Limits(
        rail.Limits(angle.low + RAIL * angle.lsb, angle.high - RAIL * angle.lsb),
        min(safety.overpressure * gauge, pressure.high - RAIL * pressure.lsb),
        speed_limit(machine, name) - NOISE * grain / cycle,
        outside.Limits(
            working + safety.overrun * (mechanical - working) - NOISE * grain,
            float(resting_angles(machine)[j]) + NOISE * grain,
            working,
            THROWN / cycle,
        ),
        doubt.Limits(
            grain,
            1.0 if seen or pressure.noise > LIVELY * pressure.lsb else 0.0,
            safety.air_residual if part.acting == "double" else inf,
            DOUBTFUL * cycle,
            residual_of_warmth(machine, name) if plans(machine) else 0.0,
            GAMMA - 1.0 if plans(machine) else 0.0,
            STILL if plans(machine) and part.acting == "double" else inf,
        ),
        angle_frozen.Limits(
            grain,
            friction,
            cycle,
            sure,
            patience,
            1.0 if never_rests(angle, patience / cycle) else 0.0,
            LANDS if plans(machine) else 0.0,
            AVERAGED * cycle if plans(machine) else 0.0,
            rests_from(machine, name) * cycle if plans(machine) else 0.0,
            0.5 * HIDES * friction if plans(machine) and part.acting == "double" else inf,
        ),
        valve_unresponsive.Limits(
            least_ripple(machine) if seen else 0.0,
            (PAUSES if plans(machine) else 1.0) * Fault.VALVE_UNRESPONSIVE.seconds - (SPARE + RIPPLE_AFTER) * cycle,
            valve_unresponsive.SHOWS * gauge,
            1.0 - (dither.amplitude if dither is not None else 0.0),
        ),
        pressure_frozen.Limits(Fault.PRESSURE_FROZEN.seconds - SPARE * cycle, sure),
        following.Limits(
            safety.following_error,
            safety.following_time,
            demand_pace(machine, name),
            Fault.FOLLOWING_ERROR.seconds - SPARE * cycle,
            following.STRAINS * gauge,
            held_back_for(machine, name) if plans(machine) else following.LONG,
        ),
    )
