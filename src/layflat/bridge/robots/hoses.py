"""Joints of hose that replace a robot's joints, chosen by machine and joint, and their strokes."""

from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from math import degrees
from typing import NamedTuple

from layflat.bridge.robots.robot import RobotLink
from layflat.bridge.robots.serial import SerialChain
from layflat.description.tables import Plain, Sources
from layflat.description.wrong import did_you_mean
from layflat.errors import InputError
from layflat.machine.loader import MACHINE_LIBRARY, load, tables
from layflat.machine.parts import Joint

DEFAULT_HOSE_JOINT = "paper-small-joint-fast:small"  # the paper's small joint, with the larger valve
STROKE_TOLERANCE = 1e-9  # rad
MIN_STROKE = 1e-4  # shorter strokes are refused, rad


@dataclass(frozen=True)
class HoseJointTemplate:
    """Joint of a machine that is used as a template, with the description of the machine."""

    plain: Plain  # of the machine, as written
    sources: Sources
    name: str  # of the joint
    described: Joint
    title: str  # of the machine

    def joint(self) -> tuple[Plain, Sources]:
        """Return values and sources of the joint, without its planar link and gains."""
        start, left_out = f"joint.{self.name}.", ("link", "gains")
        plain = {key: value for key, value in self.plain["joint"][self.name].items() if key not in left_out}
        sources = {path.removeprefix(start): source for path, source in self.sources.items() if path.startswith(start)}
        return deepcopy(plain), {path: source for path, source in sources.items() if path.partition(".")[0] in plain}


def read_template(text: str) -> HoseJointTemplate:
    """Return the joint that a text names as MACHINE:JOINT, MACHINE being a built-in name or a file.

    Raises:
        InputError: there is no such joint, or its machine has no valve or sensors.
        MachineError: the machine's description is wrong.
    """
    machine, colon, joint = text.rpartition(":")
    if not colon or not machine:
        raise InputError(
            f"{text!r} names no joint", where="joints", right=f"give MACHINE:JOINT, such as {DEFAULT_HOSE_JOINT}"
        )
    described = load(machine)
    if joint not in described.joint:
        right = did_you_mean(joint, described.joint, "its joints are {}")
        raise InputError(f"{machine} has no joint {joint!r}", where="joints", right=right)
    if described.valve is None or described.angle_sensor is None or described.pressure_sensor is None:
        raise InputError(
            f"{machine} has no valve or sensors", where="joints", right=f"give a joint such as {DEFAULT_HOSE_JOINT}"
        )
    plain, sources = tables(machine)
    title = machine if machine in MACHINE_LIBRARY.names else described.name
    return HoseJointTemplate(plain, sources, joint, described.joint[joint], title)


def assign_templates(
    names: Sequence[str], choices: Sequence[str], renamed: Mapping[str, str] | None = None
) -> Mapping[str, HoseJointTemplate]:
    """Return the joint of hose for each joint of an arm.

    Args:
        names: the arm's joints.
        choices: "MACHINE:JOINT" for all joints, or "NAME=MACHINE:JOINT" for one of them, which takes precedence.
        renamed: names of joints by alternative names that NAME may have.

    Raises:
        InputError: a joint is not known, or named twice, or its template can't be read.
    """
    general, single = "", dict[str, str]()
    for text in choices:
        name, equals, joint = text.rpartition("=")
        name = (renamed or {}).get(name, name)
        if equals and name not in names:
            raise InputError(f"unknown joint {name!r}", where="joints", right=did_you_mean(name, names, "give {}"))
        if name in single or (not equals and general):
            what = f"there are two for {'joint ' + repr(name) if equals else 'all joints'}"
            other = single[name] if equals else general
            raise InputError(what, where="joints", right=f"give {other} or {joint}")
        if equals:
            single[name] = joint
        else:
            general = joint
    chosen = dict.fromkeys(names, general or DEFAULT_HOSE_JOINT) | single
    by_text = {text: read_template(text) for text in dict.fromkeys(chosen.values())}
    return {name: by_text[text] for name, text in chosen.items()}


