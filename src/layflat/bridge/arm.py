"""A machine's arm as a MuJoCo model and in files, with notes on losses of the conversion."""

import os
import re
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from layflat import extras
from layflat.arrays import Array
from layflat.bridge.meshes import Meshes
from layflat.bridge.mjcf import arm_tree, nearest_inertia, to_mjcf, tree_text
from layflat.bridge.pieces import link_pieces, rigid_arm
from layflat.bridge.urdf import to_urdf, unread_meshes
from layflat.description.wrong import shown
from layflat.errors import InputError, MissingExtraError
from layflat.files import whole_file, write_text
from layflat.machine import Machine, load

MIN_MUJOCO_VERSION = (4, 0, 1)  # 4.0.0 solves some sparse models wrongly, without a warning
URDF, MJCF = ".urdf", ".xml"  # suffixes of files
NEGLIGIBLE_INERTIA_CHANGE = 1e-9  # relative change of an inertia that is not reported
DEFAULT_GRAVITY_RANGE = (9.7, 9.9)  # m/s2 against z: default of tools where a file has no gravity


def import_mujoco(extra: str = "cell") -> Any:
    """Import the package `mujoco`, and return it.

    Args:
        extra: extra of layflat that a message advises to install.

    Raises:
        MissingExtraError: it is not installed, or can't be imported; the message has the command that helps.
        InputError: it is older than `MIN_MUJOCO_VERSION`.
    """
    try:
        mujoco = _import_without_gl(extra)
        version = tuple(int(part) for part in re.findall(r"\d+", mujoco.__version__)[:3])
    except (AttributeError, RuntimeError) as error:
        reason = (str(error).splitlines() or [type(error).__name__])[0]
        raise MissingExtraError(
            extra, ["mujoco-core"], reason=reason, repair=extras.REPAIR_COMMANDS["mujoco"]
        ) from None
    if version < MIN_MUJOCO_VERSION:
        needed = ".".join(map(str, MIN_MUJOCO_VERSION))
        raise InputError(
            f"MuJoCo is of version {mujoco.__version__}; before {needed} it solves some models wrongly",
            right=f"bring it up to date: {extras.REPAIR_COMMANDS['mujoco']}",
        )
    return mujoco


def _import_without_gl(extra: str) -> Any:
    """Return the module mujoco, imported without OpenGL only if `MUJOCO_GL` names a missing library."""
    try:
        return extras.import_extra(extra, "mujoco")
    except (AttributeError, RuntimeError):
        # MUJOCO_GL names a missing library; only pictures need it, see view/picture.py.
        before = dict(os.environ)
        os.environ["MUJOCO_GL"] = "disable"
        try:
            return extras.import_extra(extra, "mujoco")
        finally:
            os.environ.clear()
            os.environ.update(before)


@contextmanager
def without_warnings(mj: Any) -> Iterator[None]:
    """Suppress the warnings of MuJoCo's model compiler: on stderr, in a log file, and by Python."""
    before = mj.get_mju_user_warning()
    mj.set_mju_user_warning(lambda _: None)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        mj.set_mju_user_warning(before)


def arm_spec(machine: Machine, *, passive: bool = False) -> Any:
    """Return the arm as an MjSpec that can be compiled, changed, or attached to a scene.

    It is in the frame of the base; a planar one moves in z = 0, x along link 1 in the middle of its stroke. Joints
    have the machine's names, bodies these names with "-link"; the body "payload" and the site "tip" are at the tip.
    Drawn geoms do not collide.

    Args:
        machine: the machine.
        passive: whether to add elements that `PneumaticJoints` models otherwise: stops as limits, torque limits at
            supply pressure, bearings as damping, brakes as friction loss (which creeps), and springs, except those of
            constant torque; and colours and bodies of the joints.

    Raises:
        InputError: MuJoCo is not installed, the arm is of a kind without bodies, or a mesh is not there.
    """
    mj = import_mujoco()
    tree, meshes = arm_tree(load(machine), passive=passive)
    return mj.MjSpec.from_string(tree_text(tree), assets=meshes.contents())


