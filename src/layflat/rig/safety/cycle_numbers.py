"""Numbers of a rig's control cycle: settings, inputs, memory and results of its compiled code.

They stay in arrays from call to call (see `rig/named.py`), as the numbers of the tuples below; all are real numbers,
and those of states, modes, faults and bits are whole.
"""

from typing import Any, NamedTuple

from layflat.lanes import leaves
from layflat.physics.air_balance import AirEstimate, AirObserverParameters
from layflat.rig.named import leaf_offsets, zero_tuple
from layflat.rig.safety import demands, detectors, estimator
from layflat.rig.safety.detectors import bounds
from layflat.rig.safety.faults import MODE_NO, STATE_NO

MIN_EVEN_TIME = 0.1  # without an uneven cycle, after which the air is judged, s


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
    vented: float  # voltage of valves that vent their hoses, V
    demand_step: float  # greatest distance of a demand ahead of its reference, rad
    demand_margin: float  # limit of the same as a fraction of the distance to the stops, 1
    plans: float  # 1 where the control law plans its own motion to its demands, which then have rates; else 0
    supply: bounds.SupplyLimits
    ready: float  # pressure of the supply that a soft start requires, absolute, Pa
    start_time: float  # within which the air has to come, s
    hold_time: float  # for which a controlled stop holds the joints, s
    vent_time: float  # allowed for venting the hoses, s
    stale_after: float  # age from which setpoints are stale, s


class JointSettings(NamedTuple):
    """Settings of a joint."""

    detectors: detectors.DetectorLimits
    air: AirObserverParameters
    gate: demands.DemandGate
    moving: demands.MovingDemandLimits
    torque_constant: float  # torque per pressure, m3/rad
    averaged: float  # 1 where signals are averaged over a period of the dither, else 0


class CycleInputs(NamedTuple):
    """Inputs of a cycle: reading of the machine as a whole, and request of the host."""

    answered: float  # 1 where a reading came, 0 where the reply was lost and the next four do not count
    supply: float  # pressure in the line behind the dump valve, absolute, Pa
    stopped: float  # 1 while the e-stop is pressed
    device: float  # state of the device's own watchdog: 0 running, 1 centred, 2 dumped
    elapsed: float  # since the last samples, s
    since: float  # since the last cycle, s
    start: float  # 1 in the cycle in which it is requested, as the next three: start softly and obey demands
    stop: float  # hold the joints, then vent the hoses
    hold: float  # hold the joints where they are, with air
    reset: float  # clear latched faults
    age: float  # time since the last message of the host, s
    demand_age: float  # time since the instant for which demands are, s
    switched: float  # digital outputs that are switched in this cycle, as bits
    on: float  # those of them that are on from now on, as bits
    missed: float  # 1 where a cycle was left out before this one
    unrecorded: float  # 1 where nothing is recorded, so that no start is allowed


class JointInputs(NamedTuple):
    """Inputs of a joint."""

    angle: float  # as sampled, rad
    pressure: float  # differential pressure as sampled, Pa
    requested: float  # demand of the host, rad; NaN where there is none yet
    velocity: float  # of that demand, rad/s; NaN: derived, as the next
    acceleration: float  # rad/s2


class RigMemory(NamedTuple):
    """Memory of the machine as a whole from cycle to cycle."""

    state: float  # number of the state (RigState)
    mode: float  # number of the mode of the valves (ValveMode)
    in_state: float  # time in that state, s
    in_mode: float  # time in that mode, s
    begun: float  # 1 once a reading has come
    wake: float  # 1 where controllers begin anew
    pressed: float  # 1 while the e-stop is pressed
    obeyed: float  # 1 once the device has obeyed since the last start
    air_time: float  # for which supply and ripple have been sufficient in a soft start, s
    reset_for: float  # cycles for which the pulse of the reset bit lasts
    lost: float  # replies lost in succession
    outputs: float  # digital outputs that are on, as bits
    worst_now: float  # worst fault of this cycle
    latched: float  # worst latched fault
    reaction: float  # worst reaction to latched faults
    present: float  # faults of this cycle that are not of a joint, as bits
    before: float  # those of the cycle before
    fault: float  # fault that the samples show; 0: none
    rejected: float  # 1 where the control law has given up its model of the machine in this cycle
    refused: float  # 1 where a voltage was out of range in this cycle
    even: float  # for how long cycles have been even, s
    lines: bounds.SupplyMemory


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
    others_light: float  # differential pressure that balances gravity and moving joints, smallest payload, Pa
    others_heavy: float  # the same with the greatest payload
    inertia: float  # differential pressure per acceleration, of the joint alone, Pa s2/rad
    neutral: float  # estimated shift of the valve's neutral voltage, V
    law_voltage: float  # voltage of the control law, V
    voltage: float  # voltage after its gate, V
    fault: float  # worst fault that the samples show; 0: none
    outcome: float  # 0, or DEMAND_LIMITED or DEMAND_REFUSED of demands.py, in this cycle
    worst_now: float  # worst fault of this cycle
    latched: float  # worst latched fault
    present: float  # faults of this cycle, as bits
    before: float  # those of the cycle before


