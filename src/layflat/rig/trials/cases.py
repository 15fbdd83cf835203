"""What is tried: a row a fault of the issue's table, with every way in which it can be brought about.

Times count from the instant of the failure; where a failure takes its time to become a fault (a supply that rises, a
joint that is pushed away), from the instant at which a limit is passed in truth.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from layflat.rig.device.failures import failure
from layflat.rig.device.virtual import VirtualDevice
from layflat.rig.safety.detectors.following import allowed
from layflat.rig.safety.faults import Fault
from layflat.rig.safety.limits import speed_limit
from layflat.rig.trials.rig import TrialRig

EMPTY = 0.3e5  # gauge pressure below which a hose is empty, Pa
SINKING = 1.5  # speed up to which a joint is let down, rad/s
STILL = 0.02  # speed below which a joint stands still, rad/s

GRIP = 1.0  # of a joint's greatest torque: what holds it back; it slides: one that can't looks like a frozen sensor
PUSH = 1.2  # of a joint's greatest torque: what pushes it out against its controller


class Safe(NamedTuple):
    """What has to be reached, and whether it is where a joint has failed."""

    name: str
    is_reached: Callable[[TrialRig, int], bool]


def _vented(rig: TrialRig, joint: int) -> bool:
    # An arm that would fall is let down: its hoses do no more than carry it.
    empty = rig.truth.pressures[joint] < rig.machine.supply.ambient_pressure + EMPTY + rig.carries[joint]
    return bool(empty) and (not rig.carries.any() or abs(rig.truth.velocities[joint]) < SINKING)


def _still(rig: TrialRig, joint: int) -> bool:
    return abs(rig.truth.velocities[joint]) < STILL


def _others_vented(rig: TrialRig, joint: int) -> bool:
    return all(_vented(rig, j) for j in range(len(rig.machine.joints)) if j != joint)


TOLD = Safe("told", lambda *_: True)
HELD = Safe("held", lambda rig, _: all(_still(rig, j) for j in range(len(rig.machine.joints))))
VENTED = Safe("vented", _vented)
ALL_VENTED = Safe("all vented", lambda rig, joint: _vented(rig, joint) and _others_vented(rig, joint))
# The air of the joint itself can't get out.
OTHERS_VENTED = Safe("others vented", lambda rig, joint: _still(rig, joint) and _others_vented(rig, joint))


class FaultCase(NamedTuple):
    """One way to bring a fault about."""

    name: str  # for people
    switch: Callable[[TrialRig, int, bool], object]  # makes it happen to a joint, or mends it, now
    found: tuple[Fault, ...]  # faults by which it may be found
    safe: Safe
    cycles: int = 0  # within so many control cycles it has to be found, or
    seconds: float = 0.0  # within so long
    moving: bool = False  # whether the joint has to be on its way: at rest there is nothing to be seen of it
    since: Callable[[TrialRig, int], bool] | None = None  # where time counts only as long as a limit is passed in truth
    brief: bool = False  # whether it ends by itself when it is found: who pushes a joint lets go of it
    way_to_go: float = 0.35  # a joint that has to be on its way is asked to go at least so far, rad
    way_left: float = 0.0  # and has as much as that before it when it fails, rad
    # Whether somebody, a valve that stays open, or a hose that a small valve empties too slowly, pushes it into its
    # stop, which alone holds it.
    pushed: bool = False


def fail(device: VirtualDevice, name: str, joint: int, on: bool, size: float | None = None) -> None:
    """Begin a failure, or end it; called on the device."""
    if on:
        failure(name).begin(device, joint, size)
    else:
        failure(name).end(device, joint)


def _of_rig(
    name: str, found: tuple[Fault, ...], safe: Safe, *, size: float | None = None, label: str = "", **more: Any
) -> FaultCase:
    """A way that the virtual rig is told to fail; `more` of `FaultCase`."""
    return FaultCase(
        label or name, lambda rig, joint, on: rig.device.call(fail, name, joint, on, size), found, safe, **more
    )


def _silent(rig: TrialRig, _: int, on: bool) -> None:
    rig.host.silent_since = rig.clock.now() if on else None


def _dead(rig: TrialRig, _: int, on: bool) -> None:
    rig.recorder.dead = on


def _nonsense(value: float, label: str) -> FaultCase:
    """The control law asks for a voltage that is none."""

    def switch(rig: TrialRig, joint: int, on: bool) -> None:
        core = rig.supervisor.core
        core.between = (lambda: core.voltages_asked.__setitem__(joint, value)) if on else None

    return FaultCase(label, switch, (Fault.BAD_COMMAND,), HELD, cycles=1)


def _push_out(rig: TrialRig, joint: int, on: bool) -> None:
    rig.device.call(fail, "push", joint, on, PUSH if rig.truth.angles[joint] > 0.0 else -PUSH)


def _too_high(rig: TrialRig, _: int) -> bool:
    supply, safety = rig.machine.supply, rig.machine.safety
    return rig.truth.supply > supply.ambient_pressure + safety.overpressure * supply.pressure_gauge


def _away(rig: TrialRig, joint: int) -> bool:
    name, (safety, joints) = list(rig.machine.joints)[joint], (rig.machine.safety, rig.machine.joint)
    stops = joints[name].stops
    stroke = 0.5 * (stops.working_stroke + safety.overrun * (stops.mechanical_stroke - stops.working_stroke))
    return abs(rig.truth.velocities[joint]) > speed_limit(rig.machine, name) or abs(rig.truth.angles[joint]) > stroke


def _left_behind(rig: TrialRig, joint: int) -> bool:
    most = allowed(rig.following[joint], rig.truth.velocities[joint], rig.supervisor.core.lead)
    return bool(abs(rig.truth.angles[joint] - rig.reaches[joint]) > most)


LINK = (Fault.LINK_LOST, Fault.DEVICE_CENTRED, Fault.DEVICE_DUMPED)
SENSOR = (Fault.ANGLE_AT_RAIL, Fault.OUTSIDE_STROKE, Fault.OVER_SPEED)
FROZEN = (Fault.ANGLE_FROZEN, Fault.PRESSURE_FROZEN)
# A joint that is stopped at once may fling another out of its stroke before it is told that it was held back itself.
HELD_BACK = (Fault.FOLLOWING_ERROR, Fault.ANGLE_FROZEN, Fault.OUTSIDE_STROKE)
ANSWER = (Fault.VALVE_UNRESPONSIVE, Fault.OVER_SPEED, Fault.OUTSIDE_STROKE)
BEYOND = (Fault.OVER_SPEED, Fault.OUTSIDE_STROKE, Fault.OVER_PRESSURE, Fault.VALVE_UNRESPONSIVE)

HOST_GONE = "host dead, frozen or late"  # of this row the loop itself is stopped, and the device alone has to find it

ROWS: dict[str, tuple[FaultCase, ...]] = {
    HOST_GONE: (FaultCase("late host", lambda *_: None, LINK[1:], ALL_VENTED, cycles=4),),
    "reply lost, bad CRC or sequence": (
        *(_of_rig(f"reply-{what}", LINK, ALL_VENTED, cycles=3) for what in ("lost", "crc", "sequence")),
        _of_rig("silence", LINK, ALL_VENTED, cycles=3),
        _of_rig("reply-lost", (Fault.REPLY_LOST,), TOLD, size=1.0, cycles=1, label="one reply lost"),
    ),
    "setpoint stale": (FaultCase("host silent", _silent, (Fault.SETPOINT_STALE,), ALL_VENTED, seconds=0.1),),
    "NaN or out-of-range command": (_nonsense(np.nan, "not a number"), _nonsense(25.0, "25 V")),
    "angle sensor open or shorted": (
        _of_rig("angle-open", SENSOR, VENTED, cycles=3),
        _of_rig("angle-shorted", SENSOR, VENTED, cycles=3),
    ),
    "sensor frozen": (
        _of_rig("pressure-frozen", (Fault.PRESSURE_FROZEN,), VENTED, seconds=0.1),
        _of_rig("converter-frozen", (*FROZEN, Fault.VALVE_UNRESPONSIVE), VENTED, seconds=0.1),
        _of_rig("angle-frozen", (*FROZEN, Fault.VALVE_UNRESPONSIVE), VENTED, seconds=0.1, moving=True),
    ),
    "following error": (
        _of_rig(
            "grip", HELD_BACK, HELD, size=GRIP, seconds=0.1, moving=True,
            since=_left_behind, brief=True, way_to_go=0.9, way_left=0.35,
        ),
    ),
    "valve driven, pressure does not answer": (
        _of_rig("stuck-spool", ANSWER, ALL_VENTED, seconds=0.2, moving=True, pushed=True),
        _of_rig("burst-hose", ANSWER, ALL_VENTED, seconds=0.2, pushed=True),
        _of_rig("kinked-hose", (*ANSWER, Fault.ANGLE_FROZEN), OTHERS_VENTED, seconds=0.2, moving=True),
    ),
    "over-pressure, over-speed, outside the stroke": (
        _of_rig("supply-high", (Fault.OVER_PRESSURE,), ALL_VENTED, cycles=2, since=_too_high),
        FaultCase("pushed out", _push_out, BEYOND, ALL_VENTED, cycles=2, since=_away, brief=True, pushed=True),
    ),
    "supply lost": (_of_rig("supply-lost", (Fault.SUPPLY_LOST,), ALL_VENTED, seconds=0.1),),
    "recorder dead": (FaultCase("recorder dead", _dead, (Fault.RECORDER_DEAD,), TOLD, seconds=1.0),),
    "e-stop input": (_of_rig("e-stop", (Fault.E_STOP,), ALL_VENTED, cycles=1),),
}  # fmt: skip
