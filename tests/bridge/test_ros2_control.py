"""Block of ros2_control in a URDF: its joints are those of the arm, its limits those of the machine."""

from math import radians
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, fromstring, tostring

import pytest

from layflat.bridge import save_arm, to_urdf
from layflat.bridge.mjcf import max_filling_velocity
from layflat.bridge.robots import import_arm
from layflat.machine import Machine, load
from tests.physics.arms.chain.chains import as_chain, random_arm

ARM = load("paper-arm")


def split(machine: Machine) -> tuple[Element, Element]:
    """The URDF without its block, and the block."""
    robot = fromstring(to_urdf(machine, ros2_control=True))
    (block,) = robot.findall("ros2_control")
    robot.remove(block)
    return robot, block


@pytest.mark.parametrize("machine", [ARM, as_chain(), random_arm(1, 2), random_arm(7, 3)], ids=["2", "chain", "1", "7"])
def test_interfaces_are_those_of_the_joints(machine: Machine) -> None:
    robot, block = split(machine)
    assert block.get("type") == "system"
    driven = [joint.get("name") for joint in robot.findall("joint") if joint.get("type") == "revolute"]
    assert [joint.get("name") for joint in block.findall("joint")] == driven == list(machine.joints)
    for joint, limit in zip(block.findall("joint"), robot.findall("joint/limit"), strict=False):
        commands = {one.get("name"): one for one in joint.findall("command_interface")}
        assert list(commands) == ["position", "velocity"]
        assert [one.get("name") for one in joint.findall("state_interface")] == ["position", "velocity"]
        for name, command in commands.items():
            lower, upper = (float(str(command.findtext(f"param[@name='{end}']"))) for end in ("min", "max"))
            assert lower == -upper
            assert upper <= float(limit.get("upper" if name == "position" else "velocity", "")) * (1.0 + 1e-5)


def test_limits_are_the_working_stroke_and_the_speed_that_valves_feed() -> None:
    _, block = split(ARM)
    ends = [float(one.text or "") for one in block.findall("joint[@name='large']/command_interface/param[@name='max']")]
    assert ends == [ARM.joints["large"].stops.working_stroke / 2, max_filling_velocity(ARM, "large")]
    assert ends[0] < radians(70.0)


def test_the_rest_stays_and_the_block_is_an_option() -> None:
    robot, block = split(ARM)
    bare = to_urdf(ARM)
    assert "ros2_control" not in bare
    assert [tostring(one).split() for one in fromstring(bare)] == [tostring(one).split() for one in robot]
    assert block.findtext("hardware/plugin") == "joint_state_topic_hardware_interface/JointStateTopicSystem"
    topics = {one.get("name"): one.text for one in block.findall("hardware/param")}
    assert topics == {
        "joint_states_topic": "/layflat/joint_states", "joint_commands_topic": "/layflat/joint_commands"
    }  # fmt: skip


def test_others_read_on(tmp_path: Path) -> None:
    mujoco: Any = pytest.importorskip("mujoco")
    models = [mujoco.MjModel.from_xml_string(to_urdf(ARM, ros2_control=block)) for block in (False, True)]
    assert (models[0].body_inertia == models[1].body_inertia).all()
    save_arm(ARM, tmp_path / "arm.urdf", ros2_control=True)
    imported = import_arm(tmp_path / "arm.urdf")
    assert list(imported.machine.joints) == ["large", "small"]
    assert any("for ros2_control" in note for note in imported.notes())
