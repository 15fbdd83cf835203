"""One loop a rig: a lock that the kernel lets go of when its holder ends, however it ends."""

from __future__ import annotations

import getpass
import os
import re
import sys
import tempfile
from pathlib import Path

from layflat.rig.driver import DriverError
from layflat.rig.system import lock


def lock_rig(endpoint: str) -> int:
    """Lock a rig, by its one true name, for this process alone; returns the file to be closed when it is let go.

    Raises:
        DriverError: somebody else has it, or the file can't be made.
    """
    folder = _folder()
    path = folder / (re.sub(r"[^A-Za-z0-9.]+", "-", endpoint).strip("-") + ".lock")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        file = os.open(path, os.O_RDWR | os.O_CREAT, 0o600)
    except OSError as error:
        what = f"the lock can't be made ({error.strerror})"
        raise DriverError(what, where=str(path), right="set LAYFLAT_RUNTIME_DIR") from None
    try:
        lock(file)
    except OSError:
        holder = os.read(file, 500).decode(errors="replace").strip() or "another process"
        os.close(file)
        right = "one loop drives a rig: end the other first"
        raise DriverError(f"is driven by {holder} already", where=endpoint, right=right) from None
    os.ftruncate(file, 0)
    os.write(file, f"process {os.getpid()} ({' '.join(Path(a).name for a in sys.argv[:3])})\n".encode())
    return file  # it stays on the disk, as whoever waits for it may have it open


def _folder() -> Path:
    """Where locks of this user lie until the machine is switched off."""
    runtime = os.environ.get("XDG_RUNTIME_DIR")
    usual = Path(runtime) / "layflat" if runtime else Path(tempfile.gettempdir()) / f"layflat-{getpass.getuser()}"
    return Path(os.environ.get("LAYFLAT_RUNTIME_DIR") or usual)
