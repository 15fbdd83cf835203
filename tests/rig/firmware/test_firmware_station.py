"""The microcontroller's logic, with pins and time made up."""

from __future__ import annotations

import ast
import re
import shutil
import struct
import subprocess
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.rig import frames
from layflat.rig.device_state import DeviceState
from layflat.rig.driver import RigCommand, SensorReading
from layflat.rig.wire import Identity
from tests.programs import missing_reason
from tests.rig.devices import ARM, WIRE
from tests.rig.firmwares import FOLDER, firmware

SETTINGS = firmware("settings")
MS = 1000


class Pins:
    """Everything outside; time in microseconds, going round as the board's does."""

    def __init__(self, start: int = 0) -> None:
        self.now = start
        self.pressed = False
        self.incoming, self.outgoing = b"", b""
        self.driven: list[int] = []
        self.let_in = True
        self.on = 0
        self.lives = 0

    def ticks(self) -> int:
        return self.now % (1 << 30)

    def elapsed(self, then: int) -> int:
        return (self.now - then + (1 << 29)) % (1 << 30) - (1 << 29)

    def received(self) -> bytes:
        data, self.incoming = self.incoming, b""
        return data

    def send(self, data: bytes) -> None:
        self.outgoing += data

    def stopped(self) -> bool:
        return self.pressed

    def angle(self, joint: int) -> int:
        return 1000 + joint

    def pressure(self, joint: int) -> int:
        return 2000 + joint

    def supply(self) -> int:
        return 1638

    def drive(self, counts: list[int]) -> None:
        self.driven = list(counts)

    def air(self, on: bool) -> None:
        self.let_in = on

    def switch(self, outputs: int) -> None:
        self.on = outputs

    def alive(self) -> None:
        self.lives += 1


class OpenLoopRig:
    """A station, and a host that talks to it."""

    def __init__(self, start: int = 0, **other: Any) -> None:
        settings = SimpleNamespace(
            **{name: getattr(SETTINGS, name) for name in dir(SETTINGS) if name.isupper()} | other
        )
        self.pins = Pins(start)
        self.station = firmware("station").Station(self.pins, settings)
        self.sequence = 0

    def wait(self, us: int, step: int = 500) -> None:
        end = self.pins.now + us
        while self.pins.now < end:
            self.pins.now = min(self.pins.now + step, end)
            self.station.step()

    def say(
        self, voltages: list[float], *, air: bool = True, reset: bool = False, after: int = 5 * MS
    ) -> SensorReading:
        self.wait(after)
        self.sequence = (self.sequence + 1) & 0xFFFF
        return self.sent(self.sequence, WIRE.command_words(RigCommand(_array(voltages), air, reset)))

    def sent(self, sequence: int, words: list[int]) -> SensorReading:
        found = self.exchange(frames.encode(frames.COMMAND_FRAME, sequence, frames.pack_words(words)))
        assert [(frame.kind, frame.sequence) for frame in found] == [(frames.READING_FRAME, sequence)]
        return WIRE.reading(frames.unpack_words(found[0].payload))

    def exchange(self, data: bytes) -> list[frames.SerialFrame]:
        self.pins.incoming, self.pins.outgoing = data, b""
        self.station.step()
        return frames.Decoder().feed(self.pins.outgoing)

    def start(self) -> None:
        assert self.say([5.0, 5.0], air=False).device is DeviceState.DUMPED
        assert self.say([5.0, 5.0], air=False, reset=True).device is DeviceState.RUNNING

    @property
    def dumped(self) -> bool:
        """The air is let out at once, the valves open some time later."""
        if self.pins.let_in or self.pins.driven not in ([0x8000, 0x8000], [0xFFFF, 0xFFFF]):
            return False
        self.wait(SETTINGS.EMPTIES_AFTER)
        return not self.pins.let_in and self.pins.driven == [0xFFFF, 0xFFFF]

    def dither(self) -> list[list[int]]:
        """What each valve gets over a period."""
        found = []
        for _ in range(20):
            self.wait(MS)
            found.append(self.pins.driven)
        return [list(valve) for valve in zip(*found, strict=True)]


def _array(values: list[float]) -> Any:
    import numpy as np

    return np.array(values)


