"""What is tried: a row a fault of the issue's table, with every way in which it can be brought about.

Times count from the instant of the failure; where a failure takes its time to become a fault (a supply that rises, a
joint that is pushed away), from the instant at which a limit is passed in truth.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum
from typing import Any, NamedTuple

import numpy as np

from layflat.rig.far.device import Device
from layflat.rig.far.failures import failure
from layflat.rig.safety.faults import Fault
from layflat.rig.trials.stand import Stand


class Safe(Enum):
    """What has to be reached."""

    TOLD = "told"
    """Nothing but that it is said."""
    HELD = "held"
    """All joints stand still."""
    VENTED = "vented"
    """The hoses of the joint are empty."""
    ALL_VENTED = "all vented"
    """All hoses are empty."""
    OTHERS_VENTED = "others vented"
    """All hoses of the other joints are empty, and this one stands still: its air can't get out."""


class Way(NamedTuple):
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
    begin: Callable[[Stand, int], None]
    end: Callable[[Stand, int], None]
    found: tuple[Fault, ...]
    safe: Safe
    cycles: int = 0
    seconds: float = 0.0
    moving: bool = False
    since: Callable[[Stand, int], bool] | None = None
    """Whether a limit is passed in truth, where the time counts from then on, as long as it is."""
    brief: bool = False
    """Whether it ends by itself when it is found: who pushes a joint lets go of it."""
    way_to_go: float = 0.35
    """A joint that has to be on its way is asked to go at least so far, rad."""
    pushed: bool = False
    """Whether somebody pushes the joint, or a valve that stays open: into its stop, which alone can hold it."""


def inject(device: Device, name: str, joint: int, size: float | None) -> None:
    """Begin a failure; called on the far side."""
    failure(name).begin(device, joint, size)


def heal(device: Device, name: str, joint: int) -> None:
    """End a failure; called on the far side."""
    failure(name).end(device, joint)


def _of_rig(
    name: str, found: tuple[Fault, ...], safe: Safe, *, size: float | None = None, label: str = "", **more: Any
) -> Way:
    """A way that the virtual rig is told to fail; `more` of `Way`."""

    def begin(stand: Stand, joint: int) -> None:
        stand.far.call(inject, name, joint, size)

    def end(stand: Stand, joint: int) -> None:
        stand.far.call(heal, name, joint)

    return Way(label or name, begin, end, found, safe, **more)


def _stale(stand: Stand, _: int) -> None:
    stand.host.silent_since = stand.clock.now()


def _heard(stand: Stand, _: int) -> None:
    stand.host.silent_since = None


def _nonsense(value: float, label: str) -> Way:
    def begin(stand: Stand, joint: int) -> None:
        stand.loop.spoil, stand.loop.spoilt_joint = value, joint

    def end(stand: Stand, _: int) -> None:
        stand.loop.spoil = None

    return Way(label, begin, end, (Fault.BAD_COMMAND,), Safe.HELD, cycles=1)


def _die(stand: Stand, _: int) -> None:
    stand.recorder.dead = True


def _live(stand: Stand, _: int) -> None:
    stand.recorder.dead = False


def _too_high(stand: Stand, _: int) -> bool:
    supply, safety = stand.machine.supply, stand.machine.safety
    return stand.truth.supply > supply.ambient_pressure + safety.overpressure * supply.pressure_gauge


def _away(stand: Stand, joint: int) -> bool:
    safety, stops = stand.machine.safety, list(stand.machine.joints.values())[joint].stops
    stroke = 0.5 * (stops.working_stroke + safety.overrun * (stops.mechanical_stroke - stops.working_stroke))
    return abs(stand.truth.velocities[joint]) > safety.speed or abs(stand.truth.angles[joint]) > stroke


def _push_out(stand: Stand, joint: int) -> None:
    stand.far.call(inject, "push", joint, PUSH if stand.truth.angles[joint] > 0.0 else -PUSH)


def _let_go(stand: Stand, joint: int) -> None:
    stand.far.call(heal, "push", joint)


def _left_behind(stand: Stand, joint: int) -> bool:
    limits, speed = stand.limits[joint], abs(stand.truth.velocities[joint])
    allowed = limits.following + limits.following_time * speed + stand.lead
    return bool(abs(stand.truth.angles[joint] - stand.reaches[joint]) > allowed)


GRIP = 1.0
"""Of a joint's greatest torque: what holds it back. It slides; one that can't looks as if its sensor were frozen."""

PUSH = 1.2
"""Of a joint's greatest torque: what pushes it out against its controller."""

LINK = (Fault.LINK_LOST, Fault.FAR_CENTRED, Fault.FAR_DUMPED)
SENSOR = (Fault.ANGLE_AT_RAIL, Fault.OUTSIDE_STROKE, Fault.OVER_SPEED)
FROZEN = (Fault.ANGLE_FROZEN, Fault.PRESSURE_FROZEN)
ANSWER = (Fault.NO_ANSWER, Fault.OVER_SPEED, Fault.OUTSIDE_STROKE)
BEYOND = (Fault.OVER_SPEED, Fault.OUTSIDE_STROKE, Fault.OVER_PRESSURE, Fault.NO_ANSWER)

ROWS: dict[str, tuple[Way, ...]] = {
    "reply lost, bad CRC or sequence": (
        _of_rig("reply-lost", LINK, Safe.ALL_VENTED, cycles=3),
        _of_rig("reply-crc", LINK, Safe.ALL_VENTED, cycles=3),
        _of_rig("reply-sequence", LINK, Safe.ALL_VENTED, cycles=3),
        _of_rig("silence", LINK, Safe.ALL_VENTED, cycles=3),
        _of_rig("reply-lost", (Fault.REPLY_LOST,), Safe.TOLD, size=1.0, cycles=1, label="one reply lost"),
    ),
    "setpoint stale": (Way("host silent", _stale, _heard, (Fault.SETPOINT_STALE,), Safe.ALL_VENTED, seconds=0.1),),
    "NaN or out-of-range command": (_nonsense(np.nan, "not a number"), _nonsense(25.0, "25 V")),
    "angle sensor open or shorted": (
        _of_rig("angle-open", SENSOR, Safe.VENTED, cycles=3),
        _of_rig("angle-shorted", SENSOR, Safe.VENTED, cycles=3),
    ),
    "sensor frozen": (
        _of_rig("pressure-frozen", (Fault.PRESSURE_FROZEN,), Safe.VENTED, seconds=0.1),
        _of_rig("converter-frozen", (*FROZEN, Fault.NO_ANSWER), Safe.VENTED, seconds=0.1),
        _of_rig("angle-frozen", (*FROZEN, Fault.NO_ANSWER), Safe.VENTED, seconds=0.1, moving=True),
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
        Way("pushed out", _push_out, _let_go, BEYOND, Safe.ALL_VENTED, cycles=2, since=_away, brief=True, pushed=True),
    ),
    "supply lost": (_of_rig("supply-lost", (Fault.SUPPLY_LOST,), Safe.ALL_VENTED, seconds=0.1),),
    "recorder dead": (Way("recorder dead", _die, _live, (Fault.RECORDER_DEAD,), Safe.TOLD, seconds=1.0),),
    "e-stop input": (_of_rig("e-stop", (Fault.E_STOP,), Safe.ALL_VENTED, cycles=1),),
}
