"""States of the supervisor, and what is done with the valves."""

from enum import IntEnum


class State(IntEnum):
    """Where the rig stands; numbers as they stand in records."""

    OFF = 0  # no air; the valves are centred
    STARTING = 1  # air comes in slowly; the joints are held where they are
    READY = 2  # air is there; no demand has been given yet
    MOVING = 3  # demands are obeyed
    HOLDING = 4  # the joints are held where they are, with air; a start goes on
    STOPPED = 5  # a controlled stop: the joints are held, then the air is let out; a start brings it again
    FAULT = 6  # a latched fault; a reset leads to OFF, or to HOLDING where the air was left on


class ValveMode(IntEnum):
    """What is done with the valves."""

    CENTRE = 0  # air off, all centred
    HOLD = 1  # air on; the controllers hold the joints
    FOLLOW = 2  # air on; the controllers follow the demands
    VENT_JOINT = 3  # air off; faulty joints open to one end, the others centred
    VENT = 4  # air off; all open to one end


AIR = [act in {ValveMode.HOLD, ValveMode.FOLLOW} for act in ValveMode]  # whether the dump valve lets air in, by act
