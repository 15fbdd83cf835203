"""Topics of an arm: channels of Foxglove's SDK, and the messages that rows of signals become.

| topic | schema | |
|---|---|---|
| /joint_states | foxglove.JointStates | angle and velocity of all joints, rad and rad/s |
| /tf | foxglove.FrameTransforms | frames of the arm's links |
| /scene | foxglove.SceneUpdate | solids of the links, once for each viewer |
| /joint/NAME | layflat.Joint, JSON | all signals of a joint, SI, absolute pressures |
| /machine | layflat.Machine, JSON | signals that are not of a joint: supply, state, fault, tip ... |
| /events | foxglove.Log | faults, changes of state, messages |
"""

from collections.abc import Mapping, Sequence
from math import isfinite
from typing import Any

import numpy as np

from layflat import extras
from layflat.arrays import Array
from layflat.foxglove.arm import ArmMessages
from layflat.machine import Machine
from layflat.physics.arms import ARM_KINDS

ANGLE_SIGNALS = ("angle", "measured_angle")  # positions of joints: the first one that a log has
VELOCITY_SIGNALS = ("velocity", "averaged_velocity")
LOG_LEVELS = {10: "Debug", 20: "Info", 30: "Warning", 40: "Error", 50: "Fatal"}  # by those of rcl_interfaces/msg/Log
SCENE_TOPIC = "/scene"


class ArmTopics:
    """Topics of one arm in a context of Foxglove's SDK, whose sinks are files and servers.

    Args:
        context: context of the SDK.
        joints: names of the joints, from base to tip.
        by_joint: unit and meaning of the signals of every joint, by name.
        shared: unit and meaning of the other signals.
        parts: names of the parts of those of them that have several, such as the axes of the tip.
        machine: machine whose arm is shown in space; None: none is.

    Raises:
        InputError: a mesh of the arm is missing or can't be read.
        MissingExtraError: Foxglove's SDK is not installed, or a mesh needs a package to be converted.
    """

    def __init__(
        self,
        context: Any,
        joints: Sequence[str],
        by_joint: Mapping[str, tuple[str, str]],
        shared: Mapping[str, tuple[str, str]],
        parts: Mapping[str, Sequence[str]],
        machine: Machine | None,
    ) -> None:
        sdk = extras.import_extra("foxglove", "foxglove")
        channels = extras.import_extra("foxglove", "foxglove.channels")
        self._messages = extras.import_extra("foxglove", "foxglove.messages")
        self._joints, self._by_joint, self._shared, self._parts = tuple(joints), tuple(by_joint), tuple(shared), parts
        self._angle, self._velocity = (
            next((name for name in names if name in by_joint), "") for names in (ANGLE_SIGNALS, VELOCITY_SIGNALS)
        )
        self._events = channels.LogChannel("/events", context=context)
        schema = _json_schema("layflat.Joint", by_joint, {})
        self._channels = [sdk.Channel(f"/joint/{name}", schema=schema, context=context) for name in joints]
        schema = _json_schema("layflat.Machine", shared, parts)
        self._machine = sdk.Channel("/machine", schema=schema, context=context) if shared else None
        self._states: Any = None
        self._frames: Any = None
        self._scene: Any = None
        if self._angle:
            self._states = channels.JointStatesChannel("/joint_states", context=context)
        has_bodies = machine is not None and ARM_KINDS.named(machine.arm.kind).bodies is not None
        self._arm = ArmMessages(machine) if machine and has_bodies and self._angle else None
        if self._arm is not None:
            self._frames = channels.FrameTransformsChannel("/tf", context=context)
            self._scene = channels.SceneUpdateChannel(SCENE_TOPIC, context=context)

    @property
    def shows_arm(self) -> bool:
        """True if the arm is shown in space."""
        return self._arm is not None

    def close(self) -> None:
        """Withdraw all topics."""
        for channel in (self._events, *self._channels, self._machine, self._states, self._frames, self._scene):
            if channel is not None:
                channel.close()

    def log_row(self, stamp: int, row: Mapping[str, Any]) -> None:
        """Log the signals of one instant on all topics that somebody reads; numbers that are not finite are left out.

        Args:
            stamp: instant, ns.
            row: signals by name: numbers, arrays by joint, (joints,), or by their parts.
        """
        if self._arm is not None and self._frames.has_sinks() and np.isfinite(row[self._angle]).all():
            self._frames.log(self._arm.transforms(stamp, row[self._angle]), log_time=stamp)
        if self._states is not None and self._states.has_sinks():
            self._states.log(self._joint_states(stamp, row), log_time=stamp)
        for joint, channel in enumerate(self._channels):
            if channel.has_sinks():
                channel.log(_finite({name: row[name][joint] for name in self._by_joint}), log_time=stamp)
        if self._machine is not None and self._machine.has_sinks():
            self._machine.log(self._shared_message(row), log_time=stamp)

    def log_scene(self, stamp: int) -> None:
        """Log the solids of the arm at an instant, ns; nothing without an arm."""
        if self._arm is not None:
            self._scene.log(self._arm.scene(stamp), log_time=stamp)

    def log_event(self, stamp: int, level: int, text: str) -> None:
        """Log an event.

        Args:
            stamp: instant, ns.
            level: as of rcl_interfaces/msg/Log.
            text: for people.
        """
        m = self._messages
        message = m.Log(
            timestamp=m.Timestamp(*divmod(stamp, 1_000_000_000)),
            level=getattr(m.LogLevel, LOG_LEVELS.get(level, "Unknown")),
            message=text,
            name="layflat",
        )
        self._events.log(message, log_time=stamp)

    def _joint_states(self, stamp: int, row: Mapping[str, Any]) -> Any:
        """Return angles and velocities as foxglove.JointStates; those that are not finite are left out."""
        m, nothing = self._messages, [None] * len(self._joints)
        positions, velocities = (
            [value if isfinite(value) else None for value in row[name].tolist()] if name else nothing
            for name in (self._angle, self._velocity)
        )
        joints = [
            m.JointState(name=name, position=position, velocity=velocity)
            for name, position, velocity in zip(self._joints, positions, velocities, strict=True)
        ]
        return m.JointStates(timestamp=m.Timestamp(*divmod(stamp, 1_000_000_000)), joints=joints)

    def _shared_message(self, row: Mapping[str, Any]) -> dict[str, Any]:
        """Return the signals that are not of a joint, those of several parts as an object."""
        whole = {name: row[name] for name in self._shared if name not in self._parts}
        nested = {name: _finite(dict(zip(parts, row[name], strict=True))) for name, parts in self._parts.items()}
        return _finite(whole) | nested


def _finite(values: Mapping[str, float | Array]) -> dict[str, float]:
    """Return finite numbers as floats: JSON has no others, but the SDK would write them."""
    return {name: float(value) for name, value in values.items() if isfinite(value)}


def _json_schema(
    title: str, meanings: Mapping[str, tuple[str, str]], parts: Mapping[str, Sequence[str]]
) -> dict[str, Any]:
    """Return the JSON schema of a message with a number for each signal, or one for each of its parts."""
    properties: dict[str, Any] = {}
    for name, (unit, meaning) in meanings.items():
        number = {"type": "number", "description": f"{unit}: {meaning}"}
        within = dict.fromkeys(parts.get(name, ()), number)
        properties[name] = {"type": "object", "properties": within} if within else number
    return {"title": title, "type": "object", "properties": properties}
