"""Steps of a cycle's decisions, as compiled code: faults that are noted, and states that are entered, in their order.

Each step may update the memory, then note a fault, then change the state. Those from E_STOP_STEP on come before the
control law, those from MODEL_STEP on behind it. Functions take `CycleRows`.
"""

# mypy: disable-error-code="no-untyped-def"

from layflat.jit import composition
from layflat.lanes import read_numbers
from layflat.rig.driver import DeviceState
from layflat.rig.safety.cycle import is_voltage_good
from layflat.rig.safety.cycle_numbers import IN, JOINT, LIMIT, RIG
from layflat.rig.safety.demands import DEMAND_REFUSED
from layflat.rig.safety.faults import FAULT, MODE, STATE, Fault
from layflat.rig.safety.holding import has_air, reset_detectors
from layflat.rig.safety.ledger import note_fault
from layflat.rig.safety.soft_start import has_air_come, update_air_time
from layflat.rig.safety.state_machine import (
    PRESENT_ANGLES,
    PRESENT_DEMANDS,
    Decision,
    carry_out,
    continue_stop,
    hold,
    move,
    react,
    reset,
    start,
    stay,
    stop,
)

(
    E_STOP_STEP, DEVICE_STEP, SAMPLES_STEP, JOINT_SAMPLES_STEP, AIR_STEP, REPLY_STEP, LINK_STEP, MISSED_STEP,
    RECORDER_STEP, TIME_STEP, STALE_STEP, RESET_STEP, REQUEST_STEP, REACTION_STEP, STOP_STEP, MOTION_STEP,
    MODEL_STEP, DEMAND_STEP, VOLTAGE_STEP, REFUSAL_STEP, LAST_STEP,
) = range(21)  # fmt: skip
RUNNING, DUMPED = float(DeviceState.RUNNING), float(DeviceState.DUMPED)
MAX_LOST_REPLIES = Fault.LINK_LOST.cycles
STATE_AND_MODE = (0.0, 0.0)  # structure of the first two numbers of the memory


@composition
def take_steps(rows, first, behind):
    """Take the steps from `first` on, up to that before `behind`."""
    for step in range(first, behind):
        update_memory(rows, step)
        by_joint = step in (JOINT_SAMPLES_STEP, DEMAND_STEP, VOLTAGE_STEP)
        for j in range(len(rows.joints) if by_joint else 1):
            fault = find_joint_fault(rows, step, j) if by_joint else find_fault(rows, step)
            if fault > 0.0:
                note_fault(rows, fault, j if by_joint else -1)
        state, mode = read_numbers(STATE_AND_MODE, rows.memory)
        carry_out(rows, decide(rows, step, state, mode))


@composition
def update_memory(rows, step):
    """Update what a step decides by."""
    memory, inputs = rows.memory, rows.inputs
    answered = inputs[IN.answered] > 0.0
    if step == DEVICE_STEP and answered and inputs[IN.device] == RUNNING and has_air(memory[RIG.mode]):
        memory[RIG.obeyed] = 1.0
    elif step == AIR_STEP and answered and memory[RIG.state] == STATE.STARTING:
        update_air_time(rows)
    elif step == TIME_STEP:
        memory[RIG.in_state] += inputs[IN.since]
        memory[RIG.in_mode] += inputs[IN.since]
        memory[RIG.reset_for] = max(memory[RIG.reset_for] - 1.0, 0.0)
    elif step == REFUSAL_STEP and memory[RIG.refused] > 0.0:
        memory[RIG.wake] = 1.0


@composition
def are_setpoints_stale(rows):
    """Return whether setpoints are too old for a rig with air."""
    return rows.inputs[IN.age] > rows.rig[LIMIT.stale_after] and has_air(rows.memory[RIG.mode])


