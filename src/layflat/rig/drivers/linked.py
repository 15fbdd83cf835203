"""Base class of drivers over wires: they lock the rig, store the command, and make one transaction a cycle."""

import getpass
import os
import re
import sys
import tempfile
import time
from abc import abstractmethod
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from select import select

import numpy as np

from layflat.machine.model import Machine
from layflat.rig.driver import Capabilities, Driver, DriverError, Lifecycle, LinkError, RigCommand, SensorReading
from layflat.rig.system import lock_file
from layflat.rig.wire import Identity, Wire, WireError, next_sequence

MAX_DEACTIVATE_ATTEMPTS = 3  # transactions in which a deactivated driver tries to send the safe command
MAX_READ_BYTES = 4096  # bytes read at once


def read_pieces(file: int, read: Callable[[int], bytes], patience: float) -> Iterator[bytes]:
    """Yield bytes as they come, until one deadline for all: a reply that trickles is as late as one that is lost.

    Args:
        file: descriptor of the line.
        read: reads up to a number of bytes from it.
        patience: time until the deadline, s.

    Raises:
        OSError: the other end has hung up.
    """
    deadline, left = time.monotonic() + patience, patience
    while left >= 0.0 and select([file], [], [], left)[0]:
        data = read(MAX_READ_BYTES)
        if not data:
            raise ConnectionResetError
        yield data
        left = deadline - time.monotonic()


def lock_rig(endpoint: str) -> int:
    """Lock a rig, by its canonical name, for this process alone; return the file descriptor that is closed to unlock.

    The kernel releases the lock when its holder ends, however it ends.

    Raises:
        DriverError: another process holds the lock, or the file can't be created.
    """
    runtime, chosen = os.environ.get("XDG_RUNTIME_DIR"), os.environ.get("LAYFLAT_RUNTIME_DIR")
    usual = Path(runtime) / "layflat" if runtime else Path(tempfile.gettempdir()) / f"layflat-{getpass.getuser()}"
    folder = Path(chosen) if chosen else usual
    path = folder / (re.sub(r"[^A-Za-z0-9.]+", "-", endpoint).strip("-") + ".lock")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        file = os.open(path, os.O_RDWR | os.O_CREAT, 0o600)
    except OSError as error:
        what = f"the lock can't be made ({error.strerror})"
        raise DriverError(what, where=str(path), right="set LAYFLAT_RUNTIME_DIR to another folder") from None
    try:
        lock_file(file)
    except OSError:
        holder = os.read(file, 500).decode(errors="replace").strip() or "another process"
        os.close(file)
        right = "one loop drives a rig: end the other first"
        raise DriverError(f"is driven by {holder} already", where=endpoint, right=right) from None
    os.ftruncate(file, 0)
    os.write(file, f"process {os.getpid()} ({' '.join(Path(a).name for a in sys.argv[:3])})\n".encode())
    return file  # it stays on the disk, as whoever waits for it may have it open


class LinkedDriver(Driver):
    """Driver whose device answers commands; the endpoint is its name for people and for the lock."""

    late = 1

    def __init__(self, machine: Machine, endpoint: str) -> None:
        super().__init__()
        self.endpoint = endpoint
        self._machine = machine
        self._wire = Wire.for_machine(machine)
        safe = RigCommand(np.full(self._wire.joints, self._wire.voltage.value(self._wire.centre)), air=False)
        self._safe = self._kept = self._wire.command_words(safe)
        # Differs from that of an earlier process, whose last reply may still be under way.
        self._sequence = time.monotonic_ns() // 1000 & 0xFFFF
        self._lock = -1

    def read(self) -> SensorReading:
        """Send the stored command (the safe one while inactive) and return the reading that answers it.

        Raises:
            LinkError: no good reply came in time.
        """
        if self.state is not Lifecycle.INACTIVE:
            self._expect("read", Lifecycle.ACTIVE)
        return self._transact()

    def write(self, command: RigCommand) -> None:
        """Store a command for the next `read`."""
        self._expect("write", Lifecycle.ACTIVE)
        self._kept = self._wire.command_words(command)

    def finalize(self) -> None:
        """Release the device and its lock in any state, deactivated if active; a second call does nothing."""
        super().finalize()
        self._release_link()

    def _transact(self) -> SensorReading:
        """Send the stored command and return the reading that answers it; raise LinkError if no valid one comes."""
        self._sequence = next_sequence(self._sequence)
        words = self._exchange(self._sequence, self._kept)
        try:
            return self._wire.reading(words)
        except WireError:
            raise LinkError("crc") from None

    def _configure(self) -> Capabilities:
        """Lock the rig, connect, and return its capabilities, checked against the machine; release all on failure.

        Raise DriverError if the rig is locked or not reached, is no rig, or differs from the machine.
        """
        self._lock = lock_rig(self.endpoint)
        try:
            self._connect()
            return self._identify().check(self._machine, self.endpoint)
        except WireError as error:
            self._release_link()
            raise self._error(str(error), "give the address of a rig") from None
        except BaseException:
            self._release_link()
            raise

    def _deactivate(self) -> None:
        """Send the safe command until it is answered, but at most `MAX_DEACTIVATE_ATTEMPTS` times; raise nothing."""
        self._kept = self._safe
        for _ in range(MAX_DEACTIVATE_ATTEMPTS):
            with suppress(LinkError):
                self._transact()
                return

    def _release_link(self) -> None:
        """Disconnect, and release the lock of the rig."""
        self._disconnect()
        if self._lock >= 0:
            os.close(self._lock)
            self._lock = -1

    def _error(self, what: str, right: str) -> DriverError:
        return DriverError(what, where=self.endpoint, right=right)

    @abstractmethod
    def _connect(self) -> None:
        """Open the link, or raise a DriverError."""

    @abstractmethod
    def _identify(self) -> Identity:
        """Read the identity of the device; raise DriverError if nothing answers, WireError if it is not a rig."""

    @abstractmethod
    def _exchange(self, sequence: int, words: list[int]) -> Sequence[int]:
        """Send a command's words; return those of the reading that answers it, or raise a LinkError."""

    @abstractmethod
    def _disconnect(self) -> None:
        """Close the link, if it is open."""
