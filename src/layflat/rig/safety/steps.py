"""Steps of a cycle's decisions, as compiled code: faults that are noted, and states that are entered, in their order.

Each step may update the memory, then note a fault, then change the state. Those from E_STOP_STEP on come before the
control law, those from MODEL_STEP on behind it. Functions take `CycleRows`.
"""

# mypy: disable-error-code="no-untyped-def"

from layflat.jit import composition, law
from layflat.lanes import read_numbers
from layflat.rig.driver import DeviceState
from layflat.rig.safety.cycle_numbers import FIRST_JOINT_MEMORY, FIRST_MEMORY, IN, INPUTS_TEMPLATE, RIG, RIG_TEMPLATE
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


@composition
def take_steps(rows, first, behind):
    """Take the steps from `first` on, up to that before `behind`."""
    for step in range(first, behind):
        update_memory(rows, step)
        by_joint = step == JOINT_SAMPLES_STEP or step == DEMAND_STEP or step == VOLTAGE_STEP  # noqa: PLR1714
        for j in range(len(rows.joints) if by_joint else 1):
            fault = find_joint_fault(rows, step, j) if by_joint else find_fault(rows, step)
            if fault > 0.0:
                note_fault(rows, fault, j if by_joint else -1)
        now = read_numbers(FIRST_MEMORY, rows.memory)
        carry_out(rows, decide(rows, step, now.state, now.mode))


@composition
def update_memory(rows, step):
    """Update what a step decides by."""
    memory, now = rows.memory, read_numbers(INPUTS_TEMPLATE, rows.inputs)
    answered = now.answered > 0.0
    if step == DEVICE_STEP and answered and now.device == RUNNING and has_air(memory[RIG.mode]):
        memory[RIG.obeyed] = 1.0
    elif step == AIR_STEP and answered and memory[RIG.state] == STATE.STARTING:
        update_air_time(rows)
    elif step == TIME_STEP:
        memory[RIG.in_state] += now.since
        memory[RIG.in_mode] += now.since
        memory[RIG.reset_for] = max(memory[RIG.reset_for] - 1.0, 0.0)
    elif step == REFUSAL_STEP and memory[RIG.refused] > 0.0:
        memory[RIG.wake] = 1.0


@law
def is_stale(rig, mode, age):
    """Return whether setpoints are too old for a rig with air."""
    return age > rig.stale_after and has_air(mode)


@composition
def find_fault(rows, step):
    """Return the number of the machine's fault that a step notes, or 0."""
    memory, now, rig = rows.memory, read_numbers(INPUTS_TEMPLATE, rows.inputs), read_numbers(RIG_TEMPLATE, rows.rig)
    answered, state, mode, fault = now.answered > 0.0, memory[RIG.state], memory[RIG.mode], 0.0
    if step == E_STOP_STEP and answered and now.stopped > 0.0:
        fault = FAULT.E_STOP
    elif step == DEVICE_STEP and answered and now.device != RUNNING and has_air(mode) and memory[RIG.obeyed] > 0.0:
        fault = FAULT.DEVICE_DUMPED if now.device == DUMPED else FAULT.DEVICE_CENTRED
    elif step == SAMPLES_STEP and answered:
        fault = memory[RIG.fault]
    elif step == AIR_STEP and answered and state == STATE.STARTING and not has_air_come(rows):
        fault = FAULT.NO_AIR if memory[RIG.in_state] > rig.start_time else 0.0
    elif step == REPLY_STEP and not answered:
        fault = FAULT.REPLY_LOST
    elif step == LINK_STEP and memory[RIG.lost] >= MAX_LOST_REPLIES:
        fault = FAULT.LINK_LOST
    elif step == MISSED_STEP and now.missed > 0.0:
        fault = FAULT.CYCLE_MISSED
    elif step == RECORDER_STEP and now.unrecorded > 0.0:
        fault = FAULT.RECORDER_DEAD
    elif step == STALE_STEP and is_stale(rig, mode, now.age):
        fault = FAULT.SETPOINT_STALE
    elif step == MODEL_STEP and memory[RIG.rejected] > 0.0:
        fault = FAULT.MODEL_DOUBTED
    return fault


@composition
def find_joint_fault(rows, step, j):
    """Return the number of a joint's fault that a step notes, or 0."""
    joint, rig = read_numbers(FIRST_JOINT_MEMORY, rows.joints[j]), read_numbers(RIG_TEMPLATE, rows.rig)
    fault = 0.0
    if step == JOINT_SAMPLES_STEP and rows.inputs[IN.answered] > 0.0:
        fault = joint.fault
    elif step == DEMAND_STEP and joint.outcome > 0.0:
        fault = FAULT.DEMAND_REFUSED if joint.outcome == DEMAND_REFUSED else FAULT.DEMAND_LIMITED
    elif step == VOLTAGE_STEP and rows.memory[RIG.refused] > 0.0:
        fault = 0.0 if rig.voltage_low <= joint.law_voltage <= rig.voltage_high else FAULT.BAD_COMMAND
    return fault


@composition
def decide(rows, step, state, mode):
    """Return the decision of a step.

    Stale setpoints under air begin a controlled stop; of requests, a stop comes before a hold, and this before a start.
    """
    memory, now = rows.memory, read_numbers(INPUTS_TEMPLATE, rows.inputs)
    if step == AIR_STEP and now.answered > 0.0 and state == STATE.STARTING and has_air_come(rows):
        reset_detectors(rows)
        return Decision(STATE.READY, MODE.HOLD, 0.0, 0.0)
    stops = step == REQUEST_STEP and now.stop > 0.0
    if (stops and has_air(mode)) or (
        step == STALE_STEP and is_stale(read_numbers(RIG_TEMPLATE, rows.rig), mode, now.age)
    ):
        return stop(rows, state, mode)
    if step == RESET_STEP and now.reset > 0.0:
        return reset(rows, state, mode)
    if step == REQUEST_STEP and not stops and now.hold > 0.0:
        return hold(state, mode)
    if step == REQUEST_STEP and not stops and now.start > 0.0:
        return start(rows, state, mode)
    if step == REACTION_STEP and memory[RIG.latched] > 0.0:
        return react(rows, state, mode, PRESENT_ANGLES)
    if step == STOP_STEP:
        return continue_stop(rows, state, mode)
    if step == MOTION_STEP:
        return move(rows, state, mode)
    if step == REFUSAL_STEP and memory[RIG.refused] > 0.0:
        return react(rows, state, mode, PRESENT_DEMANDS)
    return stay(state, mode)
