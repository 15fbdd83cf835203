"""MuJoCo, imported when it is needed."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from layflat.errors import InputError


def engine() -> Any:
    """The package `mujoco`.

    Raises:
        InputError: it is not installed.
    """
    try:
        return import_module("mujoco")
    except ImportError:
        raise InputError("is not installed", where="mujoco", right="install it: pip install 'layflat[cell]'") from None
