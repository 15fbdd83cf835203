"""Meshes of pieces: files beside a model, with unique names, in formats that its readers support."""

import re
from collections.abc import Iterable
from math import inf
from pathlib import Path
from typing import Any

import numpy as np

from layflat import extras
from layflat.arrays import Array
from layflat.bridge.pieces import Piece
from layflat.description.names import unused_name
from layflat.errors import InputError

FORMATS = (".stl", ".obj", ".dae")
UNIT = re.compile(rb"""(<unit\b[^>]*?\bmeter\s*=\s*["'])([^"']*)(["'])""")
OBJ_CORNER = re.compile(rb"(?m)^[ \t]*v[ \t]+(\S+)[ \t]+(\S+)[ \t]+(\S+)")
STL_HEAD = 84  # bytes of a binary STL before its triangles
STL_TRIANGLE = np.dtype([("numbers", "<f4", (4, 3)), ("more", "<u2")])  # in a binary STL: 50 bytes
MIN_CORNERS = 4  # of a mesh that MuJoCo takes
MIN_VOLUME = 1e-13  # of a solid that MuJoCo accepts, m3: it refuses below 1e-15, in single precision


class Meshes:
    """Meshes of an arm, each with a unique name.

    Args:
        pieces: drawn pieces.
        folder: folder of the names, relative to the model.
        engine: whether they are for MuJoCo, which reads OBJ and binary STL only: others are converted.
    """

    def __init__(self, pieces: Iterable[Piece], folder: str, *, engine: bool) -> None:
        """Name the meshes of the pieces, each file once; nothing is read yet."""
        self._engine, self._folder, self._names = engine, folder, dict[Path, str]()
        for piece in pieces:
            if piece.file is not None and piece.file not in self._names:
                self._names[piece.file] = self._unused_path(piece.file)

    def __bool__(self) -> bool:
        """Return whether there are any."""
        return bool(self._names)

    def name(self, file: Path) -> str:
        """Return the unique path, relative to the model, of the mesh file of a piece."""
        return self._names[file]

    def scale(self, piece: Piece) -> tuple[float, float, float]:
        """Return the scale of a piece's mesh as written: its own, times the unit of a DAE that is not converted."""
        if self._engine or piece.file is None:
            return piece.scale  # converted meshes are in metres already
        x, y, z = piece.scale
        unit = mesh_unit(piece.file)
        return (x * unit, y * unit, z * unit)

    def contents(self) -> dict[str, bytes]:
        """Return the content of each file by its name.

        Raises:
            InputError: a mesh can't be read.
            MissingExtraError: a mesh has to be converted, and the extra is not installed.
        """
        return {name: read_mesh(path, engine=self._engine) for path, name in self._names.items()}

    def _unused_path(self, file: Path) -> str:
        """Return an unused path of a mesh in the model's folder; for MuJoCo, all but STL and OBJ become STL."""
        suffix = ".stl" if self._engine and file.suffix.lower() != ".obj" else file.suffix.lower()
        start = f"{self._folder}/" if self._folder else ""
        taken = set(self._names.values())
        return f"{start}{unused_name(file.stem, lambda stem: f'{start}{stem}{suffix}' in taken)}{suffix}"


def read_mesh(file: Path, *, engine: bool) -> bytes:
    """Return the content of a mesh file, for an engine converted to binary STL if it can't read the format.

    Other readers get a DAE that declares metres; MuJoCo gets triangles with at least `MIN_CORNERS` corners.

    Raises:
        InputError: the mesh can't be read, or has corners that are not finite.
        MissingExtraError: it has to be converted, and the extra is not installed.
    """
    try:
        content = file.read_bytes()
    except OSError as error:
        raise InputError(f"can't be read ({error.strerror})", where=str(file), right="give a mesh") from None
    if not engine:
        return declare_metres(content) if file.suffix.lower() == ".dae" else content
    is_obj = file.suffix.lower() == ".obj"
    if is_obj and len(corners := OBJ_CORNER.findall(content)) >= MIN_CORNERS:
        _check_finite(np.array(corners), file)
        return content
    if not is_obj and file.suffix.lower() == ".stl" and is_binary_stl(content):
        triangles = stl_triangles(content)
    else:
        mesh = load_mesh(file)
        triangles = np.asarray(mesh.vertices[mesh.faces], float)
    _check_finite(triangles, file)
    return _obj(_split(triangles)) if is_obj else binary_stl(_split(triangles))


def _check_finite(corners: Any, file: Path) -> None:
    """Raise InputError, naming the file, if coordinates (numbers or their texts) are not finite numbers."""
    try:
        finite = np.isfinite(corners.astype(float)).all()
    except ValueError:
        finite = False
    if not finite:
        raise InputError("has corners that are not finite", where=str(file), right="give another mesh")


