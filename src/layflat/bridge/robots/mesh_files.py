"""Files of meshes: those that a URDF names, and those of an MJCF where MuJoCo draws a mesh as its file has it."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np

from layflat.arrays import Array
from layflat.bridge.meshes import FORMATS, binary_stl, is_binary_stl, mesh_unit, stl_triangles
from layflat.bridge.robots.robot import Pose, Robot, VisualShape
from layflat.bridge.robots.serial import SerialChain
from layflat.description.text import is_file
from layflat.errors import InputError

IN_PACKAGES = ("package", "model")  # schemes of names that begin with a package of ROS
MAX_NAMED = 4  # places that a message names


def with_meshes(chain: SerialChain, packages: Mapping[str, Path]) -> SerialChain:
    """Return a chain whose links have the files of their meshes, with a note on units other than metres.

    Args:
        chain: as read, with names of meshes.
        packages: folders of packages of ROS, by name.

    Raises:
        InputError: a mesh is not there, or of an unknown format; the message has the searched paths.
    """
    robot = chain.robot
    stages = [
        replace(stage, looks=[_locate_mesh(look, robot, packages) for look in stage.looks]) for stage in chain.stages
    ]
    files = dict.fromkeys(look.file for stage in stages for look in stage.looks if look.file and not look.content)
    units = {file.name: unit for file in files if (unit := mesh_unit(file)) != 1.0}
    listed = ", ".join(f"{name} ({unit:g} m)" for name, unit in units.items())
    note = f"drawn in the units that they declare, which trimesh, Pinocchio and yourdfpy ignore: {listed}"
    return replace(chain, stages=tuple(stages), notes=(*chain.notes, note) if units else chain.notes)


def _locate_mesh(look: VisualShape, robot: Robot, packages: Mapping[str, Path]) -> VisualShape:
    """Return a shape with the path of its named mesh; a shape that names none is returned unchanged.

    Raises:
        InputError: the mesh is not on this computer, in none of the searched places, or of an unknown format.
    """
    if not look.named:
        return look
    where = f"{robot.file}: {robot.noun} {look.body!r}"
    scheme, separator, path = look.named.replace("\\", "/").rpartition("://")
    if separator and scheme not in (*IN_PACKAGES, "file"):
        right = "give a file, or leave meshes out: `meshes=False`"
        raise InputError(f"mesh {look.named!r} is not on this computer", where=where, right=right)
    in_package = scheme in IN_PACKAGES
    tried: list[Path] = []
    for text in dict.fromkeys((path, unquote(path))):
        tried += _package_paths(text, robot, packages) if in_package else _relative_paths(text, robot)
    file = next((one for one in tried if is_file(one)), None)
    if file is None:
        places = [str(one) for one in dict.fromkeys(tried)]
        more = f" and {len(places) - MAX_NAMED} more" if len(places) > MAX_NAMED else ""
        name = Path(path).parts[0] if in_package and path else ""
        right = f"say where package {name} is in `packages`" if name else "put it there"
        raise InputError(
            f"mesh {look.named!r} is not there; looked for {', '.join(places[:MAX_NAMED])}{more}",
            where=where,
            right=f"{right}, or leave meshes out: `meshes=False`",
        )
    if file.suffix.lower() not in FORMATS:
        right = "give STL, OBJ or DAE, or leave meshes out: `meshes=False`"
        raise InputError(f"mesh {look.named!r} is of an unknown format", where=where, right=right)
    return replace(look, file=file, named="")


def _relative_paths(path: str, robot: Robot) -> list[Path]:
    """Return possible paths of a mesh whose name is a path: relative to the file, or in its folder for MuJoCo."""
    folder = robot.file.parent
    places = [folder / path]
    if robot.mesh_folder:
        places += [folder / robot.mesh_folder / path, folder / robot.mesh_folder / Path(path).name]
    return places


def _package_paths(path: str, robot: Robot, packages: Mapping[str, Path]) -> list[Path]:
    """Return possible paths of a mesh whose name begins with a package: in `packages`, else above the robot's file."""
    name, inside = (Path(path).parts or ("",))[0], Path(*Path(path).parts[1:])
    if name in packages:
        return [packages[name] / inside]
    around = robot.file.resolve().parents
    places = [folder / path for folder in around] + [folder / inside for folder in around if folder.name == name]
    return [*places, *_relative_paths(str(inside), robot)]


CORNER_TOLERANCE = 1e-4  # tolerance of corners over a mesh's size: MuJoCo has them in single precision
MAX_CORNERS = 300  # upper limit of compared corners


def mesh_look(spec: Any, model: Any, file: Path, geom: Pose, mesh: int, inner: Pose) -> VisualShape:
    """Return the mesh of a geom as its file with a scale, if that has the same corners; else as a binary STL of them.

    A default, a frame with a scale, a reference pose or another file of the name may stand between a file and what
    MuJoCo draws. So the corners of both are compared.

    Args:
        spec: the model's specification.
        model: the compiled model.
        file: file of the model.
        geom: pose of the geom in its body.
        mesh: index of the mesh in the model.
        inner: pose of the compiled mesh in the frame of its file.
    """
    first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
    corners = model.mesh_vert[first : first + count].astype(float)
    named = model.mesh(mesh).name
    described = spec.mesh(named)
    if described is not None and described.file:
        path = file.parent / spec.meshdir / described.file
        scale: tuple[float, float, float] = tuple(map(float, described.scale))  # type: ignore[assignment]
        in_file = _corners(path)
        if in_file is not None and _are_among(corners @ inner.axes.T + inner.position, in_file * np.array(scale)):
            return VisualShape("mesh", geom.then(inner.back()), file=path, scale=scale)
    faces = model.mesh_face[model.mesh_faceadr[mesh] : model.mesh_faceadr[mesh] + model.mesh_facenum[mesh]]
    return VisualShape("mesh", geom, file=Path(f"{named or f'mesh-{mesh}'}.stl"), content=binary_stl(corners[faces]))


def _corners(path: Path) -> Array | None:
    """Return the corners (n, 3) in a binary STL or an OBJ, in its own unit; None where it can't be read."""
    try:
        content = path.read_bytes()
        if path.suffix.lower() == ".stl" and is_binary_stl(content):
            return stl_triangles(content).reshape(-1, 3)
        if path.suffix.lower() == ".obj":
            lines = [line.split()[1:4] for line in content.splitlines() if line.startswith((b"v ", b"v\t"))]
            return np.array(lines, float).reshape(-1, 3) if lines else None
    except (OSError, ValueError):
        return None
    return None


def _are_among(corners: Array, others: Array) -> bool:
    """Return whether corners (n, 3), of many a sample, coincide with some of others, and both bounding boxes agree."""
    from scipy.spatial import cKDTree  # noqa: PLC0415  # SciPy takes long to import

    tolerance = CORNER_TOLERANCE * float(np.ptp(others, axis=0).max())
    same_box = np.allclose(corners.min(axis=0), others.min(axis=0), rtol=0.0, atol=tolerance) and np.allclose(
        corners.max(axis=0), others.max(axis=0), rtol=0.0, atol=tolerance
    )
    if not same_box:
        return False
    distances, _ = cKDTree(others).query(corners[:: max(len(corners) // MAX_CORNERS, 1)])
    return bool(np.max(distances) <= tolerance)
