"""A rig behind a microcontroller on a serial port, mostly USB: frames of `wire.frames`."""

import os
from collections.abc import Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path

from serial import Serial, SerialException
from serial.tools.list_ports import comports

from layflat.machine.model import Machine
from layflat.rig.driver import DriverError, LinkError
from layflat.rig.drivers.linked import LinkedDriver, pieces
from layflat.rig.wire import frames
from layflat.rig.wire.content import WireError, following
from layflat.rig.wire.identity import Identity

ASKED = 10  # how often a device is asked who it is; some boot when the port is opened
WAIT = 0.2  # for each answer, s


class SerialDriver(LinkedDriver):
    """A rig at a serial port."""

    def __init__(self, machine: Machine, path: str) -> None:
        # By its one true name, so that two names of one port are one lock.
        super().__init__(machine, f"serial://{Path(path).resolve()}")
        self._path = path
        self._link = machine.interface.serial
        self._port: Serial | None = None
        self._file = -1
        self._decoder = frames.Decoder()

    def _connect(self) -> None:
        try:
            self._port = Serial(self._path, self._link.baud, timeout=0, write_timeout=0, exclusive=True)
            self._port.reset_input_buffer()
        except (SerialException, OSError, ValueError) as error:
            raise self._closed(error) from None
        self._file = self._port.fileno()

    def _identify(self) -> Identity:
        for _ in range(ASKED):
            self._sequence = following(self._sequence)
            with suppress(LinkError):
                words = self._ask(self._sequence, frames.IDENTIFY, [], frames.IDENTITY, WAIT)
                return Identity.from_words(words)
        what = "answers, but not in frames" if self._decoder.bad else "does not answer"
        raise self._error(what, "see that the firmware runs, and that interface.serial.baud fits")

    def _exchange(self, sequence: int, words: list[int]) -> Sequence[int]:
        return self._ask(sequence, frames.COMMAND, words, frames.READING, self._link.timeout)

    def _ask(self, sequence: int, kind: int, words: list[int], expected: int, patience: float) -> Sequence[int]:
        """Send a frame, and take the one that answers it; what answers another is stale."""
        bad, why = self._decoder.bad, "lost"
        try:
            os.write(self._file, frames.encode(kind, sequence, frames.as_bytes(words)))
            for piece in pieces(self._file, partial(os.read, self._file), patience):
                for frame in self._decoder.feed(piece):
                    if frame.kind == expected and frame.sequence == sequence:
                        return frames.as_words(frame.payload)
                    why = "sequence"
        except OSError:
            raise LinkError("lost") from None
        except WireError:
            raise LinkError("crc") from None
        raise LinkError("crc" if self._decoder.bad > bad else why)

    def _disconnect(self) -> None:
        if self._port is not None:
            self._port.close()
            self._file = -1

    def _closed(self, error: Exception) -> DriverError:
        """Why a port can't be opened, and what would help."""
        path = Path(self._path)
        if not path.exists():
            there = ", ".join(sorted(port.device for port in comports())) or "none"
            what, right = "is not there", f"serial ports that are: {there}"
        elif not path.is_char_device():
            what, right = "is not a serial port", "give one, such as serial:///dev/ttyACM0"
        elif not os.access(path, os.R_OK | os.W_OK):
            what, right = "you may not open it", f"join the group {_group(path)!r} and log in anew"
        else:
            what, right = f"can't be opened ({error})", "see that no other program has it"
        return self._error(what, right)


def _group(path: Path) -> str:
    try:
        return path.group()
    except KeyError:  # it has no name
        return str(path.stat().st_gid)
