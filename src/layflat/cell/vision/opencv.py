"""OpenCV, where it is installed: it takes long to import and is an extra."""

from __future__ import annotations

from typing import Any

from layflat.errors import InputError


def opencv() -> Any:
    """The module cv2.

    Raises:
        InputError: it is not installed.
    """
    try:
        import cv2  # noqa: PLC0415
    except ImportError:
        raise InputError("needs OpenCV", where="vision", right="pip install 'layflat[cell]'") from None
    return cv2


def points(found: Any, width: int = 2) -> Any:
    """Points as OpenCV returns them, (N, 1, `width`) before version 5 and (N, `width`) since, as (N, `width`)."""
    return found.reshape(-1, width)
