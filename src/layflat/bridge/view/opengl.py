"""The OpenGL that draws MuJoCo's models without a screen."""

import ctypes
import os
from importlib import import_module
from typing import Any

from layflat.errors import NoDrawingError

LIBRARIES = {"egl": "libEGL.so.1", "osmesa": "libOSMesa.so.8"}  # ways to draw, the faster first, and what each needs
INSTALL = "install one: apt-get install libegl1 libgl1-mesa-dri (or libosmesa6)"


def context(width: int, height: int) -> Any:
    """Return a current context to draw off screen, by MUJOCO_GL's way or the first there is; NoDrawingError without."""
    way = os.environ.get("MUJOCO_GL", "").lower() or _there()
    try:
        made = import_module(f"mujoco.{way}").GLContext(width, height)
        made.make_current()
    except Exception as error:  # each library has errors of its own
        reason = (str(error).splitlines() or [type(error).__name__])[0].split(". ")[0]
        raise NoDrawingError(f"no picture can be drawn by {way} ({reason}); {INSTALL}") from None
    return made


def _there() -> str:
    for way, library in LIBRARIES.items():
        try:
            ctypes.CDLL(library)
        except OSError:
            continue
        return way
    raise NoDrawingError(f"no picture can be drawn: there is no OpenGL library; {INSTALL}")
