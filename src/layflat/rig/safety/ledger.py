"""Ledger of faults as compiled code: those of this cycle, and those that are latched; the worst wins.

Functions take `CycleRows`. Joints count from 0; joint -1 is the machine as a whole.
"""

# mypy: disable-error-code="no-untyped-def"

from layflat.jit import composition, law
from layflat.rig.safety.cycle_numbers import EVENT_AT, JOINT_AT, RESULT_AT, RIG_AT
from layflat.rig.safety.faults import FAULT_NO, FIRST_OF_REACTION, Fault, Reaction

# Numbers of events that are no faults: a state that was entered, by its own number; a start that a latched fault
# or the e-stop forbids; one that is not recorded; a reset of a fault that is still there.
STATE_ENTERED, START_BARRED, START_UNRECORDED, RESET_REFUSED = 32.0, 64.0, 65.0, 66.0
FIRST_LATCHED = float(min(fault for fault in Fault if fault.latched))
HOLD_FROM, STOP_FROM, VENT_JOINT_FROM, VENT_FROM, DUMP_FROM = (
    float(FIRST_OF_REACTION[reaction]) for reaction in list(Reaction)[1:]
)


@law
def is_latching(fault):
    """Return whether a fault stays until a reset."""
    return fault >= FIRST_LATCHED and fault != FAULT_NO.SETPOINT_STALE


@law
def reaction_to(fault):
    """Return the number of the reaction to a fault."""
    return (
        (1.0 if fault >= HOLD_FROM else 0.0)
        + (1.0 if fault >= STOP_FROM else 0.0)
        + (1.0 if fault >= VENT_JOINT_FROM else 0.0)
        + (1.0 if fault >= VENT_FROM else 0.0)
        + (1.0 if fault >= DUMP_FROM else 0.0)
    )


@law
def has_bit(bits, number):
    """Return whether a bit is set."""
    return (int(bits) >> int(number)) & 1 == 1


@composition
def begin_ledger(rows):
    """Begin a cycle without faults and events."""
    memory = rows.memory
    memory[RIG_AT.before], memory[RIG_AT.present], memory[RIG_AT.worst_now] = memory[RIG_AT.present], 0.0, 0.0
    for j in range(len(rows.joints)):
        joint = rows.joints[j]
        joint[JOINT_AT.before], joint[JOINT_AT.present], joint[JOINT_AT.worst_now] = joint[JOINT_AT.present], 0.0, 0.0
    rows.results[RESULT_AT.events] = 0.0


@composition
def clear_latched(rows):
    """Clear all latched faults, and the reaction to them."""
    rows.memory[RIG_AT.latched] = rows.memory[RIG_AT.reaction] = 0.0
    for j in range(len(rows.joints)):
        rows.joints[j, JOINT_AT.latched] = 0.0


@composition
def add_event(rows, number, joint):
    """Add an event to those of this cycle."""
    k = int(rows.results[RESULT_AT.events])
    if k < len(rows.events):
        rows.events[k, EVENT_AT.number], rows.events[k, EVENT_AT.joint] = number, joint
        rows.results[RESULT_AT.events] = k + 1.0


@composition
def note_fault(rows, fault, joint):
    """Add a fault of this cycle; latch one that latches. One that was not there in the cycle before adds an event."""
    memory, j = rows.memory, max(joint, 0)
    own = rows.joints[j]
    present = own[JOINT_AT.present] if joint >= 0 else memory[RIG_AT.present]
    if has_bit(present, fault):
        return
    if not has_bit(own[JOINT_AT.before] if joint >= 0 else memory[RIG_AT.before], fault):
        add_event(rows, fault, joint)
    present += float(1 << int(fault))
    memory[RIG_AT.worst_now] = max(memory[RIG_AT.worst_now], fault)
    if is_latching(fault):
        memory[RIG_AT.latched] = max(memory[RIG_AT.latched], fault)
        memory[RIG_AT.reaction] = max(memory[RIG_AT.reaction], reaction_to(fault))
    if joint < 0:
        memory[RIG_AT.present] = present
        return
    own[JOINT_AT.present], own[JOINT_AT.worst_now] = present, max(own[JOINT_AT.worst_now], fault)
    if is_latching(fault):
        own[JOINT_AT.latched] = max(own[JOINT_AT.latched], fault)
