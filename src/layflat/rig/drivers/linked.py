"""What drivers over wires have in common: they lock the rig, keep the command, and make one transaction a cycle."""

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
from layflat.rig.driver import Capabilities, Command, Driver, DriverError, Lifecycle, LinkError, Reading
from layflat.rig.system import lock
from layflat.rig.wire.content import Wire, WireError, following
from layflat.rig.wire.identity import Identity

FAREWELLS = 3  # how often a driver that is deactivated tries to say so
LARGEST = 4096  # bytes taken at once


def pieces(file: int, read: Callable[[int], bytes], patience: float) -> Iterator[bytes]:
    """Bytes as they come, until one deadline for all of them: a reply that trickles is as late as one that is lost.

    Raise OSError if the other end has hung up.
    """
    deadline, left = time.monotonic() + patience, patience
    while left >= 0.0 and select([file], [], [], left)[0]:
        data = read(LARGEST)
        if not data:
            raise ConnectionResetError
        yield data
        left = deadline - time.monotonic()


def lock_rig(endpoint: str) -> int:
    """Lock a rig, by its one true name, for this process alone; returns the file to be closed when it is let go.

    The kernel lets go of it when its holder ends, however it ends. Raise DriverError if somebody else has it, or the
    file can't be made.
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


class LinkedDriver(Driver):
    """A driver whose device answers commands; the endpoint names it for people and for the lock."""

    late = 1

    def __init__(self, machine: Machine, endpoint: str) -> None:
        super().__init__()
        self.endpoint = endpoint
        self._machine = machine
        self._wire = Wire.of(machine)
        safe = Command(np.full(self._wire.joints, self._wire.voltage.value(self._wire.centre)), air=False)
        self._safe = self._kept = self._wire.command_words(safe)
        # Not that of an earlier process, whose last reply may still be under way.
        self._sequence = time.monotonic_ns() // 1000 & 0xFFFF
        self._lock = -1

    def read(self) -> Reading:
        """Send the kept command (the safe one while inactive); raise LinkError if it is not answered well in time."""
        if self.state is not Lifecycle.INACTIVE:
            self._expect("read", Lifecycle.ACTIVE)
        return self._transact()

    def write(self, command: Command) -> None:
        """Keep a command for the next `read`."""
        self._expect("write", Lifecycle.ACTIVE)
        self._kept = self._wire.command_words(command)

    def finalize(self) -> None:
        """Let go of the device and of its lock, whatever state it is in; a second call does nothing."""
        super().finalize()
        self._let_go()

    def _transact(self) -> Reading:
        self._sequence = following(self._sequence)
        words = self._exchange(self._sequence, self._kept)
        try:
            return self._wire.reading(words)
        except WireError:
            raise LinkError("crc") from None

    def _configure(self) -> Capabilities:
        self._lock = lock_rig(self.endpoint)
        try:
            self._connect()
            return self._identify().check(self._machine, self.endpoint)
        except WireError as error:
            self._let_go()
            raise self._error(str(error), "give the address of a rig") from None
        except BaseException:
            self._let_go()
            raise

    def _deactivate(self) -> None:
        self._kept = self._safe
        for _ in range(FAREWELLS):
            with suppress(LinkError):
                self._transact()
                return

    def _let_go(self) -> None:
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
        """Ask what is there; a DriverError if nothing answers, a WireError if it is not a rig."""

    @abstractmethod
    def _exchange(self, sequence: int, words: list[int]) -> Sequence[int]:
        """Send a command's words; return those of the reading that answers it, or raise a LinkError."""

    @abstractmethod
    def _disconnect(self) -> None:
        """Close the link, if it is open."""