class JointRange(NamedTuple):
    """Range of a joint of hose that replaces a robot's joint."""

    middle: float  # position of the robot's joint in mid-stroke, rad
    mechanical: float  # mechanical stroke, rad
    works: float  # working stroke, rad
    allowed_stroke: float  # stroke about that middle that the robot's limits allow, rad
    limits: tuple[float, float]  # of the robot's joint, rad


def joint_ranges(
    chain: SerialChain, hoses: Mapping[str, Joint], limits: Mapping[str, tuple[float, float]]
) -> list[JointRange]:
    """Return the ranges of the joints of a chain: those of the robot, limited to the strokes of the hoses.

    The middle is that of the soft limits of the robot's joint where the file has such, else of its limits.

    Args:
        chain: the robot's joints.
        hoses: joints of hose that replace them, by name.
        limits: limits in place of those of the robot, by name of the joint, rad.

    Raises:
        InputError: a joint has no limits, `limits` exceed the stroke of hoses, or name an unknown joint.
    """
    names = [stage.joint.name for stage in chain.stages]
    for name in limits:
        if name not in names:
            raise InputError(f"unknown joint {name!r}", where="stroke", right=did_you_mean(name, names, "give {}"))
    ranges = []
    for name, stage in zip(names, chain.stages, strict=True):
        stops = hoses[name].stops
        max_stroke, margin = stops.mechanical_stroke, stops.mechanical_stroke - stops.working_stroke
        lower, upper = limits[name] if name in limits else _limits(chain, stage.joint, max_stroke)
        if name in limits and upper - lower > max_stroke + STROKE_TOLERANCE:
            raise InputError(
                f"{degrees(upper - lower):.4g} deg of joint {name!r} are more than its hoses turn",
                where="stroke",
                right=f"give {degrees(max_stroke):.4g} deg at most, or other `joints`",
            )
        soft = None if name in limits else _soft_limits(stage.joint, (lower, upper))
        middle = 0.5 * (lower + upper) if soft is None else 0.5 * (soft[0] + soft[1])
        stroke = upper - lower if soft is None else 2.0 * min(middle - lower, upper - middle)
        mechanical = min(stroke, max_stroke)
        working = mechanical - margin if mechanical > 2.0 * margin else mechanical * stops.working_stroke / max_stroke
        if soft is not None:  # where hoses reach less far, they keep their distance from the stops
            working = min(soft[1] - soft[0], mechanical if mechanical == stroke else working)
        working = min(working, stops.working_stroke)
        ranges.append(JointRange(middle, mechanical, working, stroke, (lower, upper)))
    return ranges


def _limits(chain: SerialChain, joint: RobotLink, max_stroke: float) -> tuple[float, float]:
    """Return a joint's own limits; raise InputError if they are missing or closer than `MIN_STROKE`."""
    if joint.limits is None:
        what = f"joint {joint.name!r} turns without limits"
    elif not joint.limits[1] - joint.limits[0] > MIN_STROKE:
        what = f"joint {joint.name!r} has limits from {joint.limits[0]:g} to {joint.limits[1]:g} rad"
    else:
        return joint.limits
    reach = f"hoses turn {degrees(max_stroke):.4g} deg at most"
    right = f"{reach}: give limits of {joint.name!r} in `stroke`"
    raise InputError(what, where=str(chain.robot.file), right=right)


def _soft_limits(joint: RobotLink, limits: tuple[float, float]) -> tuple[float, float] | None:
    """Return the part of a joint's soft limits within its limits, rad; None if it is not above `MIN_STROKE`."""
    if joint.soft_limits is None:
        return None
    lower, upper = max(joint.soft_limits[0], limits[0]), min(joint.soft_limits[1], limits[1])
    return (lower, upper) if upper - lower > MIN_STROKE else None
