"""State machine of a rig as compiled code; requests of the host, faults, and time cause its transitions.

Functions take `CycleRows`. A decision is where the machine goes on: it has been told the state and the mode at present.
"""

# mypy: disable-error-code="no-untyped-def"

from math import isnan
from typing import NamedTuple

from layflat.jit import composition, law
from layflat.rig.safety.cycle_numbers import INPUT_AT, LIMIT_AT, RIG_AT, SAMPLE_AT
from layflat.rig.safety.faults import FAULT_NO, MODE_NO, REACTION_NO, STATE_NO
from layflat.rig.safety.holding import has_air, hold_joints, reset_detectors
from layflat.rig.safety.ledger import (
    RESET_REFUSED,
    START_BARRED,
    START_UNRECORDED,
    STATE_ENTERED,
    add_event,
    clear_latched,
)

# Cycles for which the reset bit is low, then high: the device detects the edge, even if one reply is lost.
RESET_LOW_CYCLES, RESET_HIGH_CYCLES = 4, 4
RESET_CYCLES = float(RESET_LOW_CYCLES + RESET_HIGH_CYCLES)
# Valves are centred for so long before they open to vent the hoses: until the supply line is empty, and the joints
# have come to rest between closed hoses, s.
CENTRED_TIME = 0.3
PRESENT_ANGLES, PRESENT_DEMANDS = 1.0, 2.0  # at which joints are held


class Decision(NamedTuple):
    """Decision of the state machine."""

    state: float  # that it enters
    mode: float  # of the valves, likewise
    held: float  # PRESENT_ANGLES or PRESENT_DEMANDS where the joints are held from now on, else 0
    event: float  # that tells why nothing changes; 0: none


@law
def stay(state, mode):
    """Return the decision to change nothing."""
    return Decision(state, mode, 0.0, 0.0)


@law
def refuse(state, mode, event):
    """Return the decision to change nothing but for an event."""
    return Decision(state, mode, 0.0, event)


@composition
def carry_out(rows, decision):
    """Carry out a decision; a change of state is an event.

    A mode that switches the air on resets the detectors, and lets the controllers begin anew.
    """
    memory, event = rows.memory, decision.event
    if decision.held > 0.0:
        hold_joints(rows, decision.held == PRESENT_DEMANDS)
    if decision.state != memory[RIG_AT.state]:
        event = STATE_ENTERED + decision.state
        memory[RIG_AT.state], memory[RIG_AT.in_state] = decision.state, 0.0
    if event > 0.0:
        add_event(rows, event, -1)
    if decision.mode != memory[RIG_AT.mode]:
        if has_air(decision.mode) and not has_air(memory[RIG_AT.mode]):
            memory[RIG_AT.wake] = 1.0
            reset_detectors(rows)
        memory[RIG_AT.mode], memory[RIG_AT.in_mode] = decision.mode, 0.0


@composition
def start(rows, state, mode):
    """Start softly from OFF or STOPPED, go from HOLDING to READY; without effect in other states.

    If a latched fault, the e-stop or a missing recorder forbids it, it is refused.
    """
    memory = rows.memory
    if memory[RIG_AT.latched] > 0.0 or memory[RIG_AT.pressed] > 0.0:
        return refuse(state, mode, START_BARRED)
    if rows.inputs[INPUT_AT.unrecorded] > 0.0:
        return refuse(state, mode, START_UNRECORDED)
    if state == STATE_NO.HOLDING and has_air(mode):
        return Decision(STATE_NO.READY, MODE_NO.HOLD, 0.0, 0.0)
    if state not in (STATE_NO.OFF, STATE_NO.STOPPED):
        return stay(state, mode)
    memory[RIG_AT.obeyed], memory[RIG_AT.reset_for], memory[RIG_AT.air_time] = 0.0, RESET_CYCLES, 0.0
    return Decision(STATE_NO.STARTING, MODE_NO.HOLD, PRESENT_ANGLES, 0.0)


@law
def hold(state, mode):
    """Hold the joints where they are or can stop, from READY or MOVING; without effect in other states."""
    if state in (STATE_NO.READY, STATE_NO.MOVING):
        return Decision(STATE_NO.HOLDING, MODE_NO.HOLD, PRESENT_ANGLES, 0.0)
    return stay(state, mode)


