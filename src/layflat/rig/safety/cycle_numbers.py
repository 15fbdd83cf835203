"""Numbers of a rig's control cycle: what is handed to its compiled code and remembered from call to call.

They stay in arrays (see `rig/named.py`); which tuples they are, the compiler knows.
"""

from typing import NamedTuple

from layflat.lanes import leaves
from layflat.physics.air_balance import AirEstimate, AirParts
from layflat.rig.named import blank, places
from layflat.rig.safety import demands, estimator, moving
from layflat.rig.safety.detectors import joint, supply

JUDGE, DEMAND, ESTIMATE, CONTROL, GATE = 1, 2, 4, 8, 16  # stages of a cycle
# What came of it: a fault was found, and nothing was done after it; a demand was changed; a voltage was bad; the law
# goes by what it believes of the machine no more.
FOUND, CHANGED, BAD, DOUBTED = 1, 2, 4, 8


class Rig(NamedTuple):
    """Settings of the machine as a whole."""

    cycle: float  # s
    centre: float  # voltage at which valves are closed, V
    per_volt: float  # opening of a valve, 1/V
    ambient: float  # pa
    lightest: float  # payload that there may be at least, kg
    heaviest: float  # and at most
    voltage_low: float
    voltage_high: float
    demand_lead: float  # by which demands may be ahead of their references, rad
    demand_margin: float  # of what is left to the stops, 1
    plans: float  # 1 where the control law plans its own motion to its demands, which then have rates; else 0
    supply: supply.Limits


class Settings(NamedTuple):
    """Settings of a joint."""

    detectors: joint.Limits
    air: AirParts
    gate: demands.Gate
    moving: moving.Limits
    torque_constant: float  # torque per pressure, m3/rad
    averaged: float  # 1 where signals are averaged over a dither period, else 0


class Memory(NamedTuple):
    """Memory of a joint from cycle to cycle."""

    detectors: joint.Memory
    air: AirEstimate
    estimator: estimator.Memory
    estimate: estimator.Estimate
    demand: demands.Demand
    velocity: float  # of the demand, rad/s
    acceleration: float  # of the demand, rad/s2
    stream: moving.Stream
    neutral: float  # estimated shift of the valve's neutral voltage, V
    asked: float  # voltage that the control law asked for, V
    voltage: float  # voltage that was let through, V
    fault: float  # number of the worst fault of this cycle; 0: none
    outcome: float  # what became of the demand in this cycle


class Inputs(NamedTuple):
    """Inputs of a cycle, and memory of the machine as a whole."""

    supply: float  # absolute, Pa
    elapsed: float  # since the last samples, s
    since: float  # since the last cycle, s
    level: float  # what there is to watch
    follow: float  # 1 where demands are obeyed
    wake: float  # 1 where controllers begin anew
    meant: float  # since the instant for which demands are meant, s
    even: float  # for how long cycles have been even, s
    lines: supply.Memory
    fault: float  # number of the machine's fault of this cycle; 0: none


class JointInputs(NamedTuple):
    """Inputs of a joint."""

    angle: float
    pressure: float
    asked: float
    velocity: float  # of what is asked for; not a number: it is derived, as the next
    acceleration: float
    others_light: float  # differential pressure that gravity and joints that turn would ask of it at rest, Pa
    others_heavy: float  # the same with the greatest payload, not the least
    inertia: float  # differential pressure per acceleration, of the joint alone, Pa s2/rad


class Known(NamedTuple):
    """Signals of a joint in a row under any control law; names are those of `rig.record.RIG_SIGNALS`."""

    demand: float
    demand_velocity: float
    voltage: float
    measured_angle: float
    measured_pressure: float
    estimate: estimator.Estimate
    estimated_air: float


JOINT_INPUTS, KNOWN = len(JointInputs._fields), len(list(leaves(blank(Known))))
RIG, SETTINGS, MEMORY, INPUTS, JOINT = (blank(kind) for kind in (Rig, Settings, Memory, Inputs, JointInputs))
IN_MEMORY, IN_INPUTS, IN_GIVEN = places(MEMORY), places(INPUTS), places(JOINT)