def test_it_says_what_the_machines_file_says() -> None:
    (told,) = OpenLoopRig().exchange(frames.encode(frames.IDENTIFY_FRAME, 77, b""))
    assert (told.kind, told.sequence) == (frames.IDENTITY_FRAME, 77)
    found = Identity.from_words(frames.unpack_words(told.payload))
    found.check(ARM, "here")
    assert found == Identity.for_machine(ARM)._replace(shortest_cycle=SETTINGS.SHORTEST_CYCLE)


def test_digital_outputs_stay_while_it_is_centred_and_are_off_once_it_dumps() -> None:
    bench = OpenLoopRig(OUTPUT_PINS=(10, 11))
    (told,) = bench.exchange(frames.encode(frames.IDENTIFY_FRAME, 77, b""))
    assert Identity.from_words(frames.unpack_words(told.payload)).check(ARM, "here").outputs == 2
    bench.start()
    wire = WIRE._replace(outputs=2)
    words = wire.command_words(RigCommand(_array([5.0, 5.0]), air=True, outputs=2))
    bench.sent(10, words)
    assert bench.pins.on == 2
    assert not bench.exchange(
        frames.encode(frames.COMMAND_FRAME, 11, frames.pack_words([words[0] | 0x0400, *words[1:]]))
    )
    bench.wait(SETTINGS.CENTRES_AFTER + 10 * MS)
    assert bench.pins.on == 2
    bench.wait(SETTINGS.DUMPS_AFTER)
    assert bench.pins.on == 0
    bench.sent(12, words)
    assert bench.pins.on == 0


def test_it_starts_with_the_air_out_and_runs_after_a_reset_alone() -> None:
    bench = OpenLoopRig()
    bench.wait(MS)
    assert bench.dumped
    assert bench.say([6.0, 5.0], reset=True).device is DeviceState.DUMPED, "no edge: it was never low"
    assert bench.say([6.0, 5.0]).device is DeviceState.DUMPED
    assert bench.dumped
    assert bench.say([6.0, 5.0], reset=True).device is DeviceState.RUNNING
    assert bench.pins.let_in


def test_it_obeys_and_tells_its_converters_counts() -> None:
    bench = OpenLoopRig(DITHER_AMPLITUDE=0.0)
    bench.start()
    reading = bench.say([7.5, 0.0])
    assert bench.pins.driven == [0xC000, 0]
    assert reading.angles.tolist() == [WIRE.angle.value(1000), WIRE.angle.value(1001)]
    assert reading.pressures.tolist() == [WIRE.pressure.value(2000), WIRE.pressure.value(2001)]
    assert reading.supply == WIRE.supply.value(1638)
    bench.say([7.5, 0.0], air=False)
    assert not bench.pins.let_in
    assert bench.pins.lives > 0


def test_the_dither_goes_both_ways_about_the_command_and_stays_in_range() -> None:
    bench = OpenLoopRig(CENTRES_AFTER=10**6, DUMPS_AFTER=10**6)
    bench.start()
    bench.say([5.0, 10.0])
    middle, top = bench.dither()
    amplitude = SETTINGS.DITHER_AMPLITUDE * 0x8000
    assert max(middle) - 0x8000 == pytest.approx(amplitude, rel=0.02)
    assert 0x8000 - min(middle) == pytest.approx(amplitude, rel=0.02)
    assert abs(sum(middle) / 20 - 0x8000) < 0.02 * amplitude
    assert max(top) == 0xFFFF
    assert min(top) == pytest.approx(0xFFFF - amplitude, rel=0.02)


@pytest.mark.parametrize("start", [0, (1 << 30) - 30 * MS])
def test_without_commands_it_centres_after_four_cycles_and_dumps_after_200_ms(start: int) -> None:
    bench = OpenLoopRig(start, DITHER_AMPLITUDE=0.0)
    bench.start()
    bench.say([8.0, 2.0])
    bench.wait(19 * MS)
    assert bench.pins.driven == [0xCCCD, 0x3333]
    bench.wait(MS)
    assert bench.pins.driven == [0x8000, 0x8000]
    assert bench.pins.let_in
    bench.wait(179 * MS)
    assert bench.pins.let_in
    bench.wait(MS)
    assert bench.dumped
    bench.wait(1000 * MS, step=5 * MS)
    assert bench.dumped


def test_centred_it_obeys_the_next_command() -> None:
    bench = OpenLoopRig(DITHER_AMPLITUDE=0.0)
    bench.start()
    assert bench.say([8.0, 2.0], after=50 * MS).device is DeviceState.RUNNING
    assert bench.pins.driven == [0xCCCD, 0x3333]


