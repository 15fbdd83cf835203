from pathlib import Path
from typing import Any

import numpy as np
import pytest

from layflat.errors import InputError
from layflat.identify.logs import read_log, read_table
from layflat.identify.logs.mapping import parse_mapping
from tests.identify.logs.bags import Message, header, write_json, write_ros

START = 1_700_000_000
"""A rig's clock: seconds since 1970."""


def angle(time: Any) -> Any:
    return 0.3 * np.sin(2.0 * time)


def rig(path: Path) -> Path:
    """Joint states at 100 Hz, a pressure at 40 Hz, and commands now and then."""
    messages: list[Message] = []
    content: dict[str, Any]
    for i in range(301):
        time = 0.01 * i
        state = {"header": header(START + time), "name": ["shoulder", "elbow"], "position": [0.0, angle(time)]}
        content = {**state, "velocity": [], "effort": [1.0, 2.0]}
        messages.append(("/joint_states", time, "sensor_msgs/msg/JointState", content))
    for i in range(121):
        time = 0.025 * i
        content = {"header": header(START + time), "fluid_pressure": 2e5 + 1e4 * time, "variance": 0.0}
        messages.append(("/rig/pressure_a", time, "sensor_msgs/msg/FluidPressure", content))
    for time, volts in ((0.0, 5.0), (1.0, 6.0), (1.7, 4.5)):
        content = {"data": [volts, 5.0], "on": True, "label": "x"}
        messages.append(("/valves", time, "rig_msgs/msg/Volts", content))
    return write_ros(path, sorted(messages, key=lambda message: message[1]), START * 10**9)


def test_messages_are_flattened_by_field_number_and_name(tmp_path: Path) -> None:
    table = read_table(rig(tmp_path / "rig.mcap"))
    assert set(table.columns) == {
        "joint_states.header.stamp", "joint_states.position.shoulder", "joint_states.position.elbow",
        "joint_states.effort.shoulder", "joint_states.effort.elbow", "rig/pressure_a.header.stamp",
        "rig/pressure_a.fluid_pressure", "rig/pressure_a.variance", "valves.data.0", "valves.data.1", "valves.on",
    }  # fmt: skip
    assert table.columns["joint_states.header.stamp"].values[100] == pytest.approx(START + 1.0, abs=1e-6)
    stamps = table.columns["valves.data.0"].stamps
    assert stamps is not None
    assert stamps == pytest.approx([0.0, 1.0, 1.7], abs=1e-9)


def test_messages_at_different_rates_become_one_log(tmp_path: Path) -> None:
    mapping = parse_mapping(
        {
            "column": [
                {"from": "joint_states.position.elbow", "signal": "angle", "joint": "elbow", "unit": "rad"},
                {"from": "rig/pressure_a.fluid_pressure", "signal": "pressure_a", "joint": "elbow", "unit": "Pa",
                 "gauge": False},
                {"from": "valves.data.0", "signal": "voltage", "joint": "elbow", "unit": "V"},
            ]
        }
    )  # fmt: skip
    log = read_log(rig(tmp_path / "rig.mcap"), mapping, joints=["elbow"]).sel(joint="elbow")
    time = log["time"].values
    assert time == pytest.approx(0.01 * np.arange(301), abs=1e-9)
    assert log["angle"].values == pytest.approx(angle(time), abs=1e-12)
    assert log["pressure_a"].values == pytest.approx(2e5 + 1e4 * time, rel=1e-9)
    expected = np.where(time < 1.0 - 1e-9, 5.0, np.where(time < 1.7 - 1e-9, 6.0, 4.5))
    assert np.array_equal(log["voltage"].values, expected)


def test_json_with_nested_names_and_what_is_no_number(tmp_path: Path) -> None:
    fields = {"names": ["x", "y"], "word": "no", "none": None, "ok": True}
    messages: list[tuple[str, float, object]] = [("/image", 0.0, {"data": [0] * 1000})]
    messages += [("/a", 0.1 * i, {**fields, "p": [i, 2 * i], "deep": [{"v": i}]}) for i in range(5)]
    table = read_table(write_json(tmp_path / "j.mcap", messages))
    assert set(table.columns) == {"a.p.x", "a.p.y", "a.deep.0.v", "a.ok"}
    assert np.array_equal(table.columns["a.p.y"].values, 2.0 * np.arange(5))


def test_what_can_not_be_decoded_is_left_out_or_refused(tmp_path: Path) -> None:
    path = write_json(tmp_path / "x.mcap", [("/a", 0.0, 1.0)], encoding="protobuf")
    with pytest.raises(InputError, match=r"no messages with numbers \(a: its messages are in protobuf"):
        read_table(path)


@pytest.mark.parametrize("content", [b"", b"no mcap at all", b"\x89MCAP0\r\n" + bytes(40)])
def test_a_broken_bag_is_refused_in_one_line(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "broken.mcap"
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"MCAP|no messages") as caught:
        read_table(path)
    assert "\n" not in str(caught.value)


def test_a_bag_that_was_cut_off_is_refused_in_one_line(tmp_path: Path) -> None:
    whole = rig(tmp_path / "rig.mcap").read_bytes()
    path = tmp_path / "cut.mcap"
    path.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(InputError, match="can't be read as MCAP") as caught:
        read_table(path)
    assert "\n" not in str(caught.value)
