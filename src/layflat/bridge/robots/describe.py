"""The description of an arm that was read from a file of a robot, with joints of hose in place of its own."""

from collections.abc import Iterator, Mapping
from copy import deepcopy
from dataclasses import dataclass
from math import degrees
from pathlib import Path

import numpy as np

from layflat.arrays import Array
from layflat.bridge.robots.robot import STANDARD, Look
from layflat.bridge.robots.serial import Serial, Stage
from layflat.bridge.robots.strokes import Turning
from layflat.bridge.robots.template import Template
from layflat.description.names import unused_name
from layflat.description.provenance import Provenance
from layflat.description.tables import Plain
from layflat.machine import Machine
from layflat.machine.listing import to_toml
from layflat.machine.model import build
from layflat.physics.arms.bodies import about, turn_of

DIGITS = 15
CYCLE = "5 ms"
AXES = 3  # of the tip: it does not tell of more joints where they are
ANGLE_TOLERANCE = "0.2 deg"  # of such arms


@dataclass(frozen=True)
class Described:
    """The description of an arm."""

    toml: str  # each value with its provenance
    machine: Machine  # that this text describes
    meshes: Mapping[str, Path | bytes]  # files that belong beside it, or what is in them, by their names from there


def described(
    chain: Serial, name: str, hoses: Mapping[str, Template], turning: list[Turning], where: str = ""
) -> Described:
    """Return the description of an arm.

    Args:
        chain: joints and bodies of a robot.
        name: of the machine.
        hoses: joints of hose, by name of the joint; the machine of the first one gives valve, supply and sensors.
        turning: how far the joints turn.
        where: file that it will be written to.

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
    plain["controller"] = {"kind": "tracking", "cycle": CYCLE}
    note = Provenance("derived", "docs/control.md")
    sources |= {"controller.kind": note, "controller.cycle": Provenance("derived", "as the paper's arm")}
    if len(chain.stages) > AXES:
        plain["controller"]["angle_tolerance"] = ANGLE_TOLERANCE
        sources["controller.angle_tolerance"] = Provenance("derived", "its tip does not tell where all joints are")
    meshes: dict[str, Path | bytes] = {}
    plain["arm"] = _arm(chain, turning, _Meshes(f"{name}-meshes", meshes))
    sources |= {f"arm.{path}": Provenance("given", file) for path in _paths(plain["arm"])}
    plain["joint"] = {}
    for joint, turn in zip(hoses, turning, strict=True):
        own, of = hoses[joint].joint()
        own["stops"] |= {"working_stroke": _angle(turn.works), "mechanical_stroke": _angle(turn.mechanical)}
        plain["joint"][joint] = own
        sources |= {f"joint.{joint}.{path}": source for path, source in of.items()}
        text = f"{file}: {degrees(turn.asked):.4g} deg" if turn.asked <= turn.mechanical else "as far as its hoses turn"
        sources |= {
            f"joint.{joint}.stops.{key}": Provenance("given", text) for key in ("working_stroke", "mechanical_stroke")
        }
    return Described(to_toml(plain, sources), build(plain, sources, where or name), meshes)


def _arm(chain: Serial, turning: list[Turning], meshes: "_Meshes") -> Plain:
    gravity = STANDARD if chain.robot.gravity is None else chain.robot.gravity
    links = {stage.joint.name: _link(stage, turn, meshes) for stage, turn in zip(chain.stages, turning, strict=True)}
    return {
        "kind": "chain",
        "joints": [stage.joint.name for stage in chain.stages],
        "bodies": "in links",
        "payload": f"{_number(chain.payload)} kg",
        "tool": _lengths(chain.tool.place),
        "tool_turn": _turn(chain.tool.axes),
        "gravity": [f"{_number(g)} m/s^2" for g in gravity],
        "link": links,
    }


def _link(stage: Stage, turn: Turning, meshes: "_Meshes") -> Plain:
    inertia = stage.inertial.inertia
    six = [*inertia.diagonal(), inertia[0, 1], inertia[0, 2], inertia[1, 2]]
    link = {
        "axis": [float(_number(one)) for one in stage.axis],
        "place": _lengths(stage.place.place),
        "turn": _turn(stage.place.axes @ about(stage.axis, turn.middle - stage.joint.zero)),
        "mass": f"{_number(stage.inertial.mass)} kg",
        "centre": _lengths(stage.inertial.centre),
        "inertia": [f"{_number(one, 1e-12)} kg m^2" for one in six],
        "shapes": [_shape(look, meshes) for look in stage.looks],
    }
    if stage.joint.armature > 0.0:
        link["armature"] = f"{_number(stage.joint.armature, 1e-12)} kg m^2"
    return link


def _shape(look: Look, meshes: "_Meshes") -> Plain:
    shape: Plain = {"kind": look.kind, "place": _lengths(look.pose.place), "turn": _turn(look.pose.axes)}
    if look.file is not None:
        return shape | {"file": meshes.name(look), "scale": [float(_number(one)) for one in look.scale]}
    return shape | {"size": [f"{_number(1e3 * one)} mm" for one in look.size]}


class _Meshes:
    """Names of meshes in a folder beside the description, each file once."""

    def __init__(self, folder: str, found: dict[str, Path | bytes]) -> None:
        self.folder, self.found = folder, found

    def name(self, look: Look) -> str:
        file = look.file
        assert file is not None
        content: Path | bytes = look.content or file.resolve()

        def path(stem: str) -> str:
            return f"{self.folder}/{stem}{file.suffix.lower()}"

        return path(unused_name(file.stem, lambda stem: self.found.setdefault(path(stem), content) != content))


def _number(value: float, least: float = 1e-9) -> str:
    """Return a number as text, with the digits that count; what is less than can be described is zero."""
    return f"{float(value) + 0.0:.{DIGITS}g}" if abs(value) >= least else "0"


def _lengths(place: Array) -> list[str]:
    return [f"{_number(1e3 * one, 1e-6)} mm" for one in place]


def _turn(axes: Array) -> list[str]:
    return [_angle(angle) for angle in turn_of(axes)]


def _angle(angle: float) -> str:
    return f"{_number(np.degrees(angle), 1e-7)} deg"


def _paths(table: Plain, prefix: str = "") -> Iterator[str]:
    for key, value in table.items():
        path = f"{prefix}.{key}" if prefix else key
        if isinstance(value, dict):
            yield from _paths(value, path)
        else:
            yield path
