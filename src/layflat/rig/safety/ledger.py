"""Ledger of faults as compiled code: those of this cycle, and those that are latched; the worst wins.

Functions take `CycleRows`. Joints count from 0; joint -1 is the machine as a whole.
"""

# mypy: disable-error-code="no-untyped-def"

from layflat.jit import composition, law
from layflat.rig.safety.cycle_numbers import EVENT, JOINT, OUT, RIG
from layflat.rig.safety.faults import FAULT, FIRST_OF_REACTION, Fault, Reaction

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
    return fault >= FIRST_LATCHED and fault != FAULT.SETPOINT_STALE


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
    memory[RIG.before], memory[RIG.present], memory[RIG.worst_now] = memory[RIG.present], 0.0, 0.0
    for j in range(len(rows.joints)):
        joint = rows.joints[j]
        joint[JOINT.before], joint[JOINT.present], joint[JOINT.worst_now] = joint[JOINT.present], 0.0, 0.0
    rows.results[OUT.events] = 0.0


@composition
def clear_latched(rows):
    """Clear all latched faults, and the reaction to them."""
    rows.memory[RIG.latched] = rows.memory[RIG.reaction] = 0.0
    for j in range(len(rows.joints)):
        rows.joints[j, JOINT.latched] = 0.0


@composition
def add_event(rows, number, joint):
    """Add an event to those of this cycle."""
    k = int(rows.results[OUT.events])
    if k < len(rows.events):
        rows.events[k, EVENT.number], rows.events[k, EVENT.joint] = number, joint
        rows.results[OUT.events] = k + 1.0


@composition
def note_fault(rows, fault, joint):
    """Add a fault of this cycle; latch one that latches. One that was not there in the cycle before adds an event."""
    memory, j = rows.memory, max(joint, 0)
    own = rows.joints[j]
    present = own[JOINT.present] if joint >= 0 else memory[RIG.present]
    if has_bit(present, fault):
        return
    if not has_bit(own[JOINT.before] if joint >= 0 else memory[RIG.before], fault):
        add_event(rows, fault, joint)
    present += float(1 << int(fault))
    memory[RIG.worst_now] = max(memory[RIG.worst_now], fault)
    if is_latching(fault):
        memory[RIG.latched] = max(memory[RIG.latched], fault)
        memory[RIG.reaction] = max(memory[RIG.reaction], reaction_to(fault))
    if joint < 0:
        memory[RIG.present] = present
        return
    own[JOINT.present], own[JOINT.worst_now] = present, max(own[JOINT.worst_now], fault)
    if is_latching(fault):
        own[JOINT.latched] = max(own[JOINT.latched], fault)
