"""A file that grows: nothing is kept back in the process, and a full disk is not an error but a state."""

import contextlib
import errno
import os
import threading
from pathlib import Path

from layflat.rig.system import lock

MOST_PENDING = 32 * 2**20  # bytes that are kept in memory while nothing can be written
SYNC = 0.3  # between two orders to the disk to have what was written, s

_sync = getattr(os, "fdatasync", os.fsync)


class GrowingFile:
    """An empty file to write at the end of, made unless it is there, locked while open: `log repair` leaves it alone.

    A killed process loses nothing that was flushed; a machine that loses power what came after the last order to the
    disk. These orders are given by a thread, since a slow disk takes its time. Raise OSError if it can't be made, or
    holds something already.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.trouble = ""  # why nothing can be written now; empty where all is well
        path.parent.mkdir(parents=True, exist_ok=True)
        self._handle = os.open(path, os.O_WRONLY | os.O_CREAT, 0o644)
        lock(self._handle)
        if os.fstat(self._handle).st_size:
            os.close(self._handle)
            raise FileExistsError(errno.EEXIST, "holds something already", str(path))
        self._pending = bytearray()
        self._end = 0
        self._closing = threading.Event()
        self._syncing = threading.Thread(target=self._keep_syncing, daemon=True)
        self._syncing.start()

    def write(self, data: bytes) -> int:
        """Add at the end; it reaches the file with `flush`."""
        self._pending += data
        self._end += len(data)
        return len(data)

    def tell(self) -> int:
        """Bytes so far, those to be written included."""
        return self._end

    @property
    def room(self) -> bool:
        """Whether more can be taken in."""
        return len(self._pending) < MOST_PENDING

    def flush(self) -> None:
        """Write what is there; where that fails, keep it for the next time and say so in `trouble`."""
        try:
            while self._pending:
                del self._pending[: os.write(self._handle, self._pending)]
            self.trouble = ""
        except OSError as error:
            self.trouble = error.strerror or str(error)

    def sync(self) -> None:
        """Have on the disk what was flushed."""
        with contextlib.suppress(OSError):  # what can't be written shows when it is
            _sync(self._handle)

    def close(self) -> None:
        """Let go."""
        self._closing.set()
        self._syncing.join()
        os.close(self._handle)

    def _keep_syncing(self) -> None:
        while not self._closing.wait(SYNC):
            self.sync()


def synced(path: Path) -> None:
    """Have a file or a folder on the disk."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
