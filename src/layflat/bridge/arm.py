"""A machine's arm in MuJoCo, and in files: the rigid bodies that our own laws (physics/arms) have."""

import os
import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from layflat import extras
from layflat.bridge.meshes import Meshes
from layflat.bridge.mjcf import arm_tree, text_of, to_mjcf
from layflat.bridge.pieces import link_pieces
from layflat.bridge.urdf import to_urdf
from layflat.description.wrong import shown
from layflat.errors import InputError, MissingExtraError
from layflat.files import whole_file, write_text
from layflat.machine import Machine, load

FORMATS = {".xml": to_mjcf, ".urdf": to_urdf}
"""Writers by the suffix of a file."""

OLDEST = (4, 0, 1)  # version of MuJoCo: 4.0.0 solves some sparse models wrongly, without a warning


def engine(extra: str = "cell") -> Any:
    """Import the package `mujoco`.

    Raises:
        MissingExtraError: it is not installed, which names the extra, or broken, which says how to repair it.
        InputError: it is too old.
    """
    try:
        mujoco = _imported(extra)
        version = tuple(int(part) for part in re.findall(r"\d+", mujoco.__version__)[:3])
    except (AttributeError, RuntimeError) as error:
        reason = (str(error).splitlines() or [type(error).__name__])[0]
        raise MissingExtraError(extra, ["mujoco-core"], reason=reason, repair=extras.REPAIRS["mujoco"]) from None
    if version < OLDEST:
        needed = ".".join(map(str, OLDEST))
        raise InputError(
            f"MuJoCo is of version {mujoco.__version__}; before {needed} it solves some models wrongly",
            right=f"bring it up to date: {extras.REPAIRS['mujoco']}",
        )
    return mujoco


def _imported(extra: str) -> Any:
    try:
        return extras.module(extra, "mujoco")
    except (
        AttributeError,
        RuntimeError,
    ):  # MUJOCO_GL names what is not there; only pictures need it, see view/picture.py
        before = dict(os.environ)
        os.environ["MUJOCO_GL"] = "disable"
        try:
            return extras.module(extra, "mujoco")
        finally:
            os.environ.clear()
            os.environ.update(before)


@contextmanager
def without_warnings(mj: Any) -> Iterator[None]:
    """Hush what MuJoCo warns of when it compiles a model: on stderr, in a log file, and by warnings of Python."""
    before = mj.get_mju_user_warning()
    mj.set_mju_user_warning(lambda _: None)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        mj.set_mju_user_warning(before)


def arm_spec(machine: Machine, *, passive: bool = False) -> Any:
    """The arm as an MjSpec that can be compiled, changed, or attached to a scene.

    It stands in the frame of the base; a planar one moves in z = 0, x along link 1 in the middle of its stroke. Joints
    bear the machine's names, bodies these names with "-link"; the body "payload" and the site "tip" are at the tip.
    What is drawn touches nothing.

    Args:
        machine: whose arm it is.
        passive: with what `PneumaticJoints` brings along otherwise: stops as limits, bearings as damping, brakes as
            friction loss (which creeps); and painted, with the bodies of the joints.

    Raises:
        InputError: MuJoCo is not installed, the arm is of a kind without bodies, or a mesh is not there.
    """
    mj = engine()
    tree, meshes = arm_tree(load(machine), passive=passive)
    return mj.MjSpec.from_string(text_of(tree), assets=meshes.contents())


def save_arm(machine: str | Path | Machine, path: str | Path) -> list[Path]:
    """Write the arm to a file, .xml (MJCF) or .urdf, and its meshes to a folder beside it; return what was written.

    Raises:
        InputError: another suffix, the arm is of a kind without bodies, or a mesh is not there.
        OutputError: it can't be written there.
    """
    machine = load(machine)
    if not isinstance(path, (str, Path)):
        raise InputError(f"{shown(path)} is no path", where="path", right="give one such as arm.xml or arm.urdf")
    path = Path(path)
    if path.suffix not in FORMATS:
        raise InputError(
            f"{path.name!r} has an unknown format", where="path", right="give a name such as arm.xml or arm.urdf"
        )
    folder = f"{path.stem}-{path.suffix.removeprefix('.')}-meshes"  # not those that the description names
    text = FORMATS[path.suffix](machine, folder)
    meshes = Meshes((piece for own in link_pieces(machine) for piece in own), folder, engine=path.suffix == ".xml")
    written = []
    for name, content in meshes.contents().items():
        with whole_file(path.parent / name) as temporary:
            temporary.write_bytes(content)
        written.append(path.parent / name)
    return [write_text(path, text), *written]
