"""Steps of a cycle's decisions, as compiled code: faults that are noted, and states that are entered, in their order.

Each step may update the memory, then note a fault, then change the state. Those from E_STOP_STEP on come before the
control law, those from MODEL_STEP on behind it. Functions take `CycleRows`.
"""

# mypy: disable-error-code="no-untyped-def"

from layflat.jit import composition
from layflat.lanes import read_numbers
from layflat.rig.device_state import DeviceState
from layflat.rig.safety.cycle import is_voltage_good
from layflat.rig.safety.cycle_numbers import INPUT_AT, JOINT_AT, LIMIT_AT, RIG_AT
from layflat.rig.safety.demands import DEMAND_REFUSED
from layflat.rig.safety.faults import FAULT_NO, MODE_NO, STATE_NO, Fault
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
DEVICE_RUNS, DEVICE_DUMPED = float(DeviceState.RUNNING), float(DeviceState.DUMPED)
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
    answered = inputs[INPUT_AT.answered] > 0.0
    if step == DEVICE_STEP and answered and inputs[INPUT_AT.device] == DEVICE_RUNS and has_air(memory[RIG_AT.mode]):
        memory[RIG_AT.obeyed] = 1.0
    elif step == AIR_STEP and answered and memory[RIG_AT.state] == STATE_NO.STARTING:
        update_air_time(rows)
    elif step == TIME_STEP:
        memory[RIG_AT.in_state] += inputs[INPUT_AT.since]
        memory[RIG_AT.in_mode] += inputs[INPUT_AT.since]
        memory[RIG_AT.reset_for] = max(memory[RIG_AT.reset_for] - 1.0, 0.0)
    elif step == REFUSAL_STEP and memory[RIG_AT.refused] > 0.0:
        memory[RIG_AT.wake] = 1.0


@composition
def has_stopped_obeying(memory, inputs):
    """Return whether the device, after it has obeyed, has centred or dumped by itself."""
    return memory[RIG_AT.obeyed] > 0.0 and inputs[INPUT_AT.device] != DEVICE_RUNS


@composition
def are_setpoints_stale(rows):
    """Return whether setpoints are too old for a rig with air."""
    return rows.inputs[INPUT_AT.age] > rows.rig[LIMIT_AT.stale_after] and has_air(rows.memory[RIG_AT.mode])


@composition
def find_fault(rows, step):
    """Return the number of the machine's fault that a step notes, or 0."""
    memory, inputs, fault = rows.memory, rows.inputs, 0.0
    answered, on = inputs[INPUT_AT.answered] > 0.0, has_air(memory[RIG_AT.mode])
    if step == E_STOP_STEP and answered and inputs[INPUT_AT.stopped] > 0.0:
        fault = FAULT_NO.E_STOP
    elif step == DEVICE_STEP and answered and on and has_stopped_obeying(memory, inputs):
        fault = FAULT_NO.DEVICE_DUMPED if inputs[INPUT_AT.device] == DEVICE_DUMPED else FAULT_NO.DEVICE_CENTRED
    elif step == SAMPLES_STEP and answered:
        fault = memory[RIG_AT.fault]
    elif step == AIR_STEP and answered and memory[RIG_AT.state] == STATE_NO.STARTING and not has_air_come(rows):
        fault = FAULT_NO.NO_AIR if memory[RIG_AT.in_state] > rows.rig[LIMIT_AT.start_time] else 0.0
    elif step == REPLY_STEP and not answered:
        fault = FAULT_NO.REPLY_LOST
    elif step == LINK_STEP and memory[RIG_AT.lost] >= MAX_LOST_REPLIES:
        fault = FAULT_NO.LINK_LOST
    elif step == MISSED_STEP and inputs[INPUT_AT.missed] > 0.0:
        fault = FAULT_NO.CYCLE_MISSED
    elif step == RECORDER_STEP and inputs[INPUT_AT.unrecorded] > 0.0:
        fault = FAULT_NO.RECORDER_DEAD
    elif step == STALE_STEP and are_setpoints_stale(rows):
        fault = FAULT_NO.SETPOINT_STALE
    elif step == MODEL_STEP and memory[RIG_AT.rejected] > 0.0:
        fault = FAULT_NO.MODEL_DOUBTED
    return fault


@composition
def find_joint_fault(rows, step, j):
    """Return the number of a joint's fault that a step notes, or 0."""
    joint, fault = rows.joints[j], 0.0
    if step == JOINT_SAMPLES_STEP and rows.inputs[INPUT_AT.answered] > 0.0:
        fault = joint[JOINT_AT.fault]
    elif step == DEMAND_STEP and joint[JOINT_AT.outcome] > 0.0:
        fault = FAULT_NO.DEMAND_REFUSED if joint[JOINT_AT.outcome] == DEMAND_REFUSED else FAULT_NO.DEMAND_LIMITED
    elif step == VOLTAGE_STEP and rows.memory[RIG_AT.refused] > 0.0 and not is_voltage_good(rows, j):
        fault = FAULT_NO.BAD_COMMAND
    return fault


@composition
def decide(rows, step, state, mode):
    """Return the decision of a step.

    Stale setpoints under air begin a controlled stop; of requests, a stop comes before a hold, and this before a start.
    """
    memory, inputs, decision = rows.memory, rows.inputs, stay(state, mode)
    stops = step == REQUEST_STEP and inputs[INPUT_AT.stop] > 0.0
    if step == AIR_STEP and inputs[INPUT_AT.answered] > 0.0 and state == STATE_NO.STARTING and has_air_come(rows):
        reset_detectors(rows)
        decision = Decision(STATE_NO.READY, MODE_NO.HOLD, 0.0, 0.0)
    elif (stops and has_air(mode)) or (step == STALE_STEP and are_setpoints_stale(rows)):
        decision = stop(rows, state, mode)
    elif step == RESET_STEP and inputs[INPUT_AT.reset] > 0.0:
        decision = reset(rows, state, mode)
    elif step == REQUEST_STEP and not stops and inputs[INPUT_AT.hold] > 0.0:
        decision = hold(state, mode)
    elif step == REQUEST_STEP and not stops and inputs[INPUT_AT.start] > 0.0:
        decision = start(rows, state, mode)
    elif step == REACTION_STEP and memory[RIG_AT.latched] > 0.0:
        decision = react(rows, state, mode, PRESENT_ANGLES)
    elif step == STOP_STEP:
        decision = continue_stop(rows, state, mode)
    elif step == MOTION_STEP:
        decision = move(rows, state, mode)
    elif step == REFUSAL_STEP and memory[RIG_AT.refused] > 0.0:
        decision = react(rows, state, mode, PRESENT_DEMANDS)
    return decision
