"""Meshes that pieces are drawn by: files beside a model, with names of their own, in formats that its readers know."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from layflat import extras
from layflat.bridge.pieces import Piece
from layflat.errors import InputError

FORMATS = (".stl", ".obj", ".dae")
STL_HEAD, STL_TRIANGLE = 84, 50  # bytes of a binary STL before its triangles, and of each


class Meshes:
    """The meshes of an arm, each with a name that no other has.

    Args:
        pieces: what is drawn.
        folder: that the names are in, relative to the model.
        engine: whether they are for MuJoCo, which reads OBJ and binary STL only: others become such.
    """

    def __init__(self, pieces: Iterable[Piece], folder: str, *, engine: bool) -> None:
        self._engine, self._folder, self._names = engine, folder, dict[Path, str]()
        for piece in pieces:
            if piece.file is not None and piece.file not in self._names:
                self._names[piece.file] = self._free(piece.file)

    def __bool__(self) -> bool:
        """Whether there are any."""
        return bool(self._names)

    def name(self, file: Path) -> str:
        """Return the name of a file."""
        return self._names[file]

    def contents(self) -> dict[str, bytes]:
        """Return what is in each file, by its name.

        Raises:
            InputError: a mesh can't be read.
            MissingExtraError: one has to be converted, and what does that is not installed.
        """
        return {name: read(path, engine=self._engine) for path, name in self._names.items()}

    def _free(self, file: Path) -> str:
        suffix = ".stl" if self._engine and file.suffix.lower() != ".obj" else file.suffix.lower()
        start = f"{self._folder}/" if self._folder else ""
        taken, stem, count = set(self._names.values()), file.stem, 2
        while f"{start}{stem}{suffix}" in taken:
            stem, count = f"{file.stem}-{count}", count + 1
        return f"{start}{stem}{suffix}"


def read(file: Path, *, engine: bool) -> bytes:
    """Return what is in a file, converted to a binary STL if an engine wants it and could not read it."""
    try:
        content = file.read_bytes()
    except OSError as error:
        raise InputError(f"can't be read ({error.strerror})", where=str(file), right="give a mesh") from None
    plain = file.suffix.lower() == ".obj" or (file.suffix.lower() == ".stl" and is_binary_stl(content))
    if not engine or plain:
        return content
    exported: bytes = solid(file).export(file_type="stl")
    return exported


def is_binary_stl(content: bytes) -> bool:
    """Tell whether bytes are a binary STL by their number, as texts may begin like one and the other way round."""
    triangles = int.from_bytes(content[STL_HEAD - 4 : STL_HEAD], "little")
    return len(content) == STL_HEAD + STL_TRIANGLE * triangles and triangles > 0


def solid(file: Path) -> Any:
    """Return a mesh in the frame and unit of its file, as `trimesh` has it; raise InputError if it can't be read."""
    trimesh = extras.module("view", "trimesh")
    if file.suffix.lower() == ".dae":
        extras.require("view", "collada")
    try:
        mesh = trimesh.load(file, force="mesh")
        reason = "" if len(mesh.faces) else "nothing in it"
    except Exception as error:  # each format has errors of its own
        reason = (str(error).splitlines() or [type(error).__name__])[0]
    if reason:
        raise InputError(f"can't be read as a mesh ({reason})", where=str(file), right="give STL, OBJ or DAE")
    return mesh
