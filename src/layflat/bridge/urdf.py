"""A machine's arm as URDF."""

from xml.etree.ElementTree import Element, SubElement, indent, tostring

from layflat.bridge.arm import POINT, bodies, inertia_of
from layflat.machine import Machine, parameters
from layflat.physics.air_balance import REFERENCE_PRESSURE


def to_urdf(machine: Machine) -> str:
    """The arm as URDF: bodies as in `arm_spec`, with limits, friction and damping of the joints.

    `effort` is the greatest torque at supply pressure; `velocity` that at which a fully open valve just keeps a hose at
    supply pressure: conductance x 1 bar / (torque per pressure).
    """
    robot = Element("robot", name=machine.name)
    parent = _link(robot, "base", 0.0, 0.0, None)
    at, turned = 0.0, 0.0
    for name, link, carried in bodies(machine):
        own = _link(robot, f"{name}-link", link.mass, link.centre, inertia_of(link))
        joint = _joint(robot, name, "revolute", parent, own, at, turned)
        SubElement(joint, "axis", xyz="0 0 1")
        _limit(joint, machine, name)
        if carried > 0.0:
            _point(robot, f"{name}-carried", own, link.length, carried)
        parent, at, turned = own, link.length, machine.arm.elbow
    _point(robot, "payload", parent, at, machine.arm.payload)
    indent(robot)
    return '<?xml version="1.0"?>\n' + tostring(robot, encoding="unicode") + "\n"


def _link(robot: Element, name: str, mass: float, at: float, inertia: tuple[float, float, float] | None) -> str:
    link = SubElement(robot, "link", name=name)
    if inertia is not None:
        inertial = SubElement(link, "inertial")
        SubElement(inertial, "origin", xyz=f"{at!r} 0 0", rpy="0 0 0")
        SubElement(inertial, "mass", value=repr(mass))
        i_x, i_y, i_z = (repr(value) for value in inertia)
        SubElement(inertial, "inertia", ixx=i_x, iyy=i_y, izz=i_z, ixy="0", ixz="0", iyz="0")
    return name


def _joint(robot: Element, name: str, kind: str, parent: str, child: str, at: float, turned: float) -> Element:
    joint = SubElement(robot, "joint", name=name, type=kind)
    SubElement(joint, "origin", xyz=f"{at!r} 0 0", rpy=f"0 0 {turned!r}")
    SubElement(joint, "parent", link=parent)
    SubElement(joint, "child", link=child)
    return joint


def _point(robot: Element, name: str, parent: str, at: float, mass: float) -> None:
    own = _link(robot, name, mass, 0.0, (POINT, POINT, POINT))
    _joint(robot, f"{name}-fixed", "fixed", parent, own, at, 0.0)


def _limit(joint: Element, machine: Machine, name: str) -> None:
    described, half = machine.joints[name], machine.joints[name].stops.mechanical_stroke / 2
    valve, *_ = parameters.drive_parts(machine)
    K = parameters.torque_constant(described)
    SubElement(
        joint,
        "limit",
        lower=repr(-half),
        upper=repr(half),
        effort=f"{K * machine.supply.pressure_gauge:.6g}",
        velocity=f"{valve.conductance * REFERENCE_PRESSURE / K:.6g}",
    )
    SubElement(joint, "dynamics", damping=repr(described.brake.viscous), friction=repr(described.brake.torque))
