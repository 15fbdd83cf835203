"""What each fault means for the person at the rig: why, and what to do next."""

from layflat.rig.safety.faults import Fault, Reaction
from layflat.rig.safety.states import State

REASONS: dict[Fault, tuple[str, str]] = {
    Fault.RECORDER_DEAD: (
        "Nothing is recorded any more: the disk may be full.",
        "Make room on the disk; the rig connects anew once its air is out.",
    ),
    Fault.DEMAND_LIMITED: (
        "The arm was asked to move faster than it can.",
        "Nothing to do: it went as fast as it can.",
    ),
    Fault.DEMAND_REFUSED: ("A place outside the working stroke was asked for.", "Ask for a place inside the stroke."),
    Fault.CYCLE_MISSED: (
        "This computer was too busy for the control loop.",
        "If it comes again and again, close other programs.",
    ),
    Fault.REPLY_LOST: ("One message from the rig was lost.", "If it comes again and again, look at cable and plugs."),
    Fault.MODEL_DOUBTED: (
        "The arm does not behave as described: a wrong payload, a leak, or something in its way.",
        "Look what holds the arm; check payload and description; then ask for another place.",
    ),
    Fault.FOLLOWING_ERROR: (
        "A joint does not go where it is led: something holds it, or the load is too heavy.",
        "Free the arm, or lighten the load. Then reset, and go on.",
    ),
    Fault.BAD_COMMAND: (
        "The control law asked for a voltage that can't be.",
        "Reset; if it comes again, check the gains.",
    ),
    Fault.DEVICE_CENTRED: (
        "The rig heard nothing from this computer for a moment and closed its valves.",
        "Look at cable and plugs. Then reset, and go on.",
    ),
    Fault.SETPOINT_STALE: (
        "Nobody minded the rig: the page was closed, hidden or out of touch.",
        "Keep this page open and in view while there is air; then start again.",
    ),
    Fault.NO_AIR: (
        "The supply did not come to its pressure.",
        "Open the supply, look for leaks. Then reset and start.",
    ),
    Fault.PRESSURE_FROZEN: (
        "A pressure sensor repeats one value.",
        "Look at the sensor's wires and plug. Then reset and start.",
    ),
    Fault.ANGLE_FROZEN: (
        "An angle does not change although it should: its sensor is frozen, or the joint is blocked.",
        "See whether the joint can turn; look at the sensor's wires. Then reset and start.",
    ),
    Fault.ANGLE_AT_RAIL: (
        "An angle sensor is open or shorted.",
        "Look at the sensor's wires and plug. Then reset and start.",
    ),
    Fault.SUPPLY_LOST: (
        "The supply's pressure has fallen: compressor off, line burst or shut.",
        "See to the compressor and the line. Then reset and start.",
    ),
    Fault.VALVE_UNRESPONSIVE: (
        "Air does not answer the valve: a spool sticks, or a hose is burst or kinked.",
        "Look at the joint's hoses and valve. Then reset and start.",
    ),
    Fault.LINK_LOST: (
        "The rig does not answer any more.",
        "Look at its power, cable and plugs. The page connects again by itself; then reset.",
    ),
    Fault.OVER_PRESSURE: ("Pressure is too high.", "Look at the regulator. Then reset and start."),
    Fault.OUTSIDE_STROKE: (
        "A joint went beyond its working stroke.",
        "See what pushed it. Then reset and start: the arm is led inside slowly.",
    ),
    Fault.OVER_SPEED: (
        "A joint was too fast.",
        "See what pushed it, or whether it lost its load. Then reset and start.",
    ),
    Fault.DEVICE_DUMPED: (
        "The rig heard nothing from this computer and let out the air.",
        "Look at cable and plugs. Then reset and start.",
    ),
    Fault.E_STOP: ("The emergency stop is pressed.", "Release it when all is well. Then reset and start."),
}
"""Why each fault comes, and what to do next."""

STATES: dict[State, tuple[str, str]] = {
    State.OFF: ("Off", "No air. Start brings it, slowly."),
    State.STARTING: ("Starting", "Air comes in slowly; the joints are held."),
    State.READY: ("Ready", "Air is there. Jog, or give a target."),
    State.MOVING: ("Moving", "The arm follows what it is asked for."),
    State.HOLDING: ("Holding", "The joints are held, with air. Go on when all is well."),
    State.STOPPED: ("Stopped", "The joints were held, and the air is let out. Start brings it again."),
    State.FAULT: ("Fault", "See what to do below."),
}
"""What each state is called, and what it means."""

DONE: dict[Reaction, str] = {
    Reaction.WARN: "The arm goes on.",
    Reaction.HOLD: "The joints are held, with air.",
    Reaction.STOP: "The joints were held, and the air is let out.",
    Reaction.VENT_JOINT: "The air is off; the joint's valve lets its air out.",
    Reaction.VENT: "The air is let out of all joints.",
    Reaction.DUMP: "The air is let out, by the rig itself, too.",
}
"""What the rig has done about a fault, by its reaction."""
