"""OpenCV as vision uses it, whichever version is installed."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from layflat.cell.extras import opencv

__all__ = ["one_thread", "opencv", "points"]


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
    """Points as OpenCV returns them, (N, 1, `width`) before version 5 and (N, `width`) since, as (N, `width`)."""
    return found.reshape(-1, width)
