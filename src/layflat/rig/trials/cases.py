"""Cases of the trials: a row for each fault of the table in docs/rig-faults.md, with every way to cause it.

Times count from the instant of the failure; where a failure becomes a fault only later (a supply that rises, a joint
that is pushed away), from the instant at which the true value passes a limit.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from layflat.rig.device.failures import get_failure
from layflat.rig.device.virtual import VirtualDevice
from layflat.rig.safety.detectors.following import allowed_error
from layflat.rig.safety.faults import Fault
from layflat.rig.safety.limits import speed_limit
from layflat.rig.trials.rig import TrialRig

EMPTY_PRESSURE = 0.3e5  # gauge pressure below which a hose is empty, Pa
MAX_SINKING_SPEED = 1.5  # of a joint that is lowered, rad/s
STATIONARY_SPEED = 0.02  # below which a joint is stationary, rad/s

GRIP_TORQUE_RATIO = 1.0  # of a joint's greatest torque, with which a grip slides; one that does not freezes the angle
PUSH_TORQUE_RATIO = 1.2  # of a joint's greatest torque, with which a push overcomes its controller


class SafeState(NamedTuple):
    """Safe state that has to be reached after a failure of a joint."""

    name: str
    is_reached: Callable[[TrialRig, int], bool]


def _is_vented(rig: TrialRig, joint: int) -> bool:
    """Return whether a joint has no air: its fuller hose is below `EMPTY_PRESSURE`, gauge.

    An arm that would fall is lowered: there the pressure that carries the joint is allowed too, if it sinks slowly.
    """
    empty = rig.truth.pressures[joint] < rig.machine.supply.ambient_pressure + EMPTY_PRESSURE + rig.carries[joint]
    return bool(empty) and (not rig.carries.any() or abs(rig.truth.velocities[joint]) < MAX_SINKING_SPEED)


def _is_stationary(rig: TrialRig, joint: int) -> bool:
    return abs(rig.truth.velocities[joint]) < STATIONARY_SPEED


def _are_others_vented(rig: TrialRig, joint: int) -> bool:
    return all(_is_vented(rig, j) for j in range(len(rig.machine.joints)) if j != joint)


REPORTED_STATE = SafeState("told", lambda *_: True)
HELD_STATE = SafeState("held", lambda rig, _: all(_is_stationary(rig, j) for j in range(len(rig.machine.joints))))
VENTED_STATE = SafeState("vented", _is_vented)
ALL_VENTED_STATE = SafeState("all vented", lambda rig, joint: _is_vented(rig, joint) and _are_others_vented(rig, joint))
# The air of the joint itself can't get out.
OTHERS_VENTED_STATE = SafeState(
    "others vented", lambda rig, joint: _is_stationary(rig, joint) and _are_others_vented(rig, joint)
)


class FaultCase(NamedTuple):
    """Way to cause a fault, with its required detection and reaction."""

    name: str  # for people
    switch: Callable[[TrialRig, int, bool], object]  # causes it in a joint (True), or heals it (False), now
    detectable_as: tuple[Fault, ...]  # faults as which it may be detected
    safe: SafeState
    cycles: int = 0  # limit of the detection time in control cycles, or
    seconds: float = 0.0  # in seconds
    moving: bool = False  # whether the joint has to be moving: at rest the failure has no effect
    since: Callable[[TrialRig, int], bool] | None = (
        None  # True while a true value is past a limit: time counts from then
    )
    brief: bool = False  # whether it ends once it is detected: a person who pushes a joint lets go
    min_motion: float = 0.35  # least length of the motion of a joint that has to be moving, rad
    min_remaining: float = 0.0  # least distance from its demand at the failure, rad
    # Whether a person, a valve that stays open, or a hose that a small valve empties too slowly, pushes the joint into
    # its stop, which alone holds it.
    pushed: bool = False


def set_failure(device: VirtualDevice, name: str, joint: int, on: bool, size: float | None = None) -> None:
    """Inject a failure, or heal it; called on the device.

    Args:
        device: the device.
        name: name of the failure.
        joint: number of the joint.
        on: whether to inject it; else it is healed.
        size: size, as of `Failure.inject`.
    """
    if on:
        get_failure(name).inject(device, joint, size)
    else:
        get_failure(name).heal(device, joint)


def _rig_case(
    name: str, faults: tuple[Fault, ...], safe: SafeState, *, size: float | None = None, label: str = "", **more: Any
) -> FaultCase:
    """Return the case of a failure of the virtual rig; `more` are fields of `FaultCase`."""
    return FaultCase(
        label or name, lambda rig, joint, on: rig.device.call(set_failure, name, joint, on, size), faults, safe, **more
    )


def _silence_host(rig: TrialRig, _: int, on: bool) -> None:
    rig.host.silent_since = rig.clock.now() if on else None


def _kill_recorder(rig: TrialRig, _: int, on: bool) -> None:
    rig.recorder.dead = on


def _bad_voltage_case(value: float, label: str) -> FaultCase:
    """Return the case of a control law that commands an invalid voltage, `value` in V, in one joint."""

    def switch(rig: TrialRig, joint: int, on: bool) -> None:
        core = rig.supervisor.core
        core.between = (lambda: core.law_voltages.__setitem__(joint, value)) if on else None

    return FaultCase(label, switch, (Fault.BAD_COMMAND,), HELD_STATE, cycles=1)


def _push_out(rig: TrialRig, joint: int, on: bool) -> None:
    """Push a joint away from mid-stroke, or let go."""
    rig.device.call(
        set_failure, "push", joint, on, PUSH_TORQUE_RATIO if rig.truth.angles[joint] > 0.0 else -PUSH_TORQUE_RATIO
    )


def _is_supply_too_high(rig: TrialRig, _: int) -> bool:
    """Return whether the supply's true pressure exceeds `safety.overpressure`."""
    supply, safety = rig.machine.supply, rig.machine.safety
    return rig.truth.supply > supply.ambient_pressure + safety.overpressure * supply.pressure_gauge


