"""Messages of ROS 2 about a rig, as rosbridge takes them: fields by name, numbers in SI units."""

from collections.abc import Sequence
from enum import IntEnum
from math import isfinite
from typing import Any

from layflat.arrays import Array
from layflat.rig.record import SHARED_COLUMNS
from layflat.rig.safety.faults import Fault, Reaction, RigState
from layflat.rig.session import RigSnapshot

JOINT_STATE_TYPE = "sensor_msgs/msg/JointState"
PRESSURES_TYPE = "control_msgs/msg/DynamicJointState"
DIAGNOSTICS_TYPE = "diagnostic_msgs/msg/DiagnosticArray"
TRIGGER_TYPE = "std_srvs/srv/Trigger"
TRAJECTORY_TYPE = "control_msgs/action/FollowJointTrajectory"

NS_PER_SECOND = 1_000_000_000  # ns
MAX_CYCLE_AGE = 0.5  # time without a cycle after which diagnostics say so, s
REPORTED_NUMBERS = ("supply", "lateness", "link", "lost")  # shared numbers of a cycle among the diagnostics


class DiagnosticLevel(IntEnum):
    """Level of diagnostic_msgs/msg/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3


def stamp(seconds: float) -> dict[str, int]:
    """Return a time (s since 1970) or a duration (s) as builtin_interfaces/msg/Time or Duration."""
    whole, rest = divmod(round(seconds * NS_PER_SECOND), NS_PER_SECOND)
    return {"sec": whole, "nanosec": rest}


def seconds(value: Any) -> float:
    """Return a Time or Duration in seconds.

    Raises:
        ValueError: it is none.
    """
    if not isinstance(value, dict):
        raise ValueError("is no time")
    parts = value.get("sec", 0), value.get("nanosec", 0)
    if not all(isinstance(part, int) and not isinstance(part, bool) for part in parts):
        raise ValueError("is no time")
    return float(parts[0]) + float(parts[1]) / NS_PER_SECOND


def header(time: float) -> dict[str, Any]:
    """Return a std_msgs/msg/Header of a time of day, s since 1970."""
    return {"stamp": stamp(time), "frame_id": ""}


def joint_state(joints: Sequence[str], shot: RigSnapshot) -> dict[str, Any]:
    """Return sensor_msgs/msg/JointState of a cycle: angles as measured, rad, and averaged velocities, rad/s."""
    return {
        "header": header(float(shot["wall"])),
        "name": list(joints),
        "position": _finite(shot["measured_angle"]),
        "velocity": _finite(shot["averaged_velocity"]),
        "effort": [],
    }


def pressures(joints: Sequence[str], shot: RigSnapshot) -> dict[str, Any]:
    """Return control_msgs/msg/DynamicJointState of a cycle: differential pressures, Pa, and voltages of valves, V."""
    names = ("differential_pressure", "voltage")
    columns = (shot["averaged_pressure"].tolist(), shot["voltage"].tolist())
    return {
        "header": header(float(shot["wall"])),
        "joint_names": list(joints),
        "interface_values": [
            {"interface_names": list(names), "values": _finite(values)} for values in zip(*columns, strict=True)
        ],
    }


def diagnostics(
    machine: str, joints: Sequence[str], shot: RigSnapshot, hardware: str, age: float = 0.0
) -> dict[str, Any]:
    """Return diagnostic_msgs/msg/DiagnosticArray of a cycle: one status of the rig, and one of each faulty joint.

    Args:
        machine: name of the machine.
        joints: names of its joints, from base to tip.
        shot: the cycle.
        hardware: address of the rig.
        age: time for which there was no other cycle, s.
    """
    fault = shot.fault
    values = {"state": shot.state.name.lower(), "fault": fault.title or "none"}
    values |= {f"{name} [{SHARED_COLUMNS[name][0]}]": f"{float(shot[name]):.6g}" for name in REPORTED_NUMBERS}
    text = shot.state.name.lower() + (f": {shot.fault_text}" if fault else "")
    level = _level(shot.state, fault)
    if age > MAX_CYCLE_AGE:
        level, text = DiagnosticLevel.STALE, f"no cycle for {age:.1f} s"
    rig = _status(f"layflat: {machine}", level, text, hardware, values)
    faults = zip(joints, (Fault(int(number)) for number in shot["joint_fault"]), strict=True)
    faulty = [
        _status(f"layflat: {machine}: {joint}", _level(shot.state, own), own.title, hardware)
        for joint, own in faults
        if own
    ]
    return {"header": header(float(shot["wall"])), "status": [rig, *faulty]}


def trajectory_point(
    angles: Sequence[float] | Array, velocities: Sequence[float] | Array | None = None, time: float = 0.0
) -> dict[str, Any]:
    """Return trajectory_msgs/msg/JointTrajectoryPoint.

    Args:
        angles: rad, (joints,).
        velocities: rad/s, (joints,); None: there are none.
        time: since the start of the trajectory, s.
    """
    rates = [] if velocities is None else _finite(velocities)
    fields: dict[str, Any] = {"positions": _finite(angles), "velocities": rates, "accelerations": [], "effort": []}
    return fields | {"time_from_start": stamp(time)}


def _level(state: RigState, fault: Fault) -> DiagnosticLevel:
    """Return the level of a fault: a warning where the rig goes on."""
    if state is RigState.FAULT or (fault and fault.reaction is not Reaction.WARN):
        return DiagnosticLevel.ERROR
    return DiagnosticLevel.WARN if fault else DiagnosticLevel.OK


def _status(
    name: str, level: DiagnosticLevel, message: str, hardware: str, values: dict[str, str] | None = None
) -> dict[str, Any]:
    """Return diagnostic_msgs/msg/DiagnosticStatus."""
    pairs = [{"key": key, "value": value} for key, value in (values or {}).items()]
    return {"level": level, "name": name, "message": message, "hardware_id": hardware, "values": pairs}


def _finite(values: Sequence[float] | Array) -> list[float]:
    """Return numbers as floats, 0 for those that are not finite, which JSON lacks."""
    return [float(value) if isfinite(value) else 0.0 for value in values]
