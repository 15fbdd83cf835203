"""What is tried: a row a fault of the issue's table, with every way in which it can be brought about.

Times count from the instant of the failure; where a failure takes its time to become a fault (a supply that rises, a
joint that is pushed away), from the instant at which a limit is passed in truth.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum
from typing import Any, NamedTuple

import numpy as np

from layflat.rig.device.failures import failure
from layflat.rig.device.virtual import VirtualDevice
from layflat.rig.safety.detectors.following import allowed
from layflat.rig.safety.faults import Fault
from layflat.rig.trials.rig import TrialRig


class Safe(Enum):
    """What has to be reached."""

    TOLD = "told"
    """Nothing but that it is said."""
    HELD = "held"
    """All joints rig still."""
    VENTED = "vented"
    """The hoses of the joint are empty."""
    ALL_VENTED = "all vented"
    """All hoses are empty."""
    OTHERS_VENTED = "others vented"
    """All hoses of the other joints are empty, and this one stands still: its air can't get out."""


class FaultCase(NamedTuple):
    """One way to bring a fault about.

    Args:
        name: for people.
        begin: makes it happen to a joint, now.
        end: mends it.
        found: faults by which it may be found.
        safe: what has to be reached.
        cycles: within so many control cycles, or
        seconds: within so long.
        moving: whether the joint has to be on its way: at rest there is nothing to be seen of it.
    """

    name: str
    begin: Callable[[TrialRig, int], None]
    end: Callable[[TrialRig, int], None]
    found: tuple[Fault, ...]
    safe: Safe
    cycles: int = 0
    seconds: float = 0.0
    moving: bool = False
    since: Callable[[TrialRig, int], bool] | None = None
    """Whether a limit is passed in truth, where the time counts from then on, as long as it is."""
    brief: bool = False
    """Whether it ends by itself when it is found: who pushes a joint lets go of it."""
    way_to_go: float = 0.35
    """A joint that has to be on its way is asked to go at least so far, rad."""
    pushed: bool = False
    """Whether somebody pushes the joint, or a valve that stays open: into its stop, which alone can hold it."""


def inject(device: VirtualDevice, name: str, joint: int, size: float | None) -> None:
    """Begin a failure; called on the device."""
    failure(name).begin(device, joint, size)


def heal(device: VirtualDevice, name: str, joint: int) -> None:
    """End a failure; called on the device."""
    failure(name).end(device, joint)


def _of_rig(
    name: str, found: tuple[Fault, ...], safe: Safe, *, size: float | None = None, label: str = "", **more: Any
) -> FaultCase:
    """A way that the virtual rig is told to fail; `more` of `FaultCase`."""

    def begin(rig: TrialRig, joint: int) -> None:
        rig.device.call(inject, name, joint, size)

    def end(rig: TrialRig, joint: int) -> None:
        rig.device.call(heal, name, joint)

    return FaultCase(label or name, begin, end, found, safe, **more)


def _stale(rig: TrialRig, _: int) -> None:
    rig.host.silent_since = rig.clock.now()


def _heard(rig: TrialRig, _: int) -> None:
    rig.host.silent_since = None


def _nonsense(value: float, label: str) -> FaultCase:
    def begin(rig: TrialRig, joint: int) -> None:
        rig.loop.inject(joint, value)

    def end(rig: TrialRig, joint: int) -> None:
        rig.loop.inject(joint, None)

    return FaultCase(label, begin, end, (Fault.BAD_COMMAND,), Safe.HELD, cycles=1)


def _die(rig: TrialRig, _: int) -> None:
    rig.recorder.dead = True


def _live(rig: TrialRig, _: int) -> None:
    rig.recorder.dead = False


def _too_high(rig: TrialRig, _: int) -> bool:
    supply, safety = rig.machine.supply, rig.machine.safety
    return rig.truth.supply > supply.ambient_pressure + safety.overpressure * supply.pressure_gauge


def _away(rig: TrialRig, joint: int) -> bool:
    safety, stops = rig.machine.safety, list(rig.machine.joints.values())[joint].stops
    stroke = 0.5 * (stops.working_stroke + safety.overrun * (stops.mechanical_stroke - stops.working_stroke))
    return abs(rig.truth.velocities[joint]) > safety.speed or abs(rig.truth.angles[joint]) > stroke


def _push_out(rig: TrialRig, joint: int) -> None:
    rig.device.call(inject, "push", joint, PUSH if rig.truth.angles[joint] > 0.0 else -PUSH)


