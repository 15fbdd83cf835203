"""Where the meshes are that a robot's file names."""

from pathlib import Path

from layflat.bridge.meshes import FORMATS
from layflat.errors import InputError

IN_PACKAGES = ("package", "model")  # schemes of names that begin with a package of ROS


def find_mesh(named: str, beside: Path, where: str) -> Path:
    """Return the file of a mesh: beside the robot's, or in a package of ROS, whose folder is around the robot's file.

    Raises:
        InputError: it is not there, or of an unknown format.
    """
    place = f"{beside}: {where}"
    scheme, _, rest = named.rpartition("://")
    path = Path(rest)
    tried = [path if path.is_absolute() and scheme not in IN_PACKAGES else beside.parent / path]
    if scheme in IN_PACKAGES:
        package, inside = path.parts[0] if path.parts else "", Path(*path.parts[1:])
        folders = beside.resolve().parents
        tried = [folder / path for folder in folders]
        tried += [folder / inside for folder in folders if folder.name == package]
        tried += [beside.parent / inside]
    there = [one for one in tried if one.is_file()]
    if not there:
        right = "put it there, or leave meshes out: --no-meshes"
        raise InputError(f"mesh {named!r} is not there", where=place, right=right)
    if there[0].suffix.lower() not in FORMATS:
        right = "give STL, OBJ or DAE, or use --no-meshes"
        raise InputError(f"mesh {named!r} is of an unknown format", where=place, right=right)
    return there[0]
