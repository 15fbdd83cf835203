"""Files of memory that processes share: who has one open holds it locked, so that those nobody uses can be removed."""

from __future__ import annotations

import os
import tempfile
import time
from pathlib import Path

from layflat.rig.system import lock

MAILBOX, RING = "layflat-rig-", "layflat-ring-"
"""How their names begin."""

YOUNG = 60.0
"""For so long after it was made a file may be on its way to those who are going to lock it, s."""


def folder() -> Path:
    """Where they lie: in memory where there is such a place."""
    memory = Path("/dev/shm")
    return memory if os.access(memory, os.W_OK) else Path(tempfile.gettempdir())


def new_file(prefix: str, size: int) -> tuple[Path, int]:
    """Make a file of so many bytes, locked and open, after those of dead processes were removed."""
    sweep(prefix)
    handle, name = tempfile.mkstemp(prefix=prefix, dir=folder())
    lock(handle, shared=True)
    os.truncate(handle, size)
    return Path(name), handle


def sweep(prefix: str, older: float | None = None) -> None:
    """Remove the memory of those who were killed: what nobody holds locked.

    Args:
        prefix: of the names.
        older: than so much, s; default: files that change hands before they are locked have time to do so.
    """
    least = (YOUNG if prefix == MAILBOX else 0.0) if older is None else older
    for path in folder().glob(f"{prefix}*"):
        try:
            handle = os.open(path, os.O_RDWR)
        except OSError:
            continue
        try:
            if time.time() - os.fstat(handle).st_mtime >= least:
                lock(handle)
                path.unlink(missing_ok=True)
        except OSError:
            pass
        finally:
            os.close(handle)
