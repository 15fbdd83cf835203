"""Limits of a rig's detectors and gates as plain numbers, from the description of a machine with valve and sensors.

All functions raise MachineError where the machine has none.
"""

from math import erf, hypot, inf, sqrt

from layflat.machine import Machine, parameters
from layflat.machine.parameters import sensor as sensor_law
from layflat.machine.parameters import valve_and_sensors
from layflat.motion.limits import joint_capabilities
from layflat.motion.trajectory import JUMP_ACCELERATION, JUMP_JERK
from layflat.physics.air import GAMMA
from layflat.physics.joint import REST_PRESSURE_RATIO
from layflat.physics.sensor import Sensor
from layflat.rig.abilities import demand_limits, falls_without_air, payload_range, resting_angles, vent_time
from layflat.rig.safety import demands, detectors
from layflat.rig.safety.cycle_numbers import JointSettings, RigSettings
from layflat.rig.safety.demands import DemandGate
from layflat.rig.safety.detectors import air, angle_frozen, bounds, following
from layflat.rig.safety.faults import Fault

CHANGING_NOISE = 0.3  # noise of a sensor in counts, above which it never repeats one count for 20 samples
RAIL_COUNTS = 2.0  # counts from the end of a converter's range, within which a sensor is open or shorted
GRAIN_NOISE_RATIO = 3.5  # standard deviations of noise that act as one count, where a count is less
MAX_FALSE_ALARM_CHANCE = 1e-12  # of samples that are all the same; at 200 a second, once in a million hours
SAMPLE_ERROR_COUNTS = 2.0  # error of a sample in counts, which limits allow for
# Margin before the detection time in the table of faults, and delay of the ripple's estimate, cycles.
SPARE_CYCLES, RIPPLE_DELAY_CYCLES = 2.0, 4.0
NOISE_RIPPLE_ERRORS = 4.5  # ripple that noise never reaches, in standard deviations of the pressure
RIPPLE_LOSS_FRACTION = 0.65  # of its detection time, after which a ripple is lost under laws that plan: they pause it
# Residual of air around a joint at rest, as an opening of its valve, besides that of filling: 0.054 without a fault.
MAX_STATIONARY_RESIDUAL = 0.1
STATIC_FRICTION_RATIO = 1.5  # greatest static friction over that in motion
LANDING_ERROR = 0.05  # error within which a law that plans its motion stops a joint as soon as it can, rad
AVERAGING_CYCLES = 3.5  # cycles after which a mean of four samples contains none of before
BRAKING_RATIO = 2.0  # greatest deceleration over that by friction alone: the other joints and the air help
FLUNG_SPEED_RATIO = 2.0  # greatest speed of a joint with less payload than the law expects over that its valve feeds
THROW_TIME = 0.05  # longer than a joint's stop takes to throw it back, s
DEMAND_SPEED_KEY = "demand_speed"  # key in a machine's file; set there, it limits laws that plan their motion, too
# Cycles of the same sample after which a sensor is suspect, and after which, if it contradicts the air, it is frozen.
SUSPECT_CYCLES, CERTAIN_CYCLES = 2.5, 7.5


def rig_settings(machine: Machine) -> RigSettings:
    """Return the settings of the compiled cycle for the machine as a whole: voltages, payloads, limits, times."""
    valve, _, _ = valve_and_sensors(machine)
    safety, source, span, cycle = machine.safety, machine.supply, valve.volts_to_full, machine.cycle
    lost = Fault.SUPPLY_LOST.seconds - RIPPLE_DELAY_CYCLES * cycle
    return RigSettings(
        cycle,
        valve.centre_voltage,
        1.0 / span,
        source.ambient_pressure,
        *payload_range(machine),
        valve.centre_voltage - span,
        valve.centre_voltage + span,
        valve.centre_voltage + (0.0 if falls_without_air(machine) else span),
        safety.demand_step,
        safety.demand_margin,
        1.0 if plans_motion(machine) else 0.0,
        bounds.SupplyLimits(
            low=source.ambient_pressure + safety.supply_low * source.pressure_gauge,
            high=source.ambient_pressure + safety.overpressure * source.pressure_gauge,
            patience=max(lost - SPARE_CYCLES * cycle, cycle),
        ),
        source.ambient_pressure + safety.supply_ready * source.pressure_gauge,
        safety.start_time,
        safety.hold_time,
        vent_time(machine),
        safety.setpoint_age - cycle,
    )


