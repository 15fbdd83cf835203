"""File that grows: no data stay buffered in the process, and a full disk is a state, not an error."""

import contextlib
import errno
import os
import threading
from pathlib import Path

from layflat.rig.system import lock_file

MAX_PENDING_BYTES = 32 * 2**20  # bytes that are buffered while nothing can be written
SYNC_INTERVAL = 0.3  # between two syncs of the disk, s

_sync = getattr(os, "fdatasync", os.fsync)


class GrowingFile:
    """New or empty file to append to, locked while it is open, so that `log repair` leaves it alone.

    A killed process loses nothing that was flushed; a computer that loses power loses what came after the last sync of
    the disk. A thread syncs, since a slow disk blocks. Its folder is created, too. Raise OSError if the file
    can't be created or locked, or is not empty.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.trouble = ""  # reason why nothing can be written now; empty where it can
        path.parent.mkdir(parents=True, exist_ok=True)
        self._handle = os.open(path, os.O_WRONLY | os.O_CREAT, 0o644)
        lock_file(self._handle)
        if os.fstat(self._handle).st_size:
            os.close(self._handle)
            raise FileExistsError(errno.EEXIST, "holds something already", str(path))
        self._pending = bytearray()
        self._end = 0
        self._closing = threading.Event()
        self._syncing = threading.Thread(target=self._keep_syncing, daemon=True)
        self._syncing.start()

    def write(self, data: bytes) -> int:
        """Append data to the buffer, which `flush` writes; return its size."""
        self._pending += data
        self._end += len(data)
        return len(data)

    def tell(self) -> int:
        """Return the bytes so far, buffered ones included."""
        return self._end

    @property
    def has_room(self) -> bool:
        """Return whether the buffer has room."""
        return len(self._pending) < MAX_PENDING_BYTES

    def flush(self) -> None:
        """Write the buffer; where that fails, keep it for the next call and set `trouble`."""
        try:
            while self._pending:
                del self._pending[: os.write(self._handle, self._pending)]
            self.trouble = ""
        except OSError as error:
            self.trouble = error.strerror or str(error)

    def sync(self) -> None:
        """Sync flushed data to the disk; an OSError is ignored, since `flush` reports what can't be written."""
        with contextlib.suppress(OSError):  # what can't be written shows when it is
            _sync(self._handle)

    def close(self) -> None:
        """Stop the syncing, and close and unlock the file; data that were not flushed are lost."""
        self._closing.set()
        self._syncing.join()
        os.close(self._handle)

    def _keep_syncing(self) -> None:
        """Sync every `SYNC_INTERVAL` until the file is closed."""
        while not self._closing.wait(SYNC_INTERVAL):
            self.sync()


def sync_path(path: Path) -> None:
    """Sync a file or a folder to the disk."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