def stl_triangles(content: bytes) -> Array:
    """Return the triangles (n, 3 corners, 3) of a binary STL."""
    return np.frombuffer(content, STL_TRIANGLE, offset=STL_HEAD)["numbers"][:, 1:].astype(float)


def binary_stl(triangles: Array, *, normals: bool = False) -> bytes:
    """Return triangles (n, 3 corners, 3) as a binary STL, with their normals or with zeros in their place."""
    rows = np.zeros(len(triangles), STL_TRIANGLE)
    rows["numbers"][:, 1:] = triangles
    if normals:
        across = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        lengths = np.linalg.norm(across, axis=1, keepdims=True)
        rows["numbers"][:, 0] = across / np.where(lengths > 0.0, lengths, 1.0)
    return b"\0" * (STL_HEAD - 4) + len(triangles).to_bytes(4, "little") + rows.tobytes()


def _split(triangles: Array) -> Array:
    """Return triangles with at least `MIN_CORNERS` different corners, split at their middles if necessary."""
    if len(np.unique(triangles.reshape(-1, 3), axis=0)) >= MIN_CORNERS:
        return triangles
    middles = triangles.mean(axis=1)
    parts = [np.stack([triangles[:, i], triangles[:, (i + 1) % 3], middles], axis=1) for i in range(3)]
    return np.concatenate(parts)


def _obj(triangles: Array) -> bytes:
    """Return triangles (n, 3 corners, 3) as an OBJ."""
    corners = [f"v {x!r} {y!r} {z!r}" for x, y, z in triangles.reshape(-1, 3).tolist()]
    faces = [f"f {i + 1} {i + 2} {i + 3}" for i in range(0, len(corners), 3)]
    return "\n".join([*corners, *faces, ""]).encode()


def is_binary_stl(content: bytes) -> bool:
    """Return whether bytes are a binary STL with a triangle, by their count: headers of both formats may look alike."""
    triangles = int.from_bytes(content[STL_HEAD - 4 : STL_HEAD], "little")
    return len(content) == STL_HEAD + STL_TRIANGLE.itemsize * triangles and triangles > 0


def mesh_unit(file: Path) -> float:
    """Return the unit of a mesh, m: 1 unless a DAE that exists declares one (trimesh, Pinocchio, yourdfpy ignore it).

    Raises:
        InputError: the declared unit is no length.
    """
    if file.suffix.lower() != ".dae" or not file.is_file():
        return 1.0
    declared = UNIT.search(file.read_bytes())
    try:
        unit = float(declared[2]) if declared else 1.0
    except ValueError:
        unit = 0.0
    if not 0.0 < unit < inf:
        raise InputError("declares a unit that is no length", where=str(file), right='give <unit meter="1"/>')
    return unit


def declare_metres(content: bytes) -> bytes:
    """Return a DAE with metres in place of a declared unit, for callers that apply that unit as a scale."""
    return UNIT.sub(rb"\g<1>1\g<3>", content, count=1)


def load_mesh(file: Path) -> Any:
    """Return a mesh in the frame of its file, m, as `trimesh` has it.

    Raises:
        InputError: it can't be read, has no area, or declares a unit that is no length.
        MissingExtraError: the extra `view` is not installed.
    """
    trimesh = extras.import_extra("view", "trimesh")
    if file.suffix.lower() == ".dae":
        extras.require("view", "collada")
    unit = mesh_unit(file)
    try:
        mesh = trimesh.load(file, force="mesh")
        mesh.apply_scale(unit)
        reason = "" if mesh.area > 0.0 else "nothing in it"
    except Exception as error:  # each format has errors of its own
        reason = (str(error).splitlines() or [type(error).__name__])[0]
    if reason:
        raise InputError(f"can't be read as a mesh ({reason})", where=str(file), right="give STL, OBJ or DAE")
    return mesh


def is_refused_by_mujoco(file: Path, scale: tuple[float, float, float]) -> bool:
    """Return whether MuJoCo refuses a mesh of a URDF, all of which it takes for solids: a DAE, or one that is flat.

    Without trimesh, a mesh that is no binary STL counts as accepted.
    """
    if file.suffix.lower() == ".dae":
        return True
    content = file.read_bytes()
    if file.suffix.lower() == ".stl" and is_binary_stl(content):
        triangles = stl_triangles(content)
    elif extras.available("view", "trimesh"):
        mesh = load_mesh(file)
        triangles = np.asarray(mesh.vertices[mesh.faces], float)
    else:
        return False
    corners = triangles * np.array(scale)
    volume = np.abs(np.linalg.det(corners - corners.mean(axis=(0, 1)))).sum() / 6.0
    return bool(volume < MIN_VOLUME) or len(np.unique(triangles.reshape(-1, 3), axis=0)) < MIN_CORNERS
