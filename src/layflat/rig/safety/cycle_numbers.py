"""Numbers of a rig's control cycle: settings, inputs and memory of its compiled code.

They stay in arrays from call to call (see `rig/named.py`), as the numbers of the tuples below.
"""

from typing import NamedTuple

from layflat.lanes import leaves
from layflat.physics.air_balance import AirEstimate, AirObserverParameters
from layflat.rig.named import leaf_offsets, zero_tuple
from layflat.rig.safety import demands, detectors, estimator
from layflat.rig.safety.detectors import bounds

JUDGE_STAGE, DEMAND_STAGE, ESTIMATE_STAGE, CONTROL_STAGE, GATE_STAGE = 1, 2, 4, 8, 16  # stages of a cycle
# Outcomes of a cycle: a fault was detected, and no later stage performed; a demand was limited or refused; a voltage
# was out of range; the law has given up its model of the machine.
FAULT_DETECTED, DEMAND_CHANGED, VOLTAGE_REFUSED, MODEL_REJECTED = 1, 2, 4, 8


class RigSettings(NamedTuple):
    """Settings of the machine as a whole."""

    cycle: float  # s
    centre: float  # voltage at which valves are closed, V
    per_volt: float  # opening of a valve, 1/V
    ambient: float  # absolute pressure, Pa
    lightest: float  # smallest payload, kg
    heaviest: float  # greatest payload, kg
    voltage_low: float  # V, as the next
    voltage_high: float
    demand_step: float  # greatest distance of a demand ahead of its reference, rad
    demand_margin: float  # limit of the same as a fraction of the distance to the stops, 1
    plans: float  # 1 where the control law plans its own motion to its demands, which then have rates; else 0
    supply: bounds.SupplyLimits


class JointSettings(NamedTuple):
    """Settings of a joint."""

    detectors: detectors.DetectorLimits
    air: AirObserverParameters
    gate: demands.DemandGate
    moving: demands.MovingDemandLimits
    torque_constant: float  # torque per pressure, m3/rad
    averaged: float  # 1 where signals are averaged over a period of the dither, else 0


class JointMemory(NamedTuple):
    """Memory of a joint from cycle to cycle."""

    detectors: detectors.DetectorMemory
    air: AirEstimate
    estimator: estimator.EstimatorMemory
    estimate: estimator.JointEstimate
    demand: demands.GatedDemand
    velocity: float  # of the demand, rad/s
    acceleration: float  # of the demand, rad/s2
    stream: demands.DemandStream
    neutral: float  # estimated shift of the valve's neutral voltage, V
    law_voltage: float  # voltage of the control law, V
    voltage: float  # voltage after its gate, V
    fault: float  # number of the worst fault of this cycle; 0: none
    outcome: float  # 0, or DEMAND_LIMITED or DEMAND_REFUSED of demands.py, in this cycle


class CycleInputs(NamedTuple):
    """Inputs of a cycle, and memory of the machine as a whole."""

    supply: float  # absolute, Pa
    elapsed: float  # since the last samples, s
    since: float  # since the last cycle, s
    level: float  # level of detection (see detectors/sample.py)
    follow: float  # 1 where demands are obeyed
    wake: float  # 1 where controllers begin anew
    demand_age: float  # time since the instant for which demands are, s
    even: float  # for how long cycles have been even, s
    lines: bounds.SupplyMemory
    fault: float  # number of the machine's fault of this cycle; 0: none


class JointInputs(NamedTuple):
    """Inputs of a joint."""

    angle: float  # as sampled, rad
    pressure: float  # differential pressure as sampled, Pa
    requested: float  # demand of the host, rad
    velocity: float  # of that demand, rad/s; NaN: derived, as the next
    acceleration: float  # rad/s2
    others_light: float  # differential pressure that balances gravity and moving joints, smallest payload, Pa
    others_heavy: float  # the same with the greatest payload
    inertia: float  # differential pressure per acceleration, of the joint alone, Pa s2/rad


class RecordedSignals(NamedTuple):
    """Signals of a joint in a row under any control law; names are those of `rig.record.RIG_SIGNALS`."""

    demand: float
    demand_velocity: float
    voltage: float
    measured_angle: float
    measured_pressure: float
    estimate: estimator.JointEstimate
    estimated_air: float


JOINT_INPUT_COUNT, RECORDED_WIDTH = len(JointInputs._fields), len(list(leaves(zero_tuple(RecordedSignals))))
RIG_TEMPLATE, SETTINGS_TEMPLATE, MEMORY_TEMPLATE, INPUTS_TEMPLATE, JOINT_TEMPLATE = (
    zero_tuple(kind) for kind in (RigSettings, JointSettings, JointMemory, CycleInputs, JointInputs)
)
MEMORY_OFFSETS, INPUT_OFFSETS, JOINT_INPUT_OFFSETS = (
    leaf_offsets(MEMORY_TEMPLATE),
    leaf_offsets(INPUTS_TEMPLATE),
    leaf_offsets(JOINT_TEMPLATE),
)
