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
from layflat.rig.safety.cycle_numbers import COMMAND, IN, JOINT, LIMIT, OUT, RIG
from layflat.rig.safety.faults import STATE
from layflat.rig.safety.holding import detection_level, has_air, write_voltages_without_air
from layflat.rig.safety.ledger import begin_ledger
from layflat.rig.safety.soft_start import begin_reading
from layflat.rig.safety.state_machine import RESET_HIGH_CYCLES
from layflat.rig.safety.steps import DUMPED, E_STOP_STEP, LAST_STEP, MODEL_STEP, take_steps

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
    answered = rows.inputs[IN.answered] > 0.0
    if answered:
        write_coupling(rows, read_numbers(arm_like, arm), nothing, scratch)
        judge_samples(rows, detection_level(rows.memory[RIG.state], rows.memory[RIG.mode]))
    take_steps(rows, E_STOP_STEP, MODEL_STEP)
    pass_demands(rows)
    if answered:
        estimate_motion(rows)
    return 1 if answered else 0


@portable_kernel()
def command_valves(rows):
    """Pass the voltages of the control law or of valves without air, take the steps behind it, write the results."""
    on = has_air(rows.memory[RIG.mode])
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
    memory[RIG.rejected] = memory[RIG.refused] = 0.0
    if inputs[IN.switched] > 0.0:
        switched = int(inputs[IN.switched])
        memory[RIG.outputs] = (int(memory[RIG.outputs]) & ~switched) | (int(inputs[IN.on]) & switched)
    if inputs[IN.answered] > 0.0:
        memory[RIG.lost], memory[RIG.pressed] = 0.0, inputs[IN.stopped]
        if inputs[IN.device] == DUMPED:
            memory[RIG.outputs] = 0.0  # as the device's are: none switches on by itself once it obeys again
        if memory[RIG.begun] == 0.0:
            begin_reading(rows, 0.0)
    else:
        memory[RIG.lost] += 1.0


@composition
def write_results(rows):
    """Write the results of a cycle."""
    memory, results, mode = rows.memory, rows.results, rows.memory[RIG.mode]
    on = has_air(mode)
    is_vented = not on and memory[RIG.in_mode] >= rows.rig[LIMIT.vent_time]
    results[OUT.air] = 1.0 if on else 0.0
    results[OUT.reset] = 1.0 if 0.0 < memory[RIG.reset_for] <= RESET_HIGH_CYCLES else 0.0
    results[OUT.outputs], results[OUT.state], results[OUT.mode] = memory[RIG.outputs], memory[RIG.state], mode
    results[OUT.vented] = 1.0 if is_vented or memory[RIG.state] == STATE.OFF else 0.0
    results[OUT.fault] = max(memory[RIG.latched], memory[RIG.worst_now])
    results[OUT.lost] = memory[RIG.lost]
    for j in range(len(rows.joints)):
        joint = rows.joints[j]
        rows.commands[j, COMMAND.voltage] = joint[JOINT.voltage]
        rows.commands[j, COMMAND.fault] = max(joint[JOINT.latched], joint[JOINT.worst_now])