def joint_settings(machine: Machine, name: str) -> JointSettings:
    """Return the settings of the compiled cycle for one joint: detectors, air observer and limits of demands."""
    stops = machine.joint[name].stops
    averaged = getattr(machine.controller, "averaged", True)
    return JointSettings(
        detector_limits(machine, name),
        parameters.air_observer_parameters(machine, name),
        DemandGate(0.5 * stops.working_stroke, 0.5 * stops.mechanical_stroke, demand_pace(machine, name)),
        moving_demand_limits(machine, name),
        parameters.torque_constant(machine.joint[name]),
        1.0 if averaged else 0.0,
    )


def plans_motion(machine: Machine) -> bool:
    """Return whether the machine's control law, if it has one, plans its own motion."""
    return machine.controller is not None and machine.control_law.plans


def demand_pace(machine: Machine, name: str) -> float:
    """Return the speed of a joint's reference towards its demand, rad/s: `safety.demand_speed`.

    Under a law that plans its motion it is `DemandLimits.pace`, or `demand_speed` where the machine's file sets less.
    """
    limit = machine.safety.demand_speed
    if not plans_motion(machine):
        return limit
    pace = float(demand_limits(machine).pace[list(machine.joints).index(name)])
    return min(pace, limit) if DEMAND_SPEED_KEY in machine.safety.model_fields_set else pace


def moving_demand_limits(machine: Machine, name: str) -> demands.MovingDemandLimits:
    """Return the limits of a joint's moving demands; they are unused where the control law does not plan its motion."""
    safety, working = machine.safety, 0.5 * machine.joint[name].stops.working_stroke
    if not plans_motion(machine):
        return demands.MovingDemandLimits(
            working, safety.demand_speed, 0.0, 0.0, 0.0, machine.cycle, JUMP_ACCELERATION, JUMP_JERK
        )
    limits, j = demand_limits(machine), list(machine.joints).index(name)
    pace = safety.demand_speed if DEMAND_SPEED_KEY in safety.model_fields_set else inf
    speed, acceleration, braking = (float(row[j]) for row in (limits.speed, limits.acceleration, limits.braking))
    speed = min(speed, pace, safety.speed)
    return demands.MovingDemandLimits(
        working, pace, speed, acceleration, braking, machine.cycle, JUMP_ACCELERATION, JUMP_JERK
    )


def min_air_ripple(machine: Machine) -> float:
    """Return the ripple of the pressure above which there is air, Pa: the law's setting, or more than noise makes."""
    _, _, pressure = valve_and_sensors(machine)
    noise = sensor_law(pressure)
    setting = getattr(machine.controller, "air_ripple", None)
    return float(setting) if setting is not None else NOISE_RIPPLE_ERRORS * hypot(noise.noise, noise.lsb / sqrt(12.0))


def speed_limit(machine: Machine, name: str) -> float:
    """Return the speed above which a joint is at fault, rad/s.

    Under a law that plans its motion it is the speed that an open valve feeds, unless the machine's file sets a limit;
    twice that where the payload is unknown: a joint that is lighter than the law assumes is flung.
    """
    safety = machine.safety
    if not plans_motion(machine) or "speed" in safety.model_fields_set:
        return safety.speed
    lightest, heaviest = payload_range(machine)
    fed = float(joint_capabilities(machine).speed[list(machine.joints).index(name)])
    return max(safety.speed, FLUNG_SPEED_RATIO * fed if lightest < heaviest else fed)


def adiabatic_residual(machine: Machine, name: str) -> float:
    """Return the residual per speed of the joint (s/rad) of air that is compressed adiabatically.

    Derived: the air balance assumes isothermal air, and misses (gamma - 1) p K v of either hose; a residual of 1 is
    half of what an open valve feeds a hose, p_s C p_0, and w = C p_0 / K. So it is 2 (gamma - 1) p / p_s over w.
    """
    fastest = float(joint_capabilities(machine).speed[list(machine.joints).index(name)])
    return 2.0 * (GAMMA - 1.0) * REST_PRESSURE_RATIO / fastest


def max_held_back_time(machine: Machine, name: str) -> float:
    """Return the time for which a free joint may be slow in spite of its pressure, s; afterwards it is held back.

    Under a law that plans its motion such a pressure has to move the joint: the time is twice that which it takes from
    `-HELD_BACK_SPEED` to `HELD_BACK_SPEED` in the worst configuration, within `CERTAIN_CYCLES` and `HELD_BACK_TIME`.
    """
    j = list(machine.joints).index(name)
    able, limits = joint_capabilities(machine), demand_limits(machine)
    opposes = float(able.friction[j] + able.loss[j])
    fraction = (following.HELD_BACK_PRESSURE * float(able.torque[j]) - opposes) / (float(able.torque[j]) - opposes)
    duration = 2.0 * following.HELD_BACK_SPEED / (fraction * float(limits.braking[j])) if fraction > 0.0 else inf
    return max(min(2.0 * duration, following.HELD_BACK_TIME), CERTAIN_CYCLES * machine.cycle)


