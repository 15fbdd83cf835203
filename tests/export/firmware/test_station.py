"""The device of a rig in C does what the device in MicroPython does, byte for byte."""

import ctypes
import random
from types import SimpleNamespace
from typing import Any

import pytest

from layflat.export.firmware.station import DEVICE_FOLDER
from tests.export.firmware.c_devices import (
    MAX_JOINTS,
    WAVE,
    Bench,
    CBoard,
    build_library,
    c_int,
    int16,
    int32,
    size_t,
    uint8,
    uint16,
    uint32,
)  # fmt: skip
from tests.rig.firmwares import firmware


class Settings(ctypes.Structure):
    _fields_ = (
        *((name, uint8) for name in ("joints", "voltage_bits", "angle_bits", "pressure_bits", "supply_bits")),
        *((name, int16) for name in ("voltage_low", "voltage_high", "centre_voltage")),
        *((name, uint32) for name in ("centres_after", "dumps_after", "empties_after")),
        ("lets_down", c_int), ("shortest_cycle", uint16), ("dither_period", uint32), ("dither", int32 * WAVE),
        ("outputs", uint8),
    )  # fmt: skip


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Any:
    sources = DEVICE_FOLDER / "station.c", DEVICE_FOLDER / "frames.c"
    return build_library(tmp_path_factory.mktemp("station"), sources)


class CStation(CBoard):
    """Device in C on a bench."""

    def __init__(self, library: Any, bench: Bench, settings: Any, wave: list[int]) -> None:
        super().__init__(library, bench)
        s = settings
        self.settings = Settings(
            s.JOINTS, s.VOLTAGE_BITS, s.ANGLE_BITS, s.PRESSURE_BITS, s.SUPPLY_BITS, s.VOLTAGE_LOW, s.VOLTAGE_HIGH,
            s.CENTRE_VOLTAGE, s.CENTRES_AFTER, s.DUMPS_AFTER, s.EMPTIES_AFTER, s.LETS_DOWN, s.SHORTEST_CYCLE,
            s.DITHER_PERIOD, (int32 * WAVE)(*wave), len(s.OUTPUT_PINS),
        )  # fmt: skip
        self.memory = ctypes.create_string_buffer(size_t.in_dll(library, "station_bytes").value)
        library.station_start(self.memory, ctypes.byref(self.settings))

    def step(self) -> None:
        self.library.station_step(self.memory)


def described(rng: random.Random) -> Any:
    joints, low = rng.randint(1, MAX_JOINTS), rng.choice([0, -10000])
    return SimpleNamespace(
        JOINTS=joints, VOLTAGE_BITS=rng.randint(8, 16), ANGLE_BITS=rng.choice([12, 16, 24]),
        PRESSURE_BITS=rng.choice([12, 15, 16]), SUPPLY_BITS=rng.choice([8, 12, 16]), VOLTAGE_LOW=low,
        VOLTAGE_HIGH=10000, CENTRE_VOLTAGE=(low + 10000) // 2, CENTRES_AFTER=20000, DUMPS_AFTER=200000,
        EMPTIES_AFTER=100000, LETS_DOWN=rng.random() < 0.5, SHORTEST_CYCLE=4000,
        DITHER_AMPLITUDE=rng.choice([0.0, 0.166]), DITHER_PERIOD=20000, OUTPUT_PINS=tuple(range(rng.randint(0, 8))),
    )  # fmt: skip


def traffic(rng: random.Random, frames: Any, settings: Any, number: int) -> bytes:
    """Return bytes of a host: mostly good commands, and all that can be wrong with them."""
    flags = rng.choice([0, 1, 1, 1, 3, 2, 4, 1 | 1 << 8, 1 | 1 << 15])
    top = 2**settings.VOLTAGE_BITS - 1
    words = [flags, *(min(rng.choice([0, top, rng.randint(0, top), top + 1]), 0xFFFF) for _ in range(settings.JOINTS))]
    if rng.random() < 0.05:
        words.append(0)
    kind = frames.COMMAND if rng.random() < 0.9 else rng.choice([frames.IDENTIFY, frames.READING, 0x55])
    payload = b"".join(word.to_bytes(2, "big") for word in words) if kind == frames.COMMAND else b""
    data = bytearray(frames.encode(kind, number & 0xFFFF, payload))
    if rng.random() < 0.05:
        data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
    if rng.random() < 0.03:
        data += bytes(rng.randrange(1, 256) for _ in range(300))
    return bytes(data)


@pytest.mark.parametrize("seed", range(12))
def test_it_does_what_the_device_in_python_does(library: Any, seed: int) -> None:
    rng = random.Random(seed)
    frames, settings = firmware("frames"), described(rng)
    benches = Bench(settings.JOINTS), Bench(settings.JOINTS)
    python = firmware("station").Station(benches[0], settings)
    both = python, CStation(library, benches[1], settings, python.wave)
    number, states = rng.randrange(0x10000), set()
    for _ in range(1500):
        wait = rng.choice([100, 1000, 5000, 5000, 25000, 150000 if rng.random() < 0.1 else 5000])
        data = b""
        if rng.random() < 0.7:
            number += rng.choice([1, 1, 1, 1, 1, 1, 0, -1, 0x7FFF, 0x8000] if rng.random() < 0.1 else [1])
            data = traffic(rng, frames, settings, number)[: 64 if rng.random() < 0.98 else 20]
        counts = [
            rng.randint(0, 2**bits)
            for bits in (settings.SUPPLY_BITS, *[settings.ANGLE_BITS, settings.PRESSURE_BITS] * settings.JOINTS)
        ]
        is_open = rng.random() < 0.02
        for bench in benches:
            bench.time, bench.open, bench.counts, bench.sent = bench.time + wait, is_open, counts, b""
            bench.bytes += data
        for one in both:
            one.step()
        a, b = benches
        assert (a.sent, a.driven, bool(a.on), a.switched) == (b.sent, b.driven, b.on, b.switched)
        states.add(python.state)
    assert states == {0, 1, 2}
