"""The microcontroller's board without its chip: its modules run here, with converters that answer bit by bit."""

from __future__ import annotations

import importlib
import io
import sys
import types
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from tests.rig.firmwares import FOLDER, firmware


def settings_module(text: str) -> types.ModuleType:
    """Return the module of a text of settings."""
    module = types.ModuleType("settings")
    exec(text, module.__dict__)  # the text is what is tested
    return module


def converted(asked: bytes, counts: list[int], bits: int) -> bytes:
    """Return the bytes that a converter sends while it is sent others, from their data sheets' timing.

    MCP3208 (12): start, single-ended, D2, D1, D0, a clock to sample, a null bit, the count. ADS8344 (16): start, A2
    (lowest bit of the channel), A1 and A0, 0, single-ended, PD1, PD0, a busy clock, the count.
    """
    stream = "".join(f"{byte:08b}" for byte in asked)
    start = stream.index("1")
    if bits == 12:
        assert stream[start + 1] == "1", "single-ended"
        channel, first = int(stream[start + 2 : start + 5], 2), start + 7
    else:
        assert (stream[start + 4 : start + 8]) == "0111", "single-ended, always on"
        channel, first = int(stream[start + 2 : start + 4] + stream[start + 1], 2), start + 9
    answer = "0" * first + f"{counts[channel]:0{bits}b}"
    return int(answer.ljust(8 * len(asked), "1")[: 8 * len(asked)], 2).to_bytes(len(asked), "big")


class FakeBoard:
    """State of pins, PWM outputs and converters by GPIO, and the serial line."""

    def __init__(self, settings: Any, counts: list[int]) -> None:
        self.settings, self.counts = settings, counts
        self.pins: dict[int, int] = {settings.STOP_PIN: 1}
        self.duties: dict[int, int] = {}
        self.received, self.sent, self.now = b"", io.BytesIO(), 0

    def answer(self, asked: bytes, into: bytearray) -> None:
        """Exchange bytes with the one converter that is selected."""
        (chosen,) = [i for i, pin in enumerate(self.settings.ADC_SELECTS) if not self.pins[pin]]
        into[:] = converted(
            bytes(asked), self.counts[8 * chosen : 8 * chosen + 8], getattr(self.settings, "ADC_BITS", 12)
        )

    def modules(self) -> dict[str, types.ModuleType]:
        """Return MicroPython's modules of the board."""
        board = self

        class Pin:
            OUT, IN, PULL_DOWN, PULL_UP = range(4)

            def __init__(self, gpio: int, *_: int, value: int | None = None) -> None:
                self.gpio = gpio
                if value is not None:
                    board.pins[gpio] = value

            def value(self, level: int | None = None) -> int:
                if level is not None:
                    board.pins[self.gpio] = int(level)
                return board.pins[self.gpio]

        class PWM:
            def __init__(self, pin: Pin, *, freq: int, duty_u16: int) -> None:
                self.gpio = pin.gpio
                assert freq == 20000
                self.duty_u16(duty_u16)

            def duty_u16(self, duty: int) -> None:
                board.duties[self.gpio] = duty

        def spi(bus: int, *, baudrate: int, sck: Pin, mosi: Pin, miso: Pin) -> Any:
            assert baudrate <= 1_000_000  # MCP3208 at 2.7 V
            assert (bus, miso.gpio % 4, sck.gpio % 4, mosi.gpio % 4) == (0, 0, 2, 3), "pins of bus 0"
            assert all(pin.gpio // 8 in {0, 2} for pin in (miso, sck, mosi)), "pins of bus 0"
            return types.SimpleNamespace(write_readinto=board.answer)

        poll = types.SimpleNamespace(register=lambda *_: None, poll=lambda _: bool(board.received))
        contents: dict[str, dict[str, Any]] = {
            "machine": {"Pin": Pin, "PWM": PWM, "SPI": spi, "WDT": lambda **_: types.SimpleNamespace(feed=int)},
            "micropython": {"kbd_intr": lambda _: None},
            "select": {"poll": lambda: poll, "POLLIN": 1},
            "time": {"ticks_us": lambda: board.now, "ticks_diff": lambda one, other: one - other},
        }
        found = {name: types.ModuleType(name) for name in contents}
        for name, module in found.items():
            module.__dict__.update(contents[name])
        return found

    def read(self, size: int) -> bytes:
        """Return the next bytes of the serial line."""
        data, self.received = self.received[:size], self.received[size:]
        return data

    def write(self, data: bytes) -> None:
        """Send bytes."""
        self.sent.write(data)


@contextmanager
def running(settings: Any, counts: list[int]) -> Iterator[tuple[FakeBoard, Any]]:
    """Run `pico.py` and `station.py` on a fake board; yield the board and the station."""
    board = FakeBoard(settings, counts)
    fakes = board.modules()
    kept = {name: sys.modules.get(name) for name in (*fakes, "pico")}
    sys.modules.update(fakes)
    sys.path.insert(0, str(FOLDER))
    try:
        pico = importlib.import_module("pico")
    finally:
        sys.path.remove(str(FOLDER))
        for name, module in kept.items():
            if module is None:
                sys.modules.pop(name, None)
            else:
                sys.modules[name] = module
    line = types.SimpleNamespace(buffer=board)
    pico.sys = types.SimpleNamespace(stdin=line, stdout=line)  # type: ignore[attr-defined]
    yield board, firmware("station").Station(pico.PicoIO(settings), settings)
