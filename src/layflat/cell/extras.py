"""Libraries of the extra `cell`, imported when they are needed."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from layflat.errors import InputError


def mujoco() -> Any:
    """The package `mujoco`.

    Raises:
        InputError: it is not installed.
    """
    return _package("mujoco", "mujoco")


def opencv() -> Any:
    """The package `cv2`.

    Raises:
        InputError: it is not installed.
    """
    return _package("cv2", "opencv-python-headless")


def _package(name: str, where: str) -> Any:
    try:
        return import_module(name)
    except ImportError:
        raise InputError("is not installed", where=where, right="install it: pip install 'layflat[cell]'") from None