def _is_out_of_bounds(rig: TrialRig, joint: int) -> bool:
    """Return whether a joint's true velocity or angle exceeds the limits at which a fault is detected."""
    name, (safety, joints) = list(rig.machine.joints)[joint], (rig.machine.safety, rig.machine.joint)
    stops = joints[name].stops
    stroke = 0.5 * (stops.working_stroke + safety.overrun * (stops.mechanical_stroke - stops.working_stroke))
    return abs(rig.truth.velocities[joint]) > speed_limit(rig.machine, name) or abs(rig.truth.angles[joint]) > stroke


def _is_left_behind(rig: TrialRig, joint: int) -> bool:
    """Return whether a joint's true angle is farther from its expected angle than `allowed_error`."""
    limit = allowed_error(rig.following[joint], rig.truth.velocities[joint], rig.supervisor.core.max_lead)
    return bool(abs(rig.truth.angles[joint] - rig.reaches[joint]) > limit)


LINK_FAULTS = (Fault.LINK_LOST, Fault.DEVICE_CENTRED, Fault.DEVICE_DUMPED)
SENSOR_FAULTS = (Fault.ANGLE_AT_RAIL, Fault.OUTSIDE_STROKE, Fault.OVER_SPEED)
FROZEN_FAULTS = (Fault.ANGLE_FROZEN, Fault.PRESSURE_FROZEN)
# A joint that stops at once may drive another out of its stroke before it is detected that it is held back itself.
HELD_BACK_FAULTS = (Fault.FOLLOWING_ERROR, Fault.ANGLE_FROZEN, Fault.OUTSIDE_STROKE)
VALVE_FAULTS = (Fault.VALVE_UNRESPONSIVE, Fault.OVER_SPEED, Fault.OUTSIDE_STROKE)
BOUND_FAULTS = (Fault.OVER_SPEED, Fault.OUTSIDE_STROKE, Fault.OVER_PRESSURE, Fault.VALVE_UNRESPONSIVE)