def test_dumped_it_obeys_after_the_edge_of_a_reset_alone() -> None:
    bench = OpenLoopRig()
    bench.start()
    bench.say([5.0, 5.0], reset=True)
    assert bench.say([5.0, 5.0], reset=True, after=300 * MS).device is DeviceState.DUMPED
    assert bench.say([5.0, 5.0], reset=True).device is DeviceState.DUMPED
    assert bench.dumped
    assert bench.say([5.0, 5.0]).device is DeviceState.DUMPED
    assert bench.say([5.0, 5.0], reset=True).device is DeviceState.RUNNING


def test_the_e_stop_dumps_at_once_and_stays() -> None:
    bench = OpenLoopRig()
    bench.start()
    bench.say([6.0, 6.0])
    bench.pins.pressed = True
    bench.station.step()
    assert bench.dumped
    reading = bench.say([6.0, 6.0])
    assert reading.stopped
    assert reading.device is DeviceState.DUMPED
    assert bench.say([6.0, 6.0], reset=True).device is DeviceState.DUMPED
    bench.pins.pressed = False
    assert bench.say([6.0, 6.0], reset=True).device is DeviceState.DUMPED
    assert bench.dumped
    bench.say([6.0, 6.0])
    assert bench.say([6.0, 6.0], reset=True).device is DeviceState.RUNNING


def test_commands_that_come_again_late_or_broken_are_not_obeyed() -> None:
    bench = OpenLoopRig(DITHER_AMPLITUDE=0.0)
    bench.start()
    bench.say([7.5, 7.5])
    old = WIRE.command_words(RigCommand(_array([0.0, 0.0]), air=True))
    for sequence in (bench.sequence, bench.sequence - 1, bench.sequence - 100, bench.sequence + 0x8000):
        assert bench.exchange(frames.encode(frames.COMMAND_FRAME, sequence & 0xFFFF, frames.pack_words(old))) == []
    bad = ([4, 0, 0], [1, 0], [1, 0, 0, 0])
    for number, words in enumerate(bad, bench.sequence + 1):
        assert bench.exchange(frames.encode(frames.COMMAND_FRAME, number, frames.pack_words(words))) == []
    assert bench.exchange(frames.encode(frames.READING_FRAME, bench.sequence + 1, frames.pack_words(old))) == []
    assert bench.pins.driven == [0xC000, 0xC000]
    bench.wait(20 * MS)
    assert bench.pins.driven == [0x8000, 0x8000], "they have fed the watchdog"


def test_who_asks_may_begin_with_any_number() -> None:
    bench = OpenLoopRig()
    bench.start()
    bench.exchange(frames.encode(frames.IDENTIFY_FRAME, 0, b""))
    bench.sequence -= 200
    assert bench.say([5.0, 5.0]).device is DeviceState.RUNNING


@given(st.lists(st.binary(max_size=80), max_size=6))
def test_any_bytes_are_survived_without_a_word_or_a_move(chunks: list[bytes]) -> None:
    bench = OpenLoopRig(DITHER_AMPLITUDE=0.0)
    bench.start()
    bench.say([7.5, 7.5])
    for chunk in chunks:
        assert bench.exchange(chunk) == []
    assert bench.pins.driven == [0xC000, 0xC000]
    bench.exchange(b"\0")
    assert bench.say([2.5, 2.5]).device is DeviceState.RUNNING
    assert bench.pins.driven == [0x4000, 0x4000]


def test_fine_converters_take_two_words() -> None:
    packed = firmware("station").packed
    assert packed(4096, 12) == b"\x10\x00"
    assert packed(1 << 24, 24) == b"\x01\x00\x00\x00"


class Wrapping:
    """The struct of MicroPython: what does not fit is taken by its lowest bits, without a word."""

    unpack = staticmethod(struct.unpack)

    @staticmethod
    def pack(form: str, *values: int) -> bytes:
        letters = re.sub(r"(\d+)(\w)", lambda found: int(found[1]) * found[2], form.lstrip(">"))
        bits = {"B": 8, "H": 16, "I": 32}
        return struct.pack(form, *(v % (1 << bits[letter]) for letter, v in zip(letters, values, strict=True)))


