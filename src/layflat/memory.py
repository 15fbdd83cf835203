"""Free memory, so that work that can't fit is refused before it begins."""

import os
import sys
from collections.abc import Callable
from contextlib import suppress
from math import inf
from pathlib import Path

from layflat.errors import InputError

USABLE_FRACTION = 0.9  # fraction of the free memory that work may use
KIB, GIB = 1024.0, 1024.0**3
ALWAYS_FREE_BYTES = 64.0 * KIB**2  # bytes that are free on any system
CGROUP_FOLDER = Path("/sys/fs/cgroup")  # limits of a container: version 2, and below `memory` version 1


def free_memory() -> float:
    """Return the memory that this process can still allocate, bytes: the least of system, container and process limit.

    It is infinite where none of them is known.
    """
    return min(_free_of_system(), _free_of_container(), _free_of_process())


def check_memory(needed: float, work: str, where: str, right: Callable[[float], str]) -> None:
    """Raise InputError if work needs more than `USABLE_FRACTION` of the free memory; 64 MiB are always allowed.

    Args:
        needed: memory of the work, bytes.
        work: its name in messages, such as "a run of 3600 s".
        where: the argument that makes it large.
        right: function from the available fraction of the needed memory to advice, in words, on smaller work.

    Raises:
        InputError: naming `where`, with the estimate.
    """
    if needed <= ALWAYS_FREE_BYTES:
        return
    free = free_memory()
    if needed > USABLE_FRACTION * free:
        what = f"{work} needs about {needed / GIB:.3g} GiB of memory, and {free / GIB:.3g} GiB are free"
        raise InputError(what, where=where, right=right(USABLE_FRACTION * free / needed))


def _free_of_system() -> float:
    """Return the free memory of the system, bytes: its total memory where that is unknown, else infinite."""
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
    """Return the free memory of a control group, bytes, inactive cached files included; infinite without a limit."""
    for limit, used, cached in (
        (CGROUP_FOLDER / "memory.max", CGROUP_FOLDER / "memory.current", CGROUP_FOLDER / "memory.stat"),
        *((CGROUP_FOLDER / "memory" / f"memory.{name}" for name in ("limit_in_bytes", "usage_in_bytes", "stat")),),
    ):
        with suppress(OSError, ValueError):
            max_bytes = float(limit.read_text(encoding="ascii"))  # "max" is none
            lines = (line.split() for line in cached.read_text(encoding="ascii").splitlines())
            idle = sum(float(value) for name, value in lines if name in {"inactive_file", "total_inactive_file"})
            return max(max_bytes - float(used.read_text(encoding="ascii")) + idle, 0.0)
    return inf


def _free_of_process() -> float:
    """Return the free memory below a limit on the address space (`ulimit -v`), bytes; infinite without a limit."""
    with suppress(ImportError, OSError, ValueError):
        import resource  # noqa: PLC0415  # not on every system

        limit = resource.getrlimit(resource.RLIMIT_AS)[0]
        if limit == resource.RLIM_INFINITY:
            return inf
        pages = float(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
        return max(float(limit) - pages * os.sysconf("SC_PAGE_SIZE"), 0.0)
    return inf


def _free_of_windows() -> float:
    """Return the free physical memory on Windows, bytes; infinite where it does not say."""
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
