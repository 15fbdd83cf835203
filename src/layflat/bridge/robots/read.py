"""A file of a robot, whatever its format."""

from pathlib import Path
from xml.etree.ElementTree import ParseError, fromstring

from layflat.bridge.robots.mjcf import read_mjcf
from layflat.bridge.robots.robot import Robot
from layflat.bridge.robots.urdf import read_urdf
from layflat.description.text import read_text
from layflat.errors import InputError

MOST_BYTES = 50_000_000
RIGHT = "give a URDF or an MJCF"
OTHERS = {
    ".xacro": "expand it first: xacro robot.urdf.xacro > robot.urdf",
    ".sdf": "convert it to URDF first",
    ".usd": "export it as URDF or MJCF",
}


def read_robot(file: Path, *, meshes: bool = True) -> Robot:
    """Return the robot of a URDF or an MJCF, which is told by what stands in it.

    Args:
        file: the file.
        meshes: whether to take meshes along for drawing.

    Raises:
        InputError: in one line, what is wrong with it and what would be right.
        MissingExtraError: an MJCF, and MuJoCo is not installed.
    """
    if file.suffix.lower() in OTHERS:
        right = OTHERS[file.suffix.lower()]
        raise InputError(f"is {file.suffix[1:].upper()}, not URDF or MJCF", where=str(file), right=right)
    text = read_text(file, str(file), RIGHT, most=MOST_BYTES)
    try:
        root = fromstring(text)
    except ParseError as error:
        line, column = error.position
        said = str(error).partition(":")[0]
        what = f"is not XML: {said} at line {line}, column {column + 1}"
        raise InputError(what, where=str(file), right=RIGHT) from None
    if root.tag == "robot":
        if any("xacro" in name for name in (*root.attrib, *(child.tag for child in root))):
            raise InputError("has macros of xacro in it", where=str(file), right=OTHERS[".xacro"])
        return read_urdf(file, root, meshes=meshes)
    if root.tag == "mujoco":
        return read_mjcf(file, meshes=meshes)
    raise InputError(f"begins with <{root.tag}>, not <robot> or <mujoco>", where=str(file), right=RIGHT)
