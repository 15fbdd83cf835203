"""The description of an arm that was read from a file of a robot, with joints of hose in place of its own."""

from collections.abc import Iterator, Mapping
from copy import deepcopy
from dataclasses import dataclass
from math import degrees
from pathlib import Path

import numpy as np

from layflat.arrays import Array
from layflat.bridge.robots.hoses import HoseJointTemplate, JointRange
from layflat.bridge.robots.robot import DEFAULT_GRAVITY, VisualShape
from layflat.bridge.robots.serial import ChainStage, SerialChain
from layflat.description.names import unused_name
from layflat.description.tables import Plain, Provenance
from layflat.machine import Machine
from layflat.machine.listing import to_toml
from layflat.machine.model import build
from layflat.physics.arms.bodies import angles_from_rotation, rotation_about_axis

DIGITS = 15
CONTROL_CYCLE = "5 ms"
TIP_AXES = 3  # coordinates of the tip, which do not determine more joint angles
ANGLE_TOLERANCE = "0.2 deg"  # of arms with more joints than that


@dataclass(frozen=True)
class ArmDescription:
    """Description of an imported arm."""

    toml: str  # text of the description, each value with its source
    machine: Machine  # that this text describes
    meshes: Mapping[str, Path | bytes]  # files beside it, or their contents, by relative path


def describe_arm(
    chain: SerialChain, name: str, hoses: Mapping[str, HoseJointTemplate], turning: list[JointRange]
) -> ArmDescription:
    """Return the description of an arm, with the tracking control law; joint angles are 0 in the middle of their range.

    Args:
        chain: joints and bodies of a robot.
        name: name of the machine.
        hoses: joints of hose, by name of the joint; the machine of the first one gives valve, supply and sensors.
        turning: ranges of the joints.

    Raises:
        MachineError: no machine can be made of it.
    """
    first = next(iter(hoses.values()))
    plain, sources = deepcopy(first.plain), dict(first.sources)
    for key in ("arm", "joint", "controller"):
        plain.pop(key, None)
        sources = {path: source for path, source in sources.items() if path.partition(".")[0] != key}
    file = chain.robot.file.name
    plain |= {"name": name, "title": f"From {file}, with joints of {first.title}"}
    plain["controller"] = {"kind": "tracking", "cycle": CONTROL_CYCLE}
    note = Provenance("derived", "docs/control.md")
    sources |= {"controller.kind": note, "controller.cycle": Provenance("derived", "as the paper's arm")}
    if len(chain.stages) > TIP_AXES:
        plain["controller"]["angle_tolerance"] = ANGLE_TOLERANCE
        sources["controller.angle_tolerance"] = Provenance("derived", "its tip does not tell where all joints are")
    meshes: dict[str, Path | bytes] = {}
    plain["arm"] = _arm_table(chain, turning, _Meshes(f"{name}-meshes", meshes))
    sources |= {f"arm.{path}": Provenance("given", file) for path in _value_paths(plain["arm"])}
    plain["joint"] = {}
    for joint, turn in zip(hoses, turning, strict=True):
        part, part_sources = hoses[joint].joint()
        part["stops"] |= {"working_stroke": _angle(turn.works), "mechanical_stroke": _angle(turn.mechanical)}
        plain["joint"][joint] = part
        sources |= {f"joint.{joint}.{path}": source for path, source in part_sources.items()}
        text = (
            f"{file}: {degrees(turn.allowed_stroke):.4g} deg"
            if turn.allowed_stroke <= turn.mechanical
            else "as far as its hoses turn"
        )
        sources |= {
            f"joint.{joint}.stops.{key}": Provenance("given", text) for key in ("working_stroke", "mechanical_stroke")
        }
    return ArmDescription(to_toml(plain, sources), build(plain, sources, name), meshes)


def _arm_table(chain: SerialChain, turning: list[JointRange], meshes: "_Meshes") -> Plain:
    """Return the table `arm` of a description; joint angles count from the middle of each range."""
    gravity = DEFAULT_GRAVITY if chain.robot.gravity is None else chain.robot.gravity
    links = {
        stage.joint.name: _link_table(stage, turn, meshes) for stage, turn in zip(chain.stages, turning, strict=True)
    }
    return {
        "kind": "chain",
        "joints": [stage.joint.name for stage in chain.stages],
        "bodies": "in links",
        "payload": f"{_number(chain.payload)} kg",
        "tool": _lengths(chain.tool.position),
        "tool_rotation": _turn(chain.tool.axes),
        "gravity": [f"{_number(g)} m/s^2" for g in gravity],
        "link": links,
    }


def _link_table(stage: ChainStage, turn: JointRange, meshes: "_Meshes") -> Plain:
    """Return the table of a link and the joint that moves it, zero at the middle of its range."""
    inertia = stage.inertial.inertia
    six = [*inertia.diagonal(), inertia[0, 1], inertia[0, 2], inertia[1, 2]]
    link = {
        "axis": [float(_number(one)) for one in stage.axis],
        "position": _lengths(stage.pose.position),
        "rotation": _turn(stage.pose.axes @ rotation_about_axis(stage.axis, turn.middle - stage.joint.zero)),
        "mass": f"{_number(stage.inertial.mass)} kg",
        "centre": _lengths(stage.inertial.centre),
        "inertia": [f"{_number(one, 1e-12)} kg m^2" for one in six],
        "shapes": [_shape_table(look, meshes) for look in stage.looks],
    }
    if stage.joint.armature > 0.0:
        link["armature"] = f"{_number(stage.joint.armature, 1e-12)} kg m^2"
    return link


def _shape_table(look: VisualShape, meshes: "_Meshes") -> Plain:
    """Return the table of a shape: primitives with their size in mm, meshes with file and scale."""
    shape: Plain = {"kind": look.kind, "position": _lengths(look.pose.position), "rotation": _turn(look.pose.axes)}
    if look.file is not None:
        return shape | {"file": meshes.name(look), "scale": [float(_number(one)) for one in look.scale]}
    return shape | {"size": [f"{_number(1e3 * one)} mm" for one in look.size]}


class _Meshes:
    """Names of meshes in a folder beside the description, each file once."""

    def __init__(self, folder: str, contents: dict[str, Path | bytes]) -> None:
        self.folder, self.contents = folder, contents

    def name(self, look: VisualShape) -> str:
        """Return the path of a shape's mesh beside the description; one file, or equal `content`, has one name.

        The file is added to `contents`.
        """
        file = look.file
        assert file is not None
        content: Path | bytes = look.content or file.resolve()

        def path(stem: str) -> str:
            return f"{self.folder}/{stem}{file.suffix.lower()}"

        return path(unused_name(file.stem, lambda stem: self.contents.setdefault(path(stem), content) != content))


def _number(value: float, threshold: float = 1e-9) -> str:
    """Return a number as text with `DIGITS` digits; below a threshold it is 0."""
    return f"{float(value) + 0.0:.{DIGITS}g}" if abs(value) >= threshold else "0"


def _lengths(place: Array) -> list[str]:
    return [f"{_number(1e3 * one, 1e-6)} mm" for one in place]


def _turn(axes: Array) -> list[str]:
    return [_angle(angle) for angle in angles_from_rotation(axes)]


def _angle(angle: float) -> str:
    return f"{_number(np.degrees(angle), 1e-7)} deg"


def _value_paths(table: Plain, prefix: str = "") -> Iterator[str]:
    """Yield the dotted paths of all values of nested tables."""
    for key, value in table.items():
        path = f"{prefix}.{key}" if prefix else key
        if isinstance(value, dict):
            yield from _value_paths(value, path)
        else:
            yield path
