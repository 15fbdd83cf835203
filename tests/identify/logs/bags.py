"""Real MCAP files, written by the packages' own writers."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from mcap.writer import Writer
from mcap_ros2.writer import Writer as RosWriter

HEADER = """================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""
JOINT_STATE = (
    f"std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n{HEADER}"
)
PRESSURE = f"std_msgs/Header header\nfloat64 fluid_pressure\nfloat64 variance\n{HEADER}"
VOLTS = "float32[2] data\nbool on\nstring label\n"

DEFINITIONS = {
    "sensor_msgs/msg/JointState": JOINT_STATE,
    "sensor_msgs/msg/FluidPressure": PRESSURE,
    "rig_msgs/msg/Volts": VOLTS,
}

Message = tuple[str, float, str, Mapping[str, Any]]
"""Topic, log time (s), type, content."""


def header(time: float) -> dict[str, Any]:
    return {"stamp": {"sec": int(time), "nanosec": round(1e9 * (time - int(time)))}, "frame_id": "rig"}


def write_ros(path: Path, messages: Sequence[Message], start: int = 0) -> Path:
    """Log times count from `start`, ns."""
    with path.open("wb") as file, RosWriter(file) as writer:
        schemas = {name: writer.register_msgdef(name, text) for name, text in DEFINITIONS.items()}
        for topic, time, kind, content in messages:
            writer.write_message(topic, schemas[kind], content, log_time=start + round(1e9 * time))
    return path


def write_json(path: Path, messages: Sequence[tuple[str, float, Any]], encoding: str = "json") -> Path:
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        schema = writer.register_schema("any", "jsonschema", b"{}")
        channels: dict[str, int] = {}
        for topic, time, content in messages:
            if topic not in channels:
                channels[topic] = writer.register_channel(topic, encoding, schema)
            stamp = round(1e9 * time)
            writer.add_message(channels[topic], stamp, json.dumps(content).encode(), stamp)
        writer.finish()
    return path