@pytest.fixture(params=["CPython's struct", "MicroPython's struct"])
def packing(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    if request.param.startswith("Micro"):
        assert Wrapping.pack(">H", 70000) == b"\x11p"
        for name in ("frames", "station"):
            monkeypatch.setattr(firmware(name), "struct", Wrapping)


@pytest.mark.usefixtures("packing")
@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("SHORTEST_CYCLE", 70000, "SHORTEST_CYCLE is 70000; it goes from 1 to 65535"),
        ("SHORTEST_CYCLE", 4000.0, "SHORTEST_CYCLE is 4000.0; it goes from 1 to 65535"),
        ("CENTRES_AFTER", 70_000_000, "CENTRES_AFTER is 70000000; it goes from 1000 to 65535999"),
        ("DUMPS_AFTER", 500, "DUMPS_AFTER is 500"),
        ("JOINTS", 70001, "JOINTS is 70001; it goes from 1 to 7"),
        ("ANGLE_BITS", 70000, "ANGLE_BITS is 70000"),
        ("VOLTAGE_HIGH", 70000, "VOLTAGE_HIGH is 70000; it goes from -32000 to 32000"),
        ("VOLTAGE_HIGH", -1, "VOLTAGE_HIGH less VOLTAGE_LOW is -1"),
        ("CENTRE_VOLTAGE", 10001, "CENTRE_VOLTAGE is 10001; it goes from 0 to 10000"),
        ("OUTPUT_PINS", tuple(range(9)), "number of OUTPUT_PINS is 9; it goes from 0 to 8"),
        ("DITHER_AMPLITUDE", 1.5, "DITHER_AMPLITUDE is 1.5; it goes from 0 to 1"),
        ("DITHER_PERIOD", 0, "DITHER_PERIOD is 0"),
    ],
)
def test_a_setting_that_does_not_fit_is_told_and_never_goes_out_as_another(
    name: str, value: Any, expected: str
) -> None:
    with pytest.raises(ValueError, match=re.escape(expected)):
        OpenLoopRig(**{name: value})


@pytest.mark.usefixtures("packing")
def test_settings_at_the_ends_of_their_ranges_go_out_as_they_are() -> None:
    ends = {"SHORTEST_CYCLE": 65535, "CENTRES_AFTER": 65535999, "VOLTAGE_LOW": -32000, "VOLTAGE_HIGH": 32000}
    (told,) = OpenLoopRig(**ends, CENTRE_VOLTAGE=-1).exchange(frames.encode(frames.IDENTIFY_FRAME, 65535, b""))
    found = Identity.from_words(frames.unpack_words(told.payload))
    assert (found.shortest_cycle, found.centres_after) == (65535, 65535)
    assert (found.voltage_low, found.voltage_high, found.centre_voltage) == (-32000, 32000, -1)


@pytest.mark.usefixtures("packing")
def test_a_count_that_no_converter_has_is_the_end_of_its_range() -> None:
    packed = firmware("station").packed
    assert packed(70000, 12) == packed(4096, 12) == b"\x10\0"
    assert packed(-1, 12) == b"\0\0"
    assert packed(1 << 33, 16) == b"\0\1\0\0"


@pytest.mark.usefixtures("packing")
@pytest.mark.parametrize(
    ("kind", "sequence", "size"), [(256, 0, 0), (-1, 0, 0), (1, 65536, 0), (1, -1, 0), (1, 0, 241)]
)
def test_a_frame_never_carries_another_number(kind: int, sequence: int, size: int) -> None:
    with pytest.raises(ValueError, match="it goes from 0 to"):
        firmware("frames").encode(kind, sequence, bytes(size))


@pytest.mark.skipif(shutil.which("micropython") is None, reason=missing_reason("MicroPython"))
def test_under_micropython_itself_settings_are_told_and_frames_are_those_of_the_host() -> None:
    script = """
import settings, station, frames
settings.SHORTEST_CYCLE = 70000
try:
    station.check(settings)
except ValueError as error:
    print(error)
print(frames.encode(1, 65535, bytes(range(240))))
print(station.packed(70000, 12))
"""
    done = subprocess.run(["micropython", "-c", script], cwd=FOLDER, capture_output=True, text=True, check=True)
    told, frame, packed = done.stdout.splitlines()
    assert told == "SHORTEST_CYCLE is 70000; it goes from 1 to 65535"
    assert ast.literal_eval(frame) == frames.encode(1, 65535, bytes(range(240)))
    assert ast.literal_eval(packed) == b"\x10\0"
