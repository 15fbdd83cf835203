"""Whole control cycle of a rig as one call of compiled code: it judges, decides, controls, and commands the valves."""

# mypy: disable-error-code="no-untyped-def"

from layflat.jit import composition, portable_kernel
from layflat.lanes import read_numbers
from layflat.rig.safety.cycle import (
    estimate_motion,
    judge_samples,
    pass_demands,
    pass_voltages,
    run_law,
    write_coupling,
)
from layflat.rig.safety.cycle_numbers import COMMAND_AT, INPUT_AT, JOINT_AT, LIMIT_AT, RESULT_AT, RIG_AT
from layflat.rig.safety.faults import STATE_NO
from layflat.rig.safety.holding import detection_level, has_air, write_voltages_without_air
from layflat.rig.safety.ledger import begin_ledger
from layflat.rig.safety.soft_start import begin_reading
from layflat.rig.safety.state_machine import RESET_HIGH_CYCLES
from layflat.rig.safety.steps import DEVICE_DUMPED, E_STOP_STEP, LAST_STEP, MODEL_STEP, take_steps

CONTROL_PART, COMMAND_PART = 1, 2  # parts of a cycle: up to the control law, and behind it


@portable_kernel()
def run_cycle(likes, nothing, rejection_column, rows, law_rows, parts):
    """Run a control cycle, in which the memory advances and the results are written.

    Args: `CycleLikes`; a tuple of zeros, one a joint; the column of the law's report that is 1 once it has given up its
    model, negative if none; `CycleRows`; `LawRows`; flags of the parts of the cycle that are run.
    """
    if parts & CONTROL_PART and judge_and_decide(likes.arm, nothing, rows, law_rows.arm, law_rows.scratch):
        run_law(rows, likes, law_rows, nothing, rejection_column)
    if parts & COMMAND_PART:
        command_valves(rows)


@portable_kernel(results=1)
def judge_and_decide(arm_like, nothing, rows, arm, scratch):
    """Begin a cycle, judge its samples, decide on states, and pass the demands; return 1 if there are samples, else 0.

    Args: structure of the arm's parameters; a tuple of zeros, one a joint; `CycleRows`; parameters of the arm;
    workspace as of `write_coupling`.
    """
    begin_cycle(rows)
    answered = rows.inputs[INPUT_AT.answered] > 0.0
    if answered:
        write_coupling(rows, read_numbers(arm_like, arm), nothing, scratch)
        judge_samples(rows, detection_level(rows.memory[RIG_AT.state], rows.memory[RIG_AT.mode]))
    take_steps(rows, E_STOP_STEP, MODEL_STEP)
    pass_demands(rows)
    if answered:
        estimate_motion(rows)
    return 1 if answered else 0


@portable_kernel()
def command_valves(rows):
    """Pass the voltages of the control law or of valves without air, take the steps behind it, write the results."""
    on = has_air(rows.memory[RIG_AT.mode])
    if on:
        pass_voltages(rows)
    take_steps(rows, MODEL_STEP, LAST_STEP)
    if not on:
        write_voltages_without_air(rows)
    write_results(rows)


@composition
def begin_cycle(rows):
    """Begin a cycle: count lost replies, switch the digital outputs, and initialize with the first reading."""
    memory, inputs = rows.memory, rows.inputs
    begin_ledger(rows)
    memory[RIG_AT.rejected] = memory[RIG_AT.refused] = 0.0
    if inputs[INPUT_AT.switched] > 0.0:
        switched = int(inputs[INPUT_AT.switched])
        memory[RIG_AT.outputs] = (int(memory[RIG_AT.outputs]) & ~switched) | (int(inputs[INPUT_AT.on]) & switched)
    if inputs[INPUT_AT.answered] > 0.0:
        memory[RIG_AT.lost], memory[RIG_AT.pressed] = 0.0, inputs[INPUT_AT.stopped]
        if inputs[INPUT_AT.device] == DEVICE_DUMPED:
            memory[RIG_AT.outputs] = 0.0  # as the device's are: none switches on by itself once it obeys again
        if memory[RIG_AT.begun] == 0.0:
            begin_reading(rows, 0.0)
    else:
        memory[RIG_AT.lost] += 1.0


@composition
def write_results(rows):
    """Write the results of a cycle."""
    memory, results, mode = rows.memory, rows.results, rows.memory[RIG_AT.mode]
    on = has_air(mode)
    is_vented = not on and memory[RIG_AT.in_mode] >= rows.rig[LIMIT_AT.vent_time]
    results[RESULT_AT.air] = 1.0 if on else 0.0
    results[RESULT_AT.reset] = 1.0 if 0.0 < memory[RIG_AT.reset_for] <= RESET_HIGH_CYCLES else 0.0
    results[RESULT_AT.outputs], results[RESULT_AT.lost] = memory[RIG_AT.outputs], memory[RIG_AT.lost]
    results[RESULT_AT.state], results[RESULT_AT.mode] = memory[RIG_AT.state], mode
    results[RESULT_AT.vented] = 1.0 if is_vented or memory[RIG_AT.state] == STATE_NO.OFF else 0.0
    results[RESULT_AT.fault] = max(memory[RIG_AT.latched], memory[RIG_AT.worst_now])
    for j in range(len(rows.joints)):
        joint = rows.joints[j]
        rows.commands[j, COMMAND_AT.voltage] = joint[JOINT_AT.voltage]
        rows.commands[j, COMMAND_AT.fault] = max(joint[JOINT_AT.latched], joint[JOINT_AT.worst_now])
