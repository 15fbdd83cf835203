"""Libraries of the extra `cell`, imported when they are needed."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any

from layflat.bridge.engine import engine
from layflat.errors import InputError


def mujoco() -> Any:
    """The package `mujoco`.

    Raises:
        InputError: it is not installed.
    """
    try:
        return engine()
    except (AttributeError, RuntimeError):  # MUJOCO_GL names what is not there; only pictures need it, see gl.py
        with _environment(MUJOCO_GL="disable"):
            return engine()


def opencv() -> Any:
    """The package `cv2`.

    Raises:
        InputError: it is not installed.
    """
    return _package("cv2", "opencv-python-headless")


def pyav() -> Any:
    """The package `av`, which has FFmpeg in it.

    Raises:
        InputError: it is not installed.
    """
    return _package("av", "av")


@contextmanager
def _environment(**changes: str) -> Iterator[None]:
    before = dict(os.environ)
    os.environ.update(changes)
    try:
        yield
    finally:
        os.environ.clear()
        os.environ.update(before)


def _package(name: str, where: str) -> Any:
    try:
        return import_module(name)
    except ImportError:
        raise InputError("is not installed", where=where, right="install it: pip install 'layflat[cell]'") from None


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