def _let_go(rig: TrialRig, joint: int) -> None:
    rig.device.call(heal, "push", joint)


def _left_behind(rig: TrialRig, joint: int) -> bool:
    most = allowed(rig.following[joint], rig.truth.velocities[joint], rig.lead)
    return bool(abs(rig.truth.angles[joint] - rig.reaches[joint]) > most)


GRIP = 1.0
"""Of a joint's greatest torque: what holds it back. It slides; one that can't looks as if its sensor were frozen."""

PUSH = 1.2
"""Of a joint's greatest torque: what pushes it out against its controller."""

LINK = (Fault.LINK_LOST, Fault.DEVICE_CENTRED, Fault.DEVICE_DUMPED)
SENSOR = (Fault.ANGLE_AT_RAIL, Fault.OUTSIDE_STROKE, Fault.OVER_SPEED)
FROZEN = (Fault.ANGLE_FROZEN, Fault.PRESSURE_FROZEN)
ANSWER = (Fault.VALVE_UNRESPONSIVE, Fault.OVER_SPEED, Fault.OUTSIDE_STROKE)
BEYOND = (Fault.OVER_SPEED, Fault.OUTSIDE_STROKE, Fault.OVER_PRESSURE, Fault.VALVE_UNRESPONSIVE)

ROWS: dict[str, tuple[FaultCase, ...]] = {
    "reply lost, bad CRC or sequence": (
        _of_rig("reply-lost", LINK, Safe.ALL_VENTED, cycles=3),
        _of_rig("reply-crc", LINK, Safe.ALL_VENTED, cycles=3),
        _of_rig("reply-sequence", LINK, Safe.ALL_VENTED, cycles=3),
        _of_rig("silence", LINK, Safe.ALL_VENTED, cycles=3),
        _of_rig("reply-lost", (Fault.REPLY_LOST,), Safe.TOLD, size=1.0, cycles=1, label="one reply lost"),
    ),
    "setpoint stale": (
        FaultCase("host silent", _stale, _heard, (Fault.SETPOINT_STALE,), Safe.ALL_VENTED, seconds=0.1),
    ),
    "NaN or out-of-range command": (_nonsense(np.nan, "not a number"), _nonsense(25.0, "25 V")),
    "angle sensor open or shorted": (
        _of_rig("angle-open", SENSOR, Safe.VENTED, cycles=3),
        _of_rig("angle-shorted", SENSOR, Safe.VENTED, cycles=3),
    ),
    "sensor frozen": (
        _of_rig("pressure-frozen", (Fault.PRESSURE_FROZEN,), Safe.VENTED, seconds=0.1),
        _of_rig("converter-frozen", (*FROZEN, Fault.VALVE_UNRESPONSIVE), Safe.VENTED, seconds=0.1),
        _of_rig("angle-frozen", (*FROZEN, Fault.VALVE_UNRESPONSIVE), Safe.VENTED, seconds=0.1, moving=True),
    ),
    "following error": (
        _of_rig(
            "grip",
            (Fault.FOLLOWING_ERROR, Fault.ANGLE_FROZEN),
            Safe.HELD,
            size=GRIP,
            seconds=0.1,
            moving=True,
            since=_left_behind,
            brief=True,
            way_to_go=0.9,
        ),
    ),
    "valve driven, pressure does not answer": (
        _of_rig("stuck-spool", ANSWER, Safe.ALL_VENTED, seconds=0.2, moving=True, pushed=True),
        _of_rig("burst-hose", ANSWER, Safe.ALL_VENTED, seconds=0.2),
        _of_rig("kinked-hose", (*ANSWER, Fault.ANGLE_FROZEN), Safe.OTHERS_VENTED, seconds=0.2, moving=True),
    ),
    "over-pressure, over-speed, outside the stroke": (
        _of_rig("supply-high", (Fault.OVER_PRESSURE,), Safe.ALL_VENTED, cycles=2, since=_too_high),
        FaultCase(
            "pushed out", _push_out, _let_go, BEYOND, Safe.ALL_VENTED, cycles=2, since=_away, brief=True, pushed=True
        ),
    ),
    "supply lost": (_of_rig("supply-lost", (Fault.SUPPLY_LOST,), Safe.ALL_VENTED, seconds=0.1),),
    "recorder dead": (FaultCase("recorder dead", _die, _live, (Fault.RECORDER_DEAD,), Safe.TOLD, seconds=1.0),),
    "e-stop input": (_of_rig("e-stop", (Fault.E_STOP,), Safe.ALL_VENTED, cycles=1),),
}