HOST_GONE = "host dead, frozen or late"  # in this row the loop itself is stopped: the device has to detect it

FAULT_CASES: dict[str, tuple[FaultCase, ...]] = {
    HOST_GONE: (FaultCase("late host", lambda *_: None, LINK_FAULTS[1:], ALL_VENTED_STATE, cycles=4),),
    "reply lost, bad CRC or sequence": (
        *(_rig_case(f"reply-{what}", LINK_FAULTS, ALL_VENTED_STATE, cycles=3) for what in ("lost", "crc", "sequence")),
        _rig_case("silence", LINK_FAULTS, ALL_VENTED_STATE, cycles=3),
        _rig_case("reply-lost", (Fault.REPLY_LOST,), REPORTED_STATE, size=1.0, cycles=1, label="one reply lost"),
    ),
    "setpoint stale": (
        FaultCase("host silent", _silence_host, (Fault.SETPOINT_STALE,), ALL_VENTED_STATE, seconds=0.1),
    ),
    "NaN or out-of-range command": (_bad_voltage_case(np.nan, "not a number"), _bad_voltage_case(25.0, "25 V")),
    "angle sensor open or shorted": (
        _rig_case("angle-open", SENSOR_FAULTS, VENTED_STATE, cycles=3),
        _rig_case("angle-shorted", SENSOR_FAULTS, VENTED_STATE, cycles=3),
    ),
    "sensor frozen": (
        _rig_case("pressure-frozen", (Fault.PRESSURE_FROZEN,), VENTED_STATE, seconds=0.1),
        _rig_case("converter-frozen", (*FROZEN_FAULTS, Fault.VALVE_UNRESPONSIVE), VENTED_STATE, seconds=0.1),
        _rig_case("angle-frozen", (*FROZEN_FAULTS, Fault.VALVE_UNRESPONSIVE), VENTED_STATE, seconds=0.1, moving=True),
    ),
    "following error": (
        _rig_case(
            "grip", HELD_BACK_FAULTS, HELD_STATE, size=GRIP_TORQUE_RATIO, seconds=0.1, moving=True,
            since=_is_left_behind, brief=True, min_motion=0.9, min_remaining=0.35,
        ),
    ),
    "valve driven, pressure does not answer": (
        _rig_case("stuck-spool", VALVE_FAULTS, ALL_VENTED_STATE, seconds=0.2, moving=True, pushed=True),
        _rig_case("burst-hose", VALVE_FAULTS, ALL_VENTED_STATE, seconds=0.2, pushed=True),
        _rig_case("kinked-hose", (*VALVE_FAULTS, Fault.ANGLE_FROZEN), OTHERS_VENTED_STATE, seconds=0.2, moving=True),
    ),
    "over-pressure, over-speed, outside the stroke": (
        _rig_case("supply-high", (Fault.OVER_PRESSURE,), ALL_VENTED_STATE, cycles=2, since=_is_supply_too_high),
        FaultCase(
            "pushed out", _push_out, BOUND_FAULTS, ALL_VENTED_STATE, cycles=2, since=_is_out_of_bounds, brief=True,
            pushed=True,
        ),
    ),
    "supply lost": (_rig_case("supply-lost", (Fault.SUPPLY_LOST,), ALL_VENTED_STATE, seconds=0.1),),
    "recorder dead": (FaultCase("recorder dead", _kill_recorder, (Fault.RECORDER_DEAD,), REPORTED_STATE, seconds=1.0),),
    "e-stop input": (_rig_case("e-stop", (Fault.E_STOP,), ALL_VENTED_STATE, cycles=1),),
}  # fmt: skip