@composition
def find_fault(rows, step):
    """Return the number of the machine's fault that a step notes, or 0."""
    memory, inputs, fault = rows.memory, rows.inputs, 0.0
    answered, on = inputs[IN.answered] > 0.0, has_air(memory[RIG.mode])
    if step == E_STOP_STEP and answered and inputs[IN.stopped] > 0.0:
        fault = FAULT.E_STOP
    elif step == DEVICE_STEP and answered and inputs[IN.device] != RUNNING and on and memory[RIG.obeyed] > 0.0:
        fault = FAULT.DEVICE_DUMPED if inputs[IN.device] == DUMPED else FAULT.DEVICE_CENTRED
    elif step == SAMPLES_STEP and answered:
        fault = memory[RIG.fault]
    elif step == AIR_STEP and answered and memory[RIG.state] == STATE.STARTING and not has_air_come(rows):
        fault = FAULT.NO_AIR if memory[RIG.in_state] > rows.rig[LIMIT.start_time] else 0.0
    elif step == REPLY_STEP and not answered:
        fault = FAULT.REPLY_LOST
    elif step == LINK_STEP and memory[RIG.lost] >= MAX_LOST_REPLIES:
        fault = FAULT.LINK_LOST
    elif step == MISSED_STEP and inputs[IN.missed] > 0.0:
        fault = FAULT.CYCLE_MISSED
    elif step == RECORDER_STEP and inputs[IN.unrecorded] > 0.0:
        fault = FAULT.RECORDER_DEAD
    elif step == STALE_STEP and are_setpoints_stale(rows):
        fault = FAULT.SETPOINT_STALE
    elif step == MODEL_STEP and memory[RIG.rejected] > 0.0:
        fault = FAULT.MODEL_DOUBTED
    return fault


@composition
def find_joint_fault(rows, step, j):
    """Return the number of a joint's fault that a step notes, or 0."""
    joint, fault = rows.joints[j], 0.0
    if step == JOINT_SAMPLES_STEP and rows.inputs[IN.answered] > 0.0:
        fault = joint[JOINT.fault]
    elif step == DEMAND_STEP and joint[JOINT.outcome] > 0.0:
        fault = FAULT.DEMAND_REFUSED if joint[JOINT.outcome] == DEMAND_REFUSED else FAULT.DEMAND_LIMITED
    elif step == VOLTAGE_STEP and rows.memory[RIG.refused] > 0.0 and not is_voltage_good(rows, j):
        fault = FAULT.BAD_COMMAND
    return fault


@composition
def decide(rows, step, state, mode):
    """Return the decision of a step.

    Stale setpoints under air begin a controlled stop; of requests, a stop comes before a hold, and this before a start.
    """
    memory, inputs, decision = rows.memory, rows.inputs, stay(state, mode)
    stops = step == REQUEST_STEP and inputs[IN.stop] > 0.0
    if step == AIR_STEP and inputs[IN.answered] > 0.0 and state == STATE.STARTING and has_air_come(rows):
        reset_detectors(rows)
        decision = Decision(STATE.READY, MODE.HOLD, 0.0, 0.0)
    elif (stops and has_air(mode)) or (step == STALE_STEP and are_setpoints_stale(rows)):
        decision = stop(rows, state, mode)
    elif step == RESET_STEP and inputs[IN.reset] > 0.0:
        decision = reset(rows, state, mode)
    elif step == REQUEST_STEP and not stops and inputs[IN.hold] > 0.0:
        decision = hold(state, mode)
    elif step == REQUEST_STEP and not stops and inputs[IN.start] > 0.0:
        decision = start(rows, state, mode)
    elif step == REACTION_STEP and memory[RIG.latched] > 0.0:
        decision = react(rows, state, mode, PRESENT_ANGLES)
    elif step == STOP_STEP:
        decision = continue_stop(rows, state, mode)
    elif step == MOTION_STEP:
        decision = move(rows, state, mode)
    elif step == REFUSAL_STEP and memory[RIG.refused] > 0.0:
        decision = react(rows, state, mode, PRESENT_DEMANDS)
    return decision
