"""MuJoCo, imported when it is needed."""

from __future__ import annotations

from typing import Any

from layflat import extras


def engine() -> Any:
    """Import the package `mujoco`.

    Raises:
        MissingExtraError: it is not installed.
    """
    return extras.module("cell", "mujoco")
