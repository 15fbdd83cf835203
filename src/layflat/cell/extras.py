"""Libraries of the extra `cell`, imported when they are needed; MissingExtraError names one that is not there."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from layflat import extras
from layflat.bridge.arm import engine


def mujoco() -> Any:
    """Return the package `mujoco`."""
    return engine()


def opencv() -> Any:
    """Return the package `cv2`."""
    return extras.module("cell", "cv2")


@contextmanager
def one_thread() -> Iterator[None]:
    """Let OpenCV work on one thread: sums of several come in any order, and their last digits with it."""
    cv2 = opencv()
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        yield
    finally:
        cv2.setNumThreads(threads)


def points(found: Any, width: int = 2) -> Any:
    """Return points of OpenCV, (N, 1, width) before version 5 and (N, width) since, as (N, width)."""
    return found.reshape(-1, width)