def noise_never_rests(sensor: Sensor, samples: float) -> bool:
    """Return whether noise keeps a valid sensor at one count for `samples` with less than `MAX_FALSE_ALARM_CHANCE`."""
    # The probability of staying is highest at a count whose middle is measured.
    return sensor.noise > 0.0 and erf(0.5 * sensor.lsb / (sqrt(2.0) * sensor.noise)) ** samples < MAX_FALSE_ALARM_CHANCE


def resting_speed(machine: Machine, name: str) -> float:
    """Return the speed from which a joint may come to rest within a control cycle, smallest payload, rad/s."""
    resting = demand_limits(machine).resting[list(machine.joints).index(name)]
    return BRAKING_RATIO * float(resting) * machine.cycle


def detector_limits(machine: Machine, name: str) -> detectors.DetectorLimits:
    """Return the limits of all detectors of a joint, from its stops, sensors, valve and `safety`."""
    valve, angle_part, pressure_part = valve_and_sensors(machine)
    j = list(machine.joints).index(name)
    part, safety, gauge, cycle = machine.joint[name], machine.safety, machine.supply.pressure_gauge, machine.cycle
    angle, pressure = sensor_law(angle_part), sensor_law(pressure_part)
    working, mechanical = part.stops.working_stroke / 2, part.stops.mechanical_stroke / 2
    friction, grain = 2.0 * parameters.held_pressure(part, gauge), max(angle.lsb, GRAIN_NOISE_RATIO * angle.noise)
    dither, sure = valve.dithered if machine.controller is not None else None, CERTAIN_CYCLES * cycle
    patience = Fault.ANGLE_FROZEN.seconds - SPARE_CYCLES * cycle
    # Whether the ripple that is estimated, at a quarter of the loop's rate, is that of the dither.
    seen = dither is not None and abs(dither.frequency * cycle - 0.25) < 0.01
    return detectors.DetectorLimits(
        bounds.RailLimits(angle.low + RAIL_COUNTS * angle.lsb, angle.high - RAIL_COUNTS * angle.lsb),
        min(safety.overpressure * gauge, pressure.high - RAIL_COUNTS * pressure.lsb),
        speed_limit(machine, name) - SAMPLE_ERROR_COUNTS * grain / cycle,
        bounds.StrokeLimits(
            working + safety.overrun * (mechanical - working) - SAMPLE_ERROR_COUNTS * grain,
            float(resting_angles(machine)[j]) + SAMPLE_ERROR_COUNTS * grain,
            working,
            THROW_TIME / cycle,
        ),
        air.SuspicionLimits(
            grain,
            1.0 if seen or pressure.noise > CHANGING_NOISE * pressure.lsb else 0.0,
            safety.air_residual if part.acting == "double" else inf,
            SUSPECT_CYCLES * cycle,
            adiabatic_residual(machine, name) if plans_motion(machine) else 0.0,
            GAMMA - 1.0 if plans_motion(machine) else 0.0,
            MAX_STATIONARY_RESIDUAL if plans_motion(machine) and part.acting == "double" else inf,
        ),
        angle_frozen.FrozenAngleLimits(
            grain,
            friction,
            cycle,
            sure,
            patience,
            1.0 if noise_never_rests(angle, patience / cycle) else 0.0,
            LANDING_ERROR if plans_motion(machine) else 0.0,
            AVERAGING_CYCLES * cycle if plans_motion(machine) else 0.0,
            resting_speed(machine, name) * cycle if plans_motion(machine) else 0.0,
            0.5 * STATIC_FRICTION_RATIO * friction if plans_motion(machine) and part.acting == "double" else inf,
        ),
        air.ValveResponseLimits(
            min_air_ripple(machine) if seen else 0.0,
            (RIPPLE_LOSS_FRACTION if plans_motion(machine) else 1.0) * Fault.VALVE_UNRESPONSIVE.seconds
            - (SPARE_CYCLES + RIPPLE_DELAY_CYCLES) * cycle,
            air.DITHER_PRESSURE_FRACTION * gauge,
            1.0 - (dither.amplitude if dither is not None else 0.0),
        ),
        air.FrozenPressureLimits(Fault.PRESSURE_FROZEN.seconds - SPARE_CYCLES * cycle, sure),
        following.FollowingLimits(
            safety.following_error,
            safety.following_time,
            demand_pace(machine, name),
            Fault.FOLLOWING_ERROR.seconds - SPARE_CYCLES * cycle,
            following.HELD_BACK_PRESSURE * gauge,
            max_held_back_time(machine, name) if plans_motion(machine) else following.HELD_BACK_TIME,
        ),
    )
