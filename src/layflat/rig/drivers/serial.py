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
from layflat.rig.driver import DriverError, LinkError, RigCommand, SensorReading
from layflat.rig.drivers.linked import LinkedDriver, read_pieces
from layflat.rig.safety.requests import DeviceRequest, DeviceStatus, RequestWire, settings_digest
from layflat.rig.wire import LAW_VERSION, VERSION, Identity, WireError, next_sequence

MAX_IDENTIFY_ATTEMPTS = 10  # requests for the identity; some devices boot when the port is opened
IDENTIFY_TIMEOUT = 0.2  # for each reply, s


class SerialDriver(LinkedDriver):
    """Driver of a rig at a serial port; a device that runs the control law itself gets requests, and no commands."""

    def __init__(self, machine: Machine, path: str) -> None:
        # By its canonical name, so that two names of one port share one lock.
        super().__init__(machine, f"serial://{Path(path).resolve()}")
        self._path = path
        self._link = machine.interface.serial
        self._port: Serial | None = None
        self._file = -1
        self._decoder = frames.Decoder()
        self._requests = RequestWire.for_machine(machine)
        self._request = self._idle_request = DeviceRequest.first(len(machine.joints))
        self.status: DeviceStatus | None = None  # last status of a device that runs the control law

    def request(self, request: DeviceRequest) -> None:
        """Store a request for the next `read`, to a device that runs the control law."""
        self._request = request

    def write(self, command: RigCommand) -> None:
        """Store a command for the next `read`; raise DriverError if the device runs the control law itself."""
        if self.runs_law:
            raise self._error("runs its control law itself, and obeys no voltages", "let the loop send requests")
        super().write(command)

    def _transact(self) -> SensorReading:
        if not self.runs_law:
            return super()._transact()
        self._sequence = next_sequence(self._sequence)
        kinds = [frames.STATUS_FRAME, *[frames.SIGNALS_FRAME] * self._requests.joints]
        payload = self._requests.request_bytes(self._request)
        try:
            payloads = self._transfer(self._sequence, frames.REQUEST_FRAME, payload, kinds, self._link.timeout)
            self.status = self._requests.status(payloads)
        except WireError:
            raise LinkError("crc") from None
        return self.status.reading

    def _deactivate(self) -> None:
        """Request a stop of a device that runs the control law; centre the valves of another, and vent its line."""
        starts, stops, holds, resets = self._request.edges
        self._request = self._idle_request._replace(edges=(starts, stops + 1, holds, resets))
        super()._deactivate()

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
                words = self._ask(self._sequence, frames.IDENTIFY_FRAME, [], frames.IDENTITY_FRAME, IDENTIFY_TIMEOUT)
                identity = Identity.from_words(words, (VERSION, LAW_VERSION))
                self.runs_law = identity.runs_law
                if self.runs_law and identity.digest != settings_digest(self._machine):
                    what = (
                        f"the rig runs a control law that was exported from another machine than {self._machine.name!r}"
                    )
                    raise self._error(what, "give the description of this rig, or export it anew (layflat export)")
                return identity
        what = "answers, but not in frames" if self._decoder.bad else "does not answer"
        raise self._error(what, "see that the firmware runs, and that interface.serial.baud fits")

    def _exchange(self, sequence: int, words: list[int]) -> Sequence[int]:
        return self._ask(sequence, frames.COMMAND_FRAME, words, frames.READING_FRAME, self._link.timeout)

    def _ask(self, sequence: int, kind: int, words: list[int], expected: int, patience: float) -> Sequence[int]:
        """Send words in a frame and return those of the one that answers it; see `_transfer`."""
        try:
            return frames.unpack_words(
                self._transfer(sequence, kind, frames.pack_words(words), [expected], patience)[0]
            )
        except WireError:
            raise LinkError("crc") from None

    def _transfer(
        self, sequence: int, kind: int, payload: bytes, expected: Sequence[int], patience: float
    ) -> list[bytes]:
        """Send a frame and return the payloads of those that answer it.

        Args:
            sequence: number of the transaction; frames with another are dropped.
            kind: kind of the frame.
            payload: its content.
            expected: kinds of the frames that answer it, in turn.
            patience: time within which they have to come, s.

        Raises:
            LinkError: they did not come in time; the kind tells what came in their place.
        """
        bad, why, payloads = self._decoder.bad, "lost", list[bytes]()
        try:
            os.write(self._file, frames.encode(kind, sequence, payload))
            for piece in read_pieces(self._file, partial(os.read, self._file), patience):
                for frame in self._decoder.feed(piece):
                    if frame.sequence != sequence or frame.kind != expected[len(payloads)]:
                        why = "sequence"
                        continue
                    payloads.append(frame.payload)
                    if len(payloads) == len(expected):
                        return payloads
        except OSError:
            raise LinkError("lost") from None
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
