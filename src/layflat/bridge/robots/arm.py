"""From a file of a robot to a machine with joints of hose, which simulates as it is."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import degrees
from pathlib import Path

import numpy as np

from layflat.arrays import Array
from layflat.bridge.formats import effort
from layflat.bridge.robots.describe import Described, described
from layflat.bridge.robots.held import stand_on
from layflat.bridge.robots.mesh_files import with_meshes
from layflat.bridge.robots.names import machine_name, translated, with_key_names
from layflat.bridge.robots.read import read_robot
from layflat.bridge.robots.serial import Serial, serial
from layflat.bridge.robots.strokes import ROOM, Turning, strokes
from layflat.bridge.robots.template import templates
from layflat.description import units as u
from layflat.description.names import file_name
from layflat.description.wrong import shown
from layflat.errors import InputError
from layflat.files import whole_file, write_text
from layflat.machine import Machine, parameters
from layflat.motion.signal_values import SignalKind, read_row

POSES = 200  # in which gravity's torques are looked at


@dataclass(frozen=True)
class ImportedArm:
    """An arm from a file of a robot.

    Attributes:
        machine: the machine.
        chain: what was taken of the robot.
        turning: how far the joints turn, in the machine's order.
        torques: greatest torque of each joint at supply pressure, N m, (joints,).
        weights: greatest torque of gravity on each joint in many poses of the working strokes, N m, (joints,).
    """

    machine: Machine
    chain: Serial
    turning: tuple[Turning, ...]
    torques: Array
    weights: Array
    text: Described

    def notes(self) -> list[str]:
        """Return what a user should know: what was left out, held still, made shorter, or can't be carried."""
        found = list(self.chain.notes)
        joints = list(self.machine.joints)
        short = [
            f"{name} turns {degrees(turn.mechanical):.4g} of {degrees(turn.asked):.4g} deg"
            for name, turn in zip(joints, self.turning, strict=True)
            if turn.asked > turn.mechanical + ROOM
        ]
        if short:
            found.append(f"hoses reach no further: {', '.join(short)}")
        aside = [
            f"{name} to {degrees(turn.asked):.4g} of {degrees(turn.limits[1] - turn.limits[0]):.4g} deg"
            for name, turn in zip(joints, self.turning, strict=True)
            if turn.limits[1] - turn.limits[0] > turn.asked + ROOM
        ]
        if aside:
            found.append(f"stops lie as far on both sides of the middle of the soft limits: {', '.join(aside)}")
        for name, torque, weight in zip(joints, self.torques, self.weights, strict=True):
            if weight > torque:
                found.append(
                    f"joint {name!r} can't carry the arm: gravity takes up to {weight:.3g} N m, its hoses give "
                    f"{torque:.3g} N m; give it other --joints"
                )
        return found

    def save(self, folder: Path) -> list[Path]:
        """Write NAME.toml and the meshes beside it; return what was written.

        Raises:
            OutputError: it can't be written there.
        """
        written = []
        for name, content in self.text.meshes.items():
            with whole_file(folder / name) as temporary:
                temporary.write_bytes(content if isinstance(content, bytes) else content.read_bytes())
            written.append(folder / name)
        return [write_text(folder / f"{self.machine.name}.toml", self.text.toml), *written]


def import_arm(
    file: str | Path,
    *,
    joints: Sequence[str] = (),
    base: str = "",
    to: str = "",
    tool: str = "",
    name: str = "",
    stroke: Mapping[str, tuple[float, float]] | None = None,
    gravity: Sequence[float] | None = None,
    meshes: bool = True,
    packages: Mapping[str, Path] | None = None,
) -> ImportedArm:
    """Return an arm in space from a URDF or MJCF, with joints of hose.

    Args:
        file: the file.
        joints: which joints of hose: "MACHINE:JOINT" for all, "NAME=MACHINE:JOINT" for one; default: the paper's small
            joint.
        base: body that the arm stands on, which is held still; default: the robot's base.
        to: body that the chain of joints ends at, of a robot with several.
        tool: frame of tip and payload.
        name: of the machine; default: that of the robot.
        stroke: limits of joints in place of the file's, by name, rad.
        gravity: in the frame of the base, m/s2; default: the file's, or 9.80665 m/s2 against z.
        meshes: whether to take meshes along for drawing.
        packages: folders of packages of ROS in which a URDF's meshes are, by name, where they are not around the file.

    Raises:
        InputError: in one line, what is wrong with file or options, and what would be right.
        MissingExtraError: an MJCF, and MuJoCo is not installed.
    """
    _check_types(file, joints, {"base": base, "to": to, "tool": tool, "name": name})
    robot = read_robot(Path(file), meshes=meshes)
    if base:
        robot = stand_on(robot, base)
    if gravity is not None:
        pull = read_row(gravity, SignalKind("gravity", u.ACCELERATION, ("x", "y", "z"), "axis"), np.zeros(3))
        robot = replace(robot, gravity=pull)
    chain, renamed = with_key_names(with_meshes(serial(robot, to=to, tool=tool), packages or {}))
    hoses = templates([stage.joint.name for stage in chain.stages], joints, renamed)
    limits = translated(_limits(stroke or {}), renamed)
    turning = strokes(chain, {joint: one.described for joint, one in hoses.items()}, limits)
    called, notes = (file_name(name, "--name"), ()) if name else machine_name(robot)
    chain = replace(chain, notes=(*chain.notes, *notes))
    text = described(chain, called, hoses, turning)
    machine = text.machine
    torques = np.array([effort(machine, joint) for joint in machine.joints])
    return ImportedArm(machine, chain, tuple(turning), torques, _weights(machine), text)


def _check_types(file: object, joints: object, names: Mapping[str, object]) -> None:
    """Raise InputError if something has another type than it should."""
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
    for name, given in stroke.items():
        ends = read_row(given, SignalKind("stroke", u.ANGLE, ("lower", "upper"), "axis"), np.zeros(2))
        if not ends[0] < ends[1]:
            raise InputError(f"{shown(given)} does not grow", where="stroke", right='give {"wrist": (-1.0, 1.0)}')
        limits[name] = float(ends[0]), float(ends[1])
    return limits


def _weights(machine: Machine) -> Array:
    """Greatest torques of gravity in many poses, the same ones every time."""
    half = np.array([joint.stops.working_stroke / 2 for joint in machine.joints.values()])
    poses = np.random.default_rng(0).uniform(-half, half, (POSES, len(half)))
    arm, payload = parameters.arm(machine), machine.arm.payload
    pulls = [parameters.mass_and_pull(arm, payload, pose.tolist())[1] for pose in poses]
    found: Array = np.abs(pulls).max(axis=0)
    return found
