"""Import of an arm from a robot file as a machine with joints of hose."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import degrees
from pathlib import Path
from typing import TypeVar

import numpy as np

from layflat.arrays import Array
from layflat.bridge.mjcf import max_supply_torque
from layflat.bridge.robots.describe import ArmDescription, describe_arm
from layflat.bridge.robots.held import rebase_robot
from layflat.bridge.robots.hoses import STROKE_TOLERANCE, JointRange, assign_templates, joint_ranges
from layflat.bridge.robots.mesh_files import with_meshes
from layflat.bridge.robots.read import read_robot
from layflat.bridge.robots.robot import Robot
from layflat.bridge.robots.serial import SerialChain, extract_chain
from layflat.description import units as u
from layflat.description.names import file_name, problem, unused_name
from layflat.description.wrong import shown
from layflat.errors import InputError
from layflat.files import whole_file, write_text
from layflat.machine import Machine, parameters
from layflat.motion.signal_values import SignalKind, read_row

Value = TypeVar("Value")
GRAVITY_SAMPLES = 200  # number of random configurations in which torques of gravity are computed


def with_key_names(chain: SerialChain) -> tuple[SerialChain, dict[str, str]]:
    """Return a chain whose joints have unique valid keys as names, with a note, and new names by replaced ones."""
    stages, renamed, taken = [], dict[str, str](), set[str]()
    for stage in chain.stages:
        name = stage.joint.name
        if problem(name, key=True):
            name = "".join(one if one.isalnum() else "-" for one in name).strip("-") or "joint"
        name = unused_name(name, taken.__contains__)
        taken.add(name)
        if name != stage.joint.name:
            renamed[stage.joint.name] = name
        stages.append(replace(stage, joint=replace(stage.joint, name=name)))
    changes = ", ".join(f"{old!r} is {new!r}" for old, new in renamed.items())
    notes = (*chain.notes, f"joints are called otherwise here: {changes}") if renamed else chain.notes
    return replace(chain, stages=tuple(stages), notes=notes), renamed


def translate_names(values: Mapping[str, Value], renamed: Mapping[str, str]) -> dict[str, Value]:
    """Return values by the machine's names of joints, from values by either these or the robot's names.

    Raises:
        InputError: there are values by both names of a joint.
    """
    for old, new in renamed.items():
        if old in values and new in values:
            raise InputError(f"{old!r} and {new!r} are one joint", where="stroke", right="give one of both")
    return {renamed.get(name, name): value for name, value in values.items()}


def machine_name(robot: Robot) -> tuple[str, tuple[str, ...]]:
    """Return a valid name from the robot's name, else its file's, else "arm", and a note, if it differs."""
    for name in (robot.name, robot.file.stem):
        tidy = "".join(one if one.isalnum() or one in "-_+" else "-" for one in name).strip("-_+")
        if tidy and not problem(tidy):
            kept = tidy == (robot.name or robot.file.stem)
            return tidy, () if kept else (f"the machine is called {tidy!r}, the robot {robot.name or name!r}",)
    return "arm", (f"the machine is called 'arm', the robot {robot.name!r}",)


@dataclass(frozen=True)
class ImportedArm:
    """An arm from a file of a robot.

    Attributes:
        machine: the machine.
        chain: chain of joints of the robot.
        turning: ranges of the joints, in the machine's order.
        torques: maximum torque of each joint at supply pressure, N m, (joints,).
        weights: maximum torque of gravity on each joint over the working strokes, N m, (joints,).
        text: description of the machine, with its meshes.
    """

    machine: Machine
    chain: SerialChain
    turning: tuple[JointRange, ...]
    torques: Array
    weights: Array
    text: ArmDescription

    def notes(self) -> list[str]:
        """Return notes on the import: parts left out, joints held or with shorter strokes, and excessive loads."""
        notes = list(self.chain.notes)
        joints = list(self.machine.joints)
        short = [
            f"{name} turns {degrees(turn.mechanical):.4g} of {degrees(turn.allowed_stroke):.4g} deg"
            for name, turn in zip(joints, self.turning, strict=True)
            if turn.allowed_stroke > turn.mechanical + STROKE_TOLERANCE
        ]
        if short:
            notes.append(f"hoses reach no further: {', '.join(short)}")
        excess = [
            f"{name} to {degrees(turn.allowed_stroke):.4g} of {degrees(turn.limits[1] - turn.limits[0]):.4g} deg"
            for name, turn in zip(joints, self.turning, strict=True)
            if turn.limits[1] - turn.limits[0] > turn.allowed_stroke + STROKE_TOLERANCE
        ]
        if excess:
            notes.append(f"stops lie as far on both sides of the middle of the soft limits: {', '.join(excess)}")
        for name, torque, weight in zip(joints, self.torques, self.weights, strict=True):
            if weight > torque:
                notes.append(
                    f"joint {name!r} can't carry the arm: gravity takes up to {weight:.3g} N m, its hoses give "
                    f"{torque:.3g} N m; give it a stronger one"
                )
        return notes

    def save(self, folder: Path) -> list[Path]:
        """Write NAME.toml and the meshes beside it; return the written paths, NAME.toml first.

        Raises:
            OutputError: it can't be written there.
        """
        written = []
        for name, content in self.text.meshes.items():
            with whole_file(folder / name) as temporary:
                temporary.write_bytes(content if isinstance(content, bytes) else content.read_bytes())
            written.append(folder / name)
        return [write_text(folder / f"{self.machine.name}.toml", self.text.toml), *written]


@dataclass(frozen=True)
class ChainEnds:
    """Ends of the chain of joints that is imported from a robot.

    Attributes:
        base: body that the arm stands on, which is held still; default: the robot's base.
        to: body that the chain of joints ends at, of a robot with several.
        tool: frame of tip and payload.
    """

    base: str = ""
    to: str = ""
    tool: str = ""


def import_arm(
    file: str | Path,
    *,
    joints: Sequence[str] = (),
    ends: ChainEnds = ChainEnds(),
    name: str = "",
    stroke: Mapping[str, tuple[float, float]] | None = None,
    gravity: Sequence[float] | None = None,
    meshes: bool = True,
    packages: Mapping[str, Path] | None = None,
) -> ImportedArm:
    """Return an arm in space from a URDF or MJCF, with joints of hose.

    Args:
        file: the file.
        joints: joints of hose: "MACHINE:JOINT" for all, "NAME=MACHINE:JOINT" for one; default: the paper's small
            joint.
        ends: first and last body of the chain of joints that is imported.
        name: name of the machine; default: that of the robot.
        stroke: limits of joints in place of the file's, by name, rad.
        gravity: gravity in the frame of the base, m/s2; default: the file's, or 9.80665 m/s2 against z.
        meshes: whether to import meshes for drawing.
        packages: folders of packages of ROS in which a URDF's meshes are, by name, where they are not around the file.

    Raises:
        InputError: file or arguments are wrong; the message says what would be right.
        MissingExtraError: an MJCF, and MuJoCo is not installed.
    """
    _check_types(file, joints, vars(ends) | {"name": name})
    robot = read_robot(Path(file), meshes=meshes)
    if ends.base:
        robot = rebase_robot(robot, ends.base)
    if gravity is not None:
        pull = read_row(gravity, SignalKind("gravity", u.ACCELERATION, ("x", "y", "z"), "axis"), np.zeros(3))
        robot = replace(robot, gravity=pull)
    chain, renamed = with_key_names(with_meshes(extract_chain(robot, to=ends.to, tool=ends.tool), packages or {}))
    hoses = assign_templates([stage.joint.name for stage in chain.stages], joints, renamed)
    limits = translate_names(_limits(stroke or {}), renamed)
    turning = joint_ranges(chain, {joint: one.described for joint, one in hoses.items()}, limits)
    called, notes = (file_name(name, "name"), ()) if name else machine_name(robot)
    chain = replace(chain, notes=(*chain.notes, *notes))
    text = describe_arm(chain, called, hoses, turning)
    machine = text.machine
    torques = np.array([max_supply_torque(machine, joint) for joint in machine.joints])
    return ImportedArm(machine, chain, tuple(turning), torques, _max_gravity_torques(machine), text)


def _check_types(file: object, joints: object, names: Mapping[str, object]) -> None:
    """Raise InputError unless `file` is a path, `joints` are texts, and each value of `names` is a text."""
    if not isinstance(file, (str, Path)):
        raise InputError(f"{shown(file)} is no path", where="file", right="give that of a URDF or an MJCF")
    texts = isinstance(joints, (list, tuple)) and all(isinstance(joint, str) for joint in joints)
    if not texts:
        raise InputError(f"{shown(joints)} is no list of texts", where="joints", right='give ["MACHINE:JOINT"]')
    odd = next((key for key, value in names.items() if not isinstance(value, str)), None)
    if odd is not None:
        raise InputError(f"{shown(names[odd])} is no text", where=odd, right="give a name")


def _limits(stroke: object) -> dict[str, tuple[float, float]]:
    """Return limits of joints, rad; raise InputError if they are no two growing angles a joint."""
    if not isinstance(stroke, Mapping):
        raise InputError(f"{shown(stroke)} is no table", where="stroke", right='give {"wrist": (-1.0, 1.0)}')
    limits = {}
    for name, pair in stroke.items():
        ends = read_row(pair, SignalKind("stroke", u.ANGLE, ("lower", "upper"), "axis"), np.zeros(2))
        if not ends[0] < ends[1]:
            raise InputError(f"{shown(pair)} does not grow", where="stroke", right='give {"wrist": (-1.0, 1.0)}')
        limits[name] = float(ends[0]), float(ends[1])
    return limits


def _max_gravity_torques(machine: Machine) -> Array:
    """Return the maximum magnitudes of gravity torques, with payload, over random configurations, N m, (joints,)."""
    half = np.array([joint.stops.working_stroke / 2 for joint in machine.joints.values()])
    configurations = np.random.default_rng(0).uniform(-half, half, (GRAVITY_SAMPLES, len(half)))
    arm, payload = parameters.arm(machine), machine.arm.payload
    pulls = [parameters.mass_and_pull(arm, payload, q.tolist())[1] for q in configurations]
    torques: Array = np.abs(pulls).max(axis=0)
    return torques
