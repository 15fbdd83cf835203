"""Reading of robot files: URDF and MJCF."""

import re
from pathlib import Path
from xml.etree.ElementTree import Element, ParseError, fromstring

from layflat.bridge.robots.mjcf import read_mjcf
from layflat.bridge.robots.robot import Robot
from layflat.bridge.robots.urdf import read_urdf
from layflat.description.text import read_bytes
from layflat.errors import InputError

MAX_FILE_BYTES = 50_000_000
FORMAT_ADVICE = "give a URDF or an MJCF"
CONVERSION_ADVICE = {
    ".xacro": "expand it first: xacro robot.urdf.xacro > robot.urdf",
    ".sdf": "convert it to URDF first",
    ".usd": "export it as URDF or MJCF",
}
UTF_16 = (b"\xff\xfe", b"\xfe\xff")  # byte order marks
ENCODING_DECLARATION = re.compile(rb"""^(?:\xef\xbb\xbf)?\s*<\?xml[^>]*encoding\s*=\s*["']([A-Za-z0-9._-]+)["']""")


def read_robot(file: Path, *, meshes: bool = True) -> Robot:
    """Return the robot of a URDF or an MJCF; the root element decides which it is.

    Args:
        file: the file.
        meshes: whether to import meshes for drawing.

    Raises:
        InputError: the file is wrong; the message says what would be right.
        MissingExtraError: an MJCF, and MuJoCo is not installed.
    """
    if file.suffix.lower() in CONVERSION_ADVICE:
        right = CONVERSION_ADVICE[file.suffix.lower()]
        raise InputError(f"is {file.suffix[1:].upper()}, not URDF or MJCF", where=str(file), right=right)
    content = read_bytes(file, str(file), FORMAT_ADVICE, max_bytes=MAX_FILE_BYTES)
    encoding = _encoding(content)
    text = _text(file, content, encoding)
    root = _root(file, text)
    if root.tag == "robot":
        if any("xacro" in name for name in (*root.attrib, *(child.tag for child in root))):
            raise InputError("has macros of xacro in it", where=str(file), right=CONVERSION_ADVICE[".xacro"])
        return read_urdf(file, root, meshes=meshes)
    if root.tag == "mujoco":
        return read_mjcf(file, "" if encoding == "utf-8" else text, meshes=meshes)
    raise InputError(f"begins with <{root.tag}>, not <robot> or <mujoco>", where=str(file), right=FORMAT_ADVICE)


def _encoding(content: bytes) -> str:
    """Return the encoding that an XML file has by its byte order mark or declaration; without any it is UTF-8."""
    if content.startswith(UTF_16):
        return "utf-16"
    declared = ENCODING_DECLARATION.match(content)
    name = declared[1].decode().lower() if declared else "utf-8"
    return "utf-8" if name in {"utf-8", "utf8", "us-ascii", "ascii"} else name


def _text(file: Path, content: bytes, encoding: str) -> str:
    """Return the text of a file, without the declaration of another encoding than UTF-8.

    Raises:
        InputError: the encoding is unknown, or another one than declared.
    """
    try:
        text = content.decode(encoding).removeprefix("\ufeff")
    except UnicodeError as error:
        line = content.count(b"\n", 0, getattr(error, "start", 0)) + 1
        right = "save it as UTF-8, or declare its encoding in the first line"
        raise InputError(f"is not in {encoding.upper()} (line {line})", where=str(file), right=right) from None
    except LookupError:
        what = f"declares the unknown encoding {encoding!r}"
        raise InputError(what, where=str(file), right="save it as UTF-8") from None
    return text.lstrip().partition("?>")[2] if encoding != "utf-8" and text.lstrip().startswith("<?xml") else text


def _root(file: Path, text: str) -> Element:
    """Return the root element of an XML text; raise InputError with line and column if it is not XML."""
    try:
        return fromstring(text)
    except ParseError as error:
        line, column = error.position
        message = str(error).partition(":")[0]
        what = f"is not XML: {message} at line {line}, column {column + 1}"
        raise InputError(what, where=str(file), right=FORMAT_ADVICE) from None
