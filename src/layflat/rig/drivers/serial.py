"""A rig behind a microcontroller on a serial port, mostly USB: frames of `rig/frames.py`."""

import os
from collections.abc import Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path

from serial import Serial, SerialException
from serial.tools.list_ports import comports

from layflat.machine.model import Machine
from layflat.rig import frames
from layflat.rig.driver import DriverError, LinkError
from layflat.rig.drivers.linked import LinkedDriver, read_pieces
from layflat.rig.wire import Identity, WireError, next_sequence

MAX_IDENTIFY_ATTEMPTS = 10  # requests for the identity; some devices boot when the port is opened
IDENTIFY_TIMEOUT = 0.2  # for each reply, s


class SerialDriver(LinkedDriver):
    """Driver of a rig at a serial port."""

    def __init__(self, machine: Machine, path: str) -> None:
        # By its canonical name, so that two names of one port share one lock.
        super().__init__(machine, f"serial://{Path(path).resolve()}")
        self._path = path
        self._link = machine.interface.serial
        self._port: Serial | None = None
        self._file = -1
        self._decoder = frames.Decoder()

    def _connect(self) -> None:
        """Open the serial port exclusively and drop received bytes; raise DriverError if it can't be opened."""
        try:
            self._port = Serial(self._path, self._link.baud, timeout=0, write_timeout=0, exclusive=True)
            self._port.reset_input_buffer()
        except (SerialException, OSError, ValueError) as error:
            raise self._closed(error) from None
        self._file = self._port.fileno()

    def _identify(self) -> Identity:
        """Return the microcontroller's identity; raise DriverError if `MAX_IDENTIFY_ATTEMPTS` requests bring none."""
        for _ in range(MAX_IDENTIFY_ATTEMPTS):
            self._sequence = next_sequence(self._sequence)
            with suppress(LinkError):
                words = self._request(
                    self._sequence, frames.IDENTIFY_FRAME, [], frames.IDENTITY_FRAME, IDENTIFY_TIMEOUT
                )
                return Identity.from_words(words)
        what = "answers, but not in frames" if self._decoder.bad else "does not answer"
        raise self._error(what, "see that the firmware runs, and that interface.serial.baud fits")

    def _exchange(self, sequence: int, words: list[int]) -> Sequence[int]:
        return self._request(sequence, frames.COMMAND_FRAME, words, frames.READING_FRAME, self._link.timeout)

    def _request(self, sequence: int, kind: int, words: list[int], expected: int, patience: float) -> Sequence[int]:
        """Send a frame and return the words of the one that answers it, with this kind and number; others are dropped.

        Raises:
            LinkError: no such frame came within `patience` seconds; the kind tells what came in its place.
        """
        bad, why = self._decoder.bad, "lost"
        try:
            os.write(self._file, frames.encode(kind, sequence, frames.pack_words(words)))
            for piece in read_pieces(self._file, partial(os.read, self._file), patience):
                for frame in self._decoder.feed(piece):
                    if frame.kind == expected and frame.sequence == sequence:
                        return frames.unpack_words(frame.payload)
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
        """Return, without raising it, the error of a port that can't be opened, with cause and remedy."""
        path = Path(self._path)
        if not path.exists():
            there = ", ".join(sorted(port.device for port in comports())) or "none"
            what, right = "is not there", f"serial ports that are: {there}"
        elif not path.is_char_device():
            what, right = "is not a serial port", "give one, such as serial:///dev/ttyACM0"
        elif not os.access(path, os.R_OK | os.W_OK):
            what, right = "can't be opened without permission", f"join the group {_group_name(path)!r} and log in anew"
        else:
            what, right = f"can't be opened ({error})", "see that no other program has it"
        return self._error(what, right)


def _group_name(path: Path) -> str:
    """Return the name of the group that owns a file, or its number as text."""
    try:
        return path.group()
    except KeyError:  # it has no name
        return str(path.stat().st_gid)
