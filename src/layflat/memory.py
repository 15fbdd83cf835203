"""Memory that is free, so that work that can't fit is refused before it begins."""

import os
import sys
from collections.abc import Callable
from contextlib import suppress
from math import inf
from pathlib import Path

from layflat.errors import InputError

SPARE = 0.9  # part of the free memory that work may take
KIB, GIB = 1024.0, 1024.0**3
SMALL = 64.0 * KIB**2  # bytes that any system has
CGROUP = Path("/sys/fs/cgroup")  # limits of a container: version 2, and below `memory` version 1


def free_memory() -> float:
    """Return how many bytes of memory this process can still get; infinite where the system does not say."""
    return min(_free_of_system(), _free_of_container(), _free_of_process())


def check_memory(needed: float, work: str, where: str, right: Callable[[float], str]) -> None:
    """Refuse work that needs more memory than is free.

    Args:
        needed: by the work, bytes.
        work: its name in messages, such as "a run of 3600 s".
        where: the argument that makes it large.
        right: smaller work that would do, in words, of the fraction of the memory that there is.

    Raises:
        InputError: naming `where`, with the estimate.
    """
    if needed <= SMALL:
        return
    free = free_memory()
    if needed > SPARE * free:
        what = f"{work} needs about {needed / GIB:.3g} GiB of memory, and {free / GIB:.3g} GiB are free"
        raise InputError(what, where=where, right=right(SPARE * free / needed))


def _free_of_system() -> float:
    if sys.platform == "linux":
        with suppress(OSError, ValueError):
            for line in Path("/proc/meminfo").read_text(encoding="ascii").splitlines():
                if line.startswith("MemAvailable:"):
                    return float(line.split()[1]) * KIB
    if sys.platform == "win32":
        return _free_of_windows()
    with suppress(OSError, ValueError, AttributeError):
        return float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    return inf


def _free_of_container() -> float:
    """Return what a control group leaves to its processes; files that it only caches can be given up."""
    for limit, used, cached in (
        (CGROUP / "memory.max", CGROUP / "memory.current", CGROUP / "memory.stat"),
        *((CGROUP / "memory" / f"memory.{name}" for name in ("limit_in_bytes", "usage_in_bytes", "stat")),),
    ):
        with suppress(OSError, ValueError):
            most = float(limit.read_text(encoding="ascii"))  # "max" is none
            lines = (line.split() for line in cached.read_text(encoding="ascii").splitlines())
            idle = sum(float(value) for name, value in lines if name in {"inactive_file", "total_inactive_file"})
            return max(most - float(used.read_text(encoding="ascii")) + idle, 0.0)
    return inf


def _free_of_process() -> float:
    """Return what a limit on the address space (`ulimit -v`) leaves to this process."""
    with suppress(ImportError, OSError, ValueError):
        import resource  # noqa: PLC0415  # not on every system

        limit = resource.getrlimit(resource.RLIMIT_AS)[0]
        if limit == resource.RLIM_INFINITY:
            return inf
        pages = float(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
        return max(float(limit) - pages * os.sysconf("SC_PAGE_SIZE"), 0.0)
    return inf


def _free_of_windows() -> float:
    import ctypes  # noqa: PLC0415

    class Status(ctypes.Structure):
        """Structure MEMORYSTATUSEX of the system."""

        _fields_ = (
            ("length", ctypes.c_ulong),
            ("load", ctypes.c_ulong),
            *((name, ctypes.c_ulonglong) for name in ("total", "free", "a", "b", "c", "d", "e")),
        )

    status = Status(length=ctypes.sizeof(Status))
    with suppress(AttributeError, OSError):
        if ctypes.windll.kernel32.GlobalMemoryStatusEx(ctypes.byref(status)):  # type: ignore[attr-defined]
            return float(status.free)
    return inf