class CycleResults(NamedTuple):
    """Results of a cycle: command to the device, and report."""

    air: float  # 1 where the dump valve is to connect the supply
    reset: float  # 1 where the reset bit of the command is set
    outputs: float  # digital outputs that are on, as bits
    state: float  # number of the state (RigState)
    mode: float  # number of the mode of the valves (ValveMode)
    vented: float  # 1 once the air is off and the time for venting the hoses has passed
    fault: float  # worst fault, latched or of this cycle; 0: none
    lost: float  # replies lost in succession
    events: float  # number of events


class JointResults(NamedTuple):
    """Results of a joint."""

    voltage: float  # to the valve's driver, V
    fault: float  # worst fault, latched or of this cycle; 0: none


class RigEvent(NamedTuple):
    """Event of a cycle."""

    number: float  # of the fault that came, or one of EVENT_...
    joint: float  # number of its joint from the base on; -1: the machine as a whole


class CycleRows(NamedTuple):
    """Arrays of a cycle's numbers: a row, or a row a joint where the class is that of a joint."""

    rig: Any  # RigSettings
    settings: Any  # JointSettings
    inputs: Any  # CycleInputs
    samples: Any  # JointInputs
    memory: Any  # RigMemory
    joints: Any  # JointMemory
    results: Any  # CycleResults
    commands: Any  # JointResults
    events: Any  # RigEvent, a row an event


class LawRows(NamedTuple):
    """Arrays of a control law's numbers."""

    arm: Any  # parameters of the arm
    settings: Any
    memory: Any
    report: Any  # a row a joint
    scratch: Any  # workspace, (2 joints + 4, joints + 1)


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
RIG_TEMPLATE, SETTINGS_TEMPLATE, INPUTS_TEMPLATE, JOINT_INPUTS_TEMPLATE = (
    zero_tuple(kind) for kind in (RigSettings, JointSettings, CycleInputs, JointInputs)
)
# Memory before the first cycle: no air, and controllers that begin with the first samples.
FIRST_MEMORY = zero_tuple(RigMemory)._replace(state=STATE_NO.OFF, mode=MODE_NO.CENTRE, wake=1.0, even=MIN_EVEN_TIME)
FIRST_JOINT_MEMORY = zero_tuple(JointMemory)._replace(detectors=detectors.INITIAL_MEMORY, stream=demands.DemandStream())
FIRST_RESULTS, FIRST_COMMAND, NO_EVENT = map(zero_tuple, (CycleResults, JointResults, RigEvent))
LIMIT_AT, SETTING_AT, INPUT_AT, SAMPLE_AT = map(
    leaf_offsets, (RIG_TEMPLATE, SETTINGS_TEMPLATE, INPUTS_TEMPLATE, JOINT_INPUTS_TEMPLATE)
)
RIG_AT, JOINT_AT, RESULT_AT, COMMAND_AT, EVENT_AT = map(
    leaf_offsets, (FIRST_MEMORY, FIRST_JOINT_MEMORY, FIRST_RESULTS, FIRST_COMMAND, NO_EVENT)
)
"""Offset of each item in its row."""


def max_events(joints: int) -> int:
    """Return the greatest number of events in a cycle: a fault comes once, and a joint has one of each of its steps."""
    return 20 + 3 * joints
