"""Block of ros2_control in a URDF: the hardware that controllers of ROS 2 drive, and the limits of its interfaces."""

from xml.etree.ElementTree import Element, SubElement

from layflat.bridge.mjcf import max_filling_velocity
from layflat.machine import Machine

HARDWARE_PLUGIN = "joint_state_topic_hardware_interface/JointStateTopicSystem"  # of topic_based_hardware_interfaces
JOINT_STATES_TOPIC = "/layflat/joint_states"  # sensor_msgs/JointState, from the rig
JOINT_COMMANDS_TOPIC = "/layflat/joint_commands"  # sensor_msgs/JointState, to the rig


def add_ros2_control(robot: Element, machine: Machine) -> None:
    """Add the block of ros2_control: position and velocity of each joint as commands and states.

    Positions are limited by the working stroke, velocities by the speed that an open valve feeds. The hardware
    exchanges both by topics, as the package `layflat-ros2` does with a rig.

    Args:
        robot: root of the URDF.
        machine: the machine.
    """
    system = SubElement(robot, "ros2_control", name=machine.name, type="system")
    hardware = SubElement(system, "hardware")
    SubElement(hardware, "plugin").text = HARDWARE_PLUGIN
    _add_parameter(hardware, "joint_states_topic", JOINT_STATES_TOPIC)
    _add_parameter(hardware, "joint_commands_topic", JOINT_COMMANDS_TOPIC)
    for name, described in machine.joints.items():
        joint = SubElement(system, "joint", name=name)
        limits = {"position": described.stops.working_stroke / 2, "velocity": max_filling_velocity(machine, name)}
        for quantity, limit in limits.items():
            command = SubElement(joint, "command_interface", name=quantity)
            _add_parameter(command, "min", repr(-float(limit)))
            _add_parameter(command, "max", repr(float(limit)))
        for quantity in limits:
            SubElement(joint, "state_interface", name=quantity)


def _add_parameter(parent: Element, name: str, value: str) -> None:
    SubElement(parent, "param", name=name).text = value