@composition
def stop(rows, state, mode):
    """Begin a controlled stop: hold the joints, centre the valves, then vent (see `continue_stop`).

    A soft start is broken off with centred valves. In FAULT the reaction becomes at least STOP. Without effect in
    STOPPED.
    """
    memory = rows.memory
    if state == STATE_NO.FAULT:
        memory[RIG_AT.reaction] = max(memory[RIG_AT.reaction], REACTION_NO.STOP)
        return stay(state, mode)
    if state == STATE_NO.STOPPED:
        return stay(state, mode)
    if state == STATE_NO.STARTING:
        return Decision(STATE_NO.STOPPED, MODE_NO.CENTRE, 0.0, 0.0)
    memory[RIG_AT.in_mode] = 0.0
    is_held = mode == MODE_NO.HOLD and state == STATE_NO.HOLDING
    return Decision(STATE_NO.STOPPED, MODE_NO.HOLD, 0.0 if is_held else PRESENT_ANGLES, 0.0)


@composition
def reset(rows, state, mode):
    """Clear all latched faults, pulse the reset bit, and leave FAULT for HOLDING where air is on, else OFF.

    With the e-stop pressed, or a fault from DEVICE_CENTRED on present under air, it is refused.
    """
    memory, on = rows.memory, has_air(mode)
    if memory[RIG_AT.pressed] > 0.0 or (memory[RIG_AT.worst_now] >= FAULT_NO.DEVICE_CENTRED and on):
        return refuse(state, mode, RESET_REFUSED)
    clear_latched(rows)
    memory[RIG_AT.reset_for] = RESET_CYCLES
    if state != STATE_NO.FAULT:
        return stay(state, mode)
    reset_detectors(rows)
    return Decision(STATE_NO.HOLDING if on else STATE_NO.OFF, mode if on else MODE_NO.CENTRE, PRESENT_ANGLES, 0.0)


@composition
def react(rows, state, mode, angles):
    """Enter FAULT with the mode of the worst reaction to latched faults; air that is off stays off.

    Joints that move are held at `angles`: PRESENT_ANGLES or PRESENT_DEMANDS.
    """
    reaction, on = rows.memory[RIG_AT.reaction], has_air(mode)
    held = angles if mode == MODE_NO.FOLLOW or (on and state != STATE_NO.FAULT) else 0.0
    if on:
        # Enclosed air brakes best: valves open once the supply line is empty.
        mode = MODE_NO.CENTRE if reaction >= REACTION_NO.VENT_JOINT else MODE_NO.HOLD
    elif mode == MODE_NO.VENT_JOINT and reaction >= REACTION_NO.VENT:
        mode = MODE_NO.VENT
    return Decision(STATE_NO.FAULT, mode, held, 0.0)


@composition
def continue_stop(rows, state, mode):
    """Take the next step of a stop once it is due: held, centred, vented."""
    memory = rows.memory
    reaction = memory[RIG_AT.reaction] if state == STATE_NO.FAULT else REACTION_NO.STOP
    if state not in (STATE_NO.STOPPED, STATE_NO.FAULT) or reaction < REACTION_NO.STOP:
        return stay(state, mode)
    if mode == MODE_NO.HOLD and memory[RIG_AT.in_mode] >= rows.rig[LIMIT_AT.hold_time]:
        return Decision(state, MODE_NO.CENTRE, 0.0, 0.0)
    if mode == MODE_NO.CENTRE and memory[RIG_AT.in_mode] >= CENTRED_TIME:
        return Decision(state, MODE_NO.VENT_JOINT if reaction == REACTION_NO.VENT_JOINT else MODE_NO.VENT, 0.0, 0.0)
    return stay(state, mode)


@composition
def move(rows, state, mode):
    """Begin to move from READY once there is a demand for any joint."""
    is_demanded = False
    for j in range(len(rows.samples)):
        is_demanded = is_demanded or not isnan(rows.samples[j, SAMPLE_AT.requested])
    if state != STATE_NO.READY or not is_demanded:
        return stay(state, mode)
    return Decision(STATE_NO.MOVING, MODE_NO.FOLLOW, 0.0, 0.0)
