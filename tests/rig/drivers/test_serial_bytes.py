"""The serial driver against frames put together by hand: good, bad, stale and random."""

from __future__ import annotations

import os
import struct
import threading
import tty
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from zlib import crc32

import pytest
import serial
from cobs import cobs
from hypothesis import given
from hypothesis import strategies as st

from layflat.rig.driver import DriverError, LinkError
from layflat.rig.drivers import create_driver
from layflat.rig.drivers.serial import SerialDriver
from layflat.rig.wire import Identity
from tests.rig.devices import ARM, WIRE, patient

HASTY = patient(ARM, 0.03)
READING = [0x0004, 1638, 2048, 2048, 1000, 3000]
"""E-stop pressed, supply, both joints' angle and pressure."""

Reply = Callable[[int, int], bytes]


def frame(kind: int, sequence: int, words: list[int]) -> bytes:
    body = struct.pack(f">BBH{len(words)}H", 1, kind, sequence, *words)
    stuffed: bytes = cobs.encode(body + struct.pack(">I", crc32(body)))
    return b"\0" + stuffed + b"\0"


def good(kind: int, sequence: int) -> bytes:
    return frame(0x81, sequence, Identity.for_machine(ARM).words()) if kind == 1 else frame(0x82, sequence, READING)


class Terminal:
    """Answers each frame with what `reply` makes of its kind and number."""

    def __init__(self) -> None:
        self.reply: Reply = good
        self._near, self._device_state = os.openpty()
        tty.setraw(self._device_state)
        self.path = os.ttyname(self._device_state)
        threading.Thread(target=self._serve, daemon=True).start()

    def _serve(self) -> None:
        tail = b""
        with suppress(OSError):
            while data := os.read(self._near, 1000):
                *pieces, tail = (tail + data).split(b"\0")
                for piece in filter(None, pieces):
                    kind, sequence = struct.unpack_from(">xBH", cobs.decode(piece))
                    os.write(self._near, self.reply(kind, sequence))

    def hang_up(self) -> bytes:
        os.close(self._near)
        return b""

    def close(self) -> None:
        os.close(self._device_state)


@pytest.fixture(scope="module")
def terminal() -> Iterator[Terminal]:
    running = Terminal()
    yield running
    running.close()


@pytest.fixture
def driver(terminal: Terminal) -> Iterator[SerialDriver]:
    terminal.reply = good
    found = create_driver(f"serial://{terminal.path}", HASTY)
    assert isinstance(found, SerialDriver)
    found.configure()
    found.activate()
    yield found
    terminal.reply = good
    found.finalize()


def read_well(driver: SerialDriver) -> None:
    reading = driver.read()
    assert reading.stopped
    assert reading.angles.tolist() == [WIRE.angle.value(2048), WIRE.angle.value(1000)]
    assert reading.pressures.tolist() == [WIRE.pressure.value(2048), WIRE.pressure.value(3000)]
    assert reading.supply == WIRE.supply.value(1638)


def test_random_bytes_are_never_a_reading_and_cost_one_cycle(terminal: Terminal, driver: SerialDriver) -> None:
    @given(st.binary(max_size=300))
    def check(rubbish: bytes) -> None:
        terminal.reply = lambda *_: rubbish
        with pytest.raises(LinkError):
            driver.read()
        terminal.reply = good
        read_well(driver)

    check()


def test_a_reply_with_any_byte_damaged_is_no_reading(terminal: Terminal, driver: SerialDriver) -> None:
    for at in range(1, len(good(2, 0)) - 1):

        def damaged(kind: int, sequence: int, at: int = at) -> bytes:
            reply = good(kind, sequence)
            return reply[:at] + bytes([reply[at] ^ 1 << at % 8]) + reply[at + 1 :]

        terminal.reply = damaged
        with pytest.raises(LinkError):
            driver.read()
        terminal.reply = good
        read_well(driver)


