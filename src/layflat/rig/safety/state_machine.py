"""State machine of a rig as compiled code; requests of the host, faults, and time cause its transitions.

Functions take `CycleRows`. A decision is where the machine goes on: it has been told the state and the mode at present.
"""

# mypy: disable-error-code="no-untyped-def"

from math import isnan
from typing import NamedTuple

from layflat.jit import composition, law
from layflat.rig.safety.cycle_numbers import IN, LIMIT, RIG, SAMPLE
from layflat.rig.safety.faults import FAULT, MODE, REACTION, STATE
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
    if decision.state != memory[RIG.state]:
        event = STATE_ENTERED + decision.state
        memory[RIG.state], memory[RIG.in_state] = decision.state, 0.0
    if event > 0.0:
        add_event(rows, event, -1)
    if decision.mode != memory[RIG.mode]:
        if has_air(decision.mode) and not has_air(memory[RIG.mode]):
            memory[RIG.wake] = 1.0
            reset_detectors(rows)
        memory[RIG.mode], memory[RIG.in_mode] = decision.mode, 0.0


@composition
def start(rows, state, mode):
    """Start softly from OFF or STOPPED, go from HOLDING to READY; without effect in other states.

    If a latched fault, the e-stop or a missing recorder forbids it, it is refused.
    """
    memory = rows.memory
    if memory[RIG.latched] > 0.0 or memory[RIG.pressed] > 0.0:
        return refuse(state, mode, START_BARRED)
    if rows.inputs[IN.unrecorded] > 0.0:
        return refuse(state, mode, START_UNRECORDED)
    if state == STATE.HOLDING and has_air(mode):
        return Decision(STATE.READY, MODE.HOLD, 0.0, 0.0)
    if state not in (STATE.OFF, STATE.STOPPED):
        return stay(state, mode)
    memory[RIG.obeyed], memory[RIG.reset_for], memory[RIG.air_time] = 0.0, RESET_CYCLES, 0.0
    return Decision(STATE.STARTING, MODE.HOLD, PRESENT_ANGLES, 0.0)


@law
def hold(state, mode):
    """Hold the joints where they are or can stop, from READY or MOVING; without effect in other states."""
    if state in (STATE.READY, STATE.MOVING):
        return Decision(STATE.HOLDING, MODE.HOLD, PRESENT_ANGLES, 0.0)
    return stay(state, mode)


@composition
def stop(rows, state, mode):
    """Begin a controlled stop: hold the joints, centre the valves, then vent (see `continue_stop`).

    A soft start is broken off with centred valves. In FAULT the reaction becomes at least STOP. Without effect in
    STOPPED.
    """
    memory = rows.memory
    if state == STATE.FAULT:
        memory[RIG.reaction] = max(memory[RIG.reaction], REACTION.STOP)
        return stay(state, mode)
    if state == STATE.STOPPED:
        return stay(state, mode)
    if state == STATE.STARTING:
        return Decision(STATE.STOPPED, MODE.CENTRE, 0.0, 0.0)
    memory[RIG.in_mode] = 0.0
    is_held = mode == MODE.HOLD and state == STATE.HOLDING
    return Decision(STATE.STOPPED, MODE.HOLD, 0.0 if is_held else PRESENT_ANGLES, 0.0)


@composition
def reset(rows, state, mode):
    """Clear all latched faults, pulse the reset bit, and leave FAULT for HOLDING where air is on, else OFF.

    With the e-stop pressed, or a fault from DEVICE_CENTRED on present under air, it is refused.
    """
    memory, on = rows.memory, has_air(mode)
    if memory[RIG.pressed] > 0.0 or (memory[RIG.worst_now] >= FAULT.DEVICE_CENTRED and on):
        return refuse(state, mode, RESET_REFUSED)
    clear_latched(rows)
    memory[RIG.reset_for] = RESET_CYCLES
    if state != STATE.FAULT:
        return stay(state, mode)
    reset_detectors(rows)
    return Decision(STATE.HOLDING if on else STATE.OFF, mode if on else MODE.CENTRE, PRESENT_ANGLES, 0.0)


@composition
def react(rows, state, mode, angles):
    """Enter FAULT with the mode of the worst reaction to latched faults; air that is off stays off.

    Joints that move are held at `angles`: PRESENT_ANGLES or PRESENT_DEMANDS.
    """
    reaction, on = rows.memory[RIG.reaction], has_air(mode)
    held = angles if mode == MODE.FOLLOW or (on and state != STATE.FAULT) else 0.0
    if on:
        # Enclosed air brakes best: valves open once the supply line is empty.
        return Decision(STATE.FAULT, MODE.CENTRE if reaction >= REACTION.VENT_JOINT else MODE.HOLD, held, 0.0)
    is_worse = mode == MODE.VENT_JOINT and reaction >= REACTION.VENT
    return Decision(STATE.FAULT, MODE.VENT if is_worse else mode, held, 0.0)


@composition
def continue_stop(rows, state, mode):
    """Take the next step of a stop once it is due: held, centred, vented."""
    memory = rows.memory
    reaction = memory[RIG.reaction] if state == STATE.FAULT else REACTION.STOP
    if state not in (STATE.STOPPED, STATE.FAULT) or reaction < REACTION.STOP:
        return stay(state, mode)
    if mode == MODE.HOLD and memory[RIG.in_mode] >= rows.rig[LIMIT.hold_time]:
        return Decision(state, MODE.CENTRE, 0.0, 0.0)
    if mode == MODE.CENTRE and memory[RIG.in_mode] >= CENTRED_TIME:
        return Decision(state, MODE.VENT_JOINT if reaction == REACTION.VENT_JOINT else MODE.VENT, 0.0, 0.0)
    return stay(state, mode)


@composition
def move(rows, state, mode):
    """Begin to move from READY once there is a demand for any joint."""
    is_demanded = False
    for j in range(len(rows.samples)):
        is_demanded = is_demanded or not isnan(rows.samples[j, SAMPLE.requested])
    return Decision(STATE.MOVING, MODE.FOLLOW, 0.0, 0.0) if state == STATE.READY and is_demanded else stay(state, mode)
