"""What a rig is watched by, as plain numbers, from the description of a machine with valve and sensors.

Raises MachineError where it has none.
"""

from math import inf

from layflat.machine import Machine, parameters
from layflat.machine.parameters import drive_parts
from layflat.machine.parameters import sensor as sensor_law
from layflat.rig.safety.cycle import Rig, Settings
from layflat.rig.safety.demands import Gate
from layflat.rig.safety.detectors import (
    angle_frozen,
    doubt,
    following,
    joint,
    pressure_frozen,
    rail,
    supply,
    valve_unresponsive,
)  # fmt: skip
from layflat.rig.safety.faults import Fault

LIVELY = 0.3  # noise of a sensor, in counts, from which on it never reports the same count for 20 samples
RAIL = 2.0  # counts from the end of a converter's range, at which a sensor is taken to be open or shorted
NOISE = 2.0  # counts by which a sample may be wrong: a joint at a limit is found in spite of them
# Cycles less than the table of faults gives to find one, and that the ripple takes to show that there is none.
SPARE, RIPPLE_AFTER = 2.0, 4.0
# Cycles of the same sample after which a sensor may be frozen, and after which it is, where it does not fit.
DOUBTFUL, SURE = 2.5, 7.5


def rig_settings(machine: Machine) -> Rig:
    """What holds of the machine as a whole."""
    valve, _, _ = drive_parts(machine)
    safety, source, span, cycle = machine.safety, machine.supply, valve.volts_to_full, machine.cycle
    lost = Fault.SUPPLY_LOST.seconds - RIPPLE_AFTER * cycle
    return Rig(
        cycle,
        valve.centre_voltage,
        1.0 / span,
        source.ambient_pressure,
        machine.arm.payload,
        valve.centre_voltage - span,
        valve.centre_voltage + span,
        safety.demand_lead,
        safety.demand_margin,
        supply.Limits(
            low=source.ambient_pressure + safety.supply_low * source.pressure_gauge,
            high=source.ambient_pressure + safety.overpressure * source.pressure_gauge,
            patience=max(lost - SPARE * cycle, cycle),
        ),
    )


def joint_settings(machine: Machine, name: str) -> Settings:
    """What holds of a joint."""
    stops, safety = machine.joint[name].stops, machine.safety
    averaged = getattr(machine.controller, "averaged", True)
    return Settings(
        joint_limits(machine, name),
        parameters.air_parts(machine, name),
        Gate(0.5 * stops.working_stroke, 0.5 * stops.mechanical_stroke, safety.demand_speed),
        parameters.torque_constant(machine.joint[name]),
        1.0 if averaged else 0.0,
    )


def joint_limits(machine: Machine, name: str) -> joint.Limits:
    """Limits of the detectors of a joint."""
    valve, angle_part, pressure_part = drive_parts(machine)
    part, safety, gauge, cycle = machine.joint[name], machine.safety, machine.supply.pressure_gauge, machine.cycle
    angle, pressure = sensor_law(angle_part), sensor_law(pressure_part)
    working, mechanical = part.stops.working_stroke / 2, part.stops.mechanical_stroke / 2
    friction = 2.0 * parameters.held_pressure(part, gauge)
    dither, sure = valve.dithered if machine.controller is not None else None, SURE * cycle
    # Whether the ripple that is estimated, at a quarter of the loop's rate, is that of the dither.
    seen = dither is not None and abs(dither.frequency * cycle - 0.25) < 0.01
    return joint.Limits(
        rail.Limits(angle.low + RAIL * angle.lsb, angle.high - RAIL * angle.lsb),
        min(safety.overpressure * gauge, pressure.high - RAIL * pressure.lsb),
        safety.speed - NOISE * angle.lsb / cycle,
        working + safety.overrun * (mechanical - working) - NOISE * angle.lsb,
        doubt.Limits(
            angle.lsb,
            1.0 if seen or pressure.noise > LIVELY * pressure.lsb else 0.0,
            safety.air_residual if part.acting == "double" else inf,
            DOUBTFUL * cycle,
        ),
        angle_frozen.Limits(angle.lsb, friction, cycle, sure, Fault.ANGLE_FROZEN.seconds - SPARE * cycle),
        valve_unresponsive.Limits(
            getattr(machine.controller, "air_ripple", 0.0) if seen else 0.0,
            Fault.VALVE_UNRESPONSIVE.seconds - (SPARE + RIPPLE_AFTER) * cycle,
            valve_unresponsive.SHOWS * gauge,
            1.0 - (dither.amplitude if dither is not None else 0.0),
        ),
        pressure_frozen.Limits(Fault.PRESSURE_FROZEN.seconds - SPARE * cycle, sure),
        following.Limits(
            safety.following_error,
            safety.following_time,
            safety.demand_speed,
            Fault.FOLLOWING_ERROR.seconds - SPARE * cycle,
            following.STRAINS * gauge,
        ),
    )