@pytest.mark.parametrize(
    ("reply", "kind"),
    [
        (lambda *_: b"", "lost"),
        (lambda kind, sequence: good(kind, sequence)[:-3] + b"\0", "crc"),
        (lambda kind, sequence: good(kind, sequence - 1 & 0xFFFF), "sequence"),
        (lambda _, sequence: frame(0x02, sequence, [0, 0, 0]), "sequence"),
        (lambda _, sequence: frame(0x82, sequence, [0x0010, *READING[1:]]), "crc"),
        (lambda _, sequence: frame(0x82, sequence, [4, 1638, 5000, 0, 0, 0]), "crc"),
        (lambda _, sequence: frame(0x82, sequence, READING[:-1]), "crc"),
    ],
)
def test_each_kind_of_bad_reply(terminal: Terminal, driver: SerialDriver, reply: Reply, kind: str) -> None:
    terminal.reply = reply
    with pytest.raises(LinkError) as error:
        driver.read()
    assert error.value.kind == kind
    terminal.reply = good
    read_well(driver)


def test_stale_duplicate_and_reordered_replies_are_passed_over(terminal: Terminal, driver: SerialDriver) -> None:
    empty = frame(0x82, 0, [0, 0, 0, 0, 0, 0])

    def crowded(kind: int, sequence: int) -> bytes:
        stale = [frame(0x82, sequence - back & 0xFFFF, [0, 0, 0, 0, 0, 0]) for back in (1, 3, 2, 1)]
        return b"".join(stale) + empty[:9] + good(kind, sequence) + good(kind, sequence)

    terminal.reply = crowded
    for _ in range(5):
        read_well(driver)


def test_a_port_that_answers_otherwise(terminal: Terminal, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("layflat.rig.drivers.serial.IDENTIFY_TIMEOUT", 0.02)
    monkeypatch.setattr("layflat.rig.drivers.serial.MAX_IDENTIFY_ATTEMPTS", 3)
    for reply, what in (
        (lambda *_: b"", "does not answer; see that the firmware runs"),
        (lambda *_: b"\0ok\n\0", "answers, but not in frames"),
        (lambda _, sequence: frame(0x81, sequence, [7] * 14), "is not a rig of layflat's"),
    ):
        terminal.reply = reply
        with pytest.raises(DriverError, match=what):
            create_driver(f"serial://{terminal.path}", HASTY).configure()
    terminal.reply = good
    awake = iter([False, False, True])
    terminal.reply = lambda kind, sequence: good(kind, sequence) if next(awake) else b""
    driver = create_driver(f"serial://{terminal.path}", HASTY)
    driver.configure()
    driver.finalize()


def test_a_port_that_is_pulled_out_is_a_lost_reply_each_cycle() -> None:
    terminal = Terminal()
    driver = create_driver(f"serial://{terminal.path}", HASTY)
    driver.configure()
    driver.activate()
    read_well(driver)  # type: ignore[arg-type]
    terminal.reply = lambda *_: terminal.hang_up()
    for _ in range(3):
        with pytest.raises(LinkError, match="lost"):
            driver.read()
    driver.finalize()
    terminal.close()


def test_a_port_that_is_not_there() -> None:
    with pytest.raises(DriverError, match="serial:///dev/ttyNONE: is not there; serial ports that are: "):
        create_driver("serial:///dev/ttyNONE", ARM).configure()


def test_what_is_no_port(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    for path in (tmp_path, tmp_path / "file"):
        with pytest.raises(DriverError, match="is not a serial port"):
            create_driver(f"serial://{path}", ARM).configure()


def test_a_port_that_one_may_not_open(terminal: Terminal, monkeypatch: pytest.MonkeyPatch) -> None:
    def forbidden(*_: object, **__: object) -> None:
        raise serial.SerialException(13, "could not open port: Permission denied")

    monkeypatch.setattr("layflat.rig.drivers.serial.Serial", forbidden)
    monkeypatch.setattr(os, "access", lambda *_: False)
    with pytest.raises(DriverError, match=r"can't be opened without permission; join the group '\w+'"):
        create_driver(f"serial://{terminal.path}", ARM).configure()
    monkeypatch.setattr(os, "access", lambda *_: True)
    with pytest.raises(DriverError, match="can't be opened"):
        create_driver(f"serial://{terminal.path}", ARM).configure()


def test_two_names_of_a_port_are_one_rig(terminal: Terminal, driver: SerialDriver, tmp_path: Path) -> None:
    (tmp_path / "rig").symlink_to(terminal.path)
    with pytest.raises(DriverError, match="is driven by process"):
        create_driver(f"serial://{tmp_path / 'rig'}", HASTY).configure()
