"""MuJoCo and OpenCV as the cell uses them, imported when they are needed.

MissingExtraError names a library of the extra `cell` that is not there.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Literal

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
    """Restrict OpenCV to one thread: sums of several come in any order, and their last digits with it."""
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


UNTOUCHED = {"contype": 0, "conaffinity": 0}  # of what is seen and touches nothing


Geom = Literal["box", "cylinder", "capsule", "ellipsoid", "mesh"]


def add_geom(body: Any, kind: Geom, name: str, **others: Any) -> None:
    """Add a geom to a body; lengths in m, `size` may be shorter than MuJoCo's three."""
    if "size" in others:
        others["size"] = [*others["size"], 0.0, 0.0][:3]
    body.add_geom(name=name, type=getattr(mujoco().mjtGeom, f"mjGEOM_{kind.upper()}"), **others)