def save_arm(machine: str | Path | Machine, path: str | Path, *, ros2_control: bool = False) -> list[Path]:
    """Write the arm as .xml (MJCF) or .urdf, and meshes to a folder beside it.

    Args:
        machine: the machine.
        path: path of the file.
        ros2_control: whether a URDF has the block by which controllers of ROS 2 drive the joints.

    Returns:
        The paths, that of the arm first.

    Raises:
        InputError: another suffix, the block in MJCF, an arm of a kind without bodies, or a mesh is not there or can't
            be read.
        MissingExtraError: a mesh has to be converted, and the extra is not installed.
        OutputError: it can't be written there.
    """
    machine = load(machine)
    if not isinstance(path, (str, Path)):
        raise InputError(f"{shown(path)} is no path", where="path", right="give one such as arm.xml or arm.urdf")
    path = Path(path)
    if path.suffix not in {URDF, MJCF}:
        raise InputError(
            f"{path.name!r} has an unknown format", where="path", right="give a name such as arm.xml or arm.urdf"
        )
    if ros2_control and path.suffix != URDF:
        raise InputError("is for URDF alone", where="ros2_control", right=f"leave it out, or give {path.stem}.urdf")
    folder = f"{path.stem}-{path.suffix.removeprefix('.')}-meshes"  # not those that the description names
    is_urdf = path.suffix == URDF
    text = to_urdf(machine, folder, ros2_control=ros2_control) if is_urdf else to_mjcf(machine, folder)
    meshes = Meshes((piece for pieces in link_pieces(machine) for piece in pieces), folder, engine=not is_urdf)
    written = []
    for name, content in meshes.contents().items():
        with whole_file(path.parent / name) as temporary:
            temporary.write_bytes(content)
        written.append(path.parent / name)
    return [write_text(path, text), *written]


def conversion_losses(machine: Machine, suffix: str) -> list[str]:
    """Return a line on each property of a machine's arm that a file format can't represent or changes.

    Args:
        machine: the machine.
        suffix: suffix of the file: ".urdf" or ".xml" (MJCF).

    Raises:
        InputError: the arm is of a kind without bodies.
    """
    arm = rigid_arm(machine)
    links = dict(zip(machine.joints, arm.links, strict=True))
    lines = []
    armature = {name: link.armature for name, link in links.items() if link.armature > 0.0}
    if armature and suffix == URDF:
        lines.append(
            f"URDF has no armature, so other tools miss it in the mass matrix: {_list_values(armature, 'kg m2')}; "
            "layflat reads it back from <dynamics>, and MJCF (.xml) carries it"
        )
    springs = {name: joint.spring for name, joint in machine.joints.items() if joint.spring is not None}
    if springs and suffix == URDF:
        lines.append(f"URDF has no springs of joints: {', '.join(springs)}; MJCF (.xml) carries them")
    constant = {name: spring.torque for name, spring in springs.items() if spring.stiffness == 0.0 and spring.torque}
    if constant and suffix == MJCF:
        lines.append(f"MJCF has no spring of constant torque: {_list_values(constant, 'N m')}; apply it as a force")
    if suffix == URDF and not _is_default_gravity(arm.gravity):
        values = " ".join(f"{float(value):.6g}" for value in arm.gravity)
        lines.append(f"URDF has no gravity: MuJoCo reads {values} m/s2 from <mujoco>, other tools have to be told")
    unread = unread_meshes(link_pieces(machine)) if suffix == URDF else []
    if unread:
        lines.append(
            f"MuJoCo draws nothing of this URDF, as it reads no DAE and no flat mesh there: {', '.join(unread)}"
        )
    rounded = {name: _inertia_change(link.inertia) for name, link in links.items()}
    rounded = {name: change for name, change in rounded.items() if change > NEGLIGIBLE_INERTIA_CHANGE}
    if rounded:
        lines.append(
            f"inertia that rounding has made impossible is written as that of the nearest body, as MuJoCo allows no "
            f"other: links of {', '.join(f'{name} ({change:.1g} of it less)' for name, change in rounded.items())}"
        )
    return lines


def _list_values(values: Mapping[str, float], unit: str) -> str:
    return ", ".join(f"{name} {value:.6g} {unit}" for name, value in values.items())


def _is_default_gravity(gravity: Array) -> bool:
    """Return whether gravity (m/s2) is along -z, and as strong as tools assume without one in the file."""
    x, y, z = gravity
    return bool(max(abs(x), abs(y)) < 1e-9 and DEFAULT_GRAVITY_RANGE[0] < -z < DEFAULT_GRAVITY_RANGE[1])


def _inertia_change(inertia: Array) -> float:
    """Return the relative change by `nearest_inertia`: the largest change of an item over the largest item."""
    return float(np.abs(nearest_inertia(inertia) - inertia).max() / np.abs(inertia).max())
