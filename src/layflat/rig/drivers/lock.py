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


class RigLock:
    """Held from `acquire` to `release` by one driver on this machine.

    Args:
        endpoint: what is locked, by its one true name.
    """

    def __init__(self, endpoint: str) -> None:
        self._endpoint = endpoint
        self._file: int | None = None

    def acquire(self) -> None:
        """Take it.

        Raises:
            DriverError: somebody else has it, or the file can't be made.
        """
        folder = _folder()
        path = folder / (re.sub(r"[^A-Za-z0-9.]+", "-", self._endpoint).strip("-") + ".lock")
        try:
            folder.mkdir(parents=True, exist_ok=True)
            file = os.open(path, os.O_RDWR | os.O_CREAT, 0o600)
        except OSError as error:
            raise DriverError(
                f"the lock can't be made ({error.strerror})", where=str(path), right="set LAYFLAT_RUNTIME_DIR"
            ) from None
        try:
            lock(file)
        except OSError:
            holder = os.read(file, 500).decode(errors="replace").strip()
            os.close(file)
            raise DriverError(
                f"is driven by {holder or 'another process'} already",
                where=self._endpoint,
                right="one loop drives a rig: end the other first",
            ) from None
        os.ftruncate(file, 0)
        os.write(file, f"process {os.getpid()} ({' '.join(Path(a).name for a in sys.argv[:3])})\n".encode())
        self._file = file

    def release(self) -> None:
        """Let it go, if it is held; the file stays, as whoever waits for it may have it open."""
        if self._file is not None:
            os.close(self._file)
            self._file = None


def _folder() -> Path:
    """Where locks of this user lie until the machine is switched off."""
    runtime = os.environ.get("XDG_RUNTIME_DIR")
    usual = Path(runtime) / "layflat" if runtime else Path(tempfile.gettempdir()) / f"layflat-{getpass.getuser()}"
    return Path(os.environ.get("LAYFLAT_RUNTIME_DIR") or usual)
