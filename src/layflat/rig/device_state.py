"""State of a rig's device."""

from enum import IntEnum


class DeviceState(IntEnum):
    """State of the device's own watchdog."""

    RUNNING = 0  # it obeys commands
    CENTRED = 1  # no command came for some cycles: the valves are centred
    DUMPED = 2  # none came for longer, or the e-stop is pressed: the air is vented; it obeys again after a `reset`
