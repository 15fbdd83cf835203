from __future__ import annotations

import asyncio
import os
from contextlib import suppress
from pathlib import Path

import pytest

from layflat.errors import OutputError
from layflat.rig import frames
from layflat.rig.clock import VirtualClock
from layflat.rig.device.serial_server import SerialStation
from layflat.rig.device.virtual import ReplyFault
from tests.rig.devices import ARM, WIRE, FakeDevice

SAFE = frames.pack_words([0, 0x8000, 0x8000])


FENCE = 0xFEED


async def said(path: str, *pieces: bytes) -> list[frames.SerialFrame]:
    """What comes back, in frames, until a last question is answered."""
    file = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    decoder, found = frames.Decoder(), list[frames.SerialFrame]()
    for piece in (*pieces, frames.encode(frames.IDENTIFY_FRAME, FENCE, b"")):
        os.write(file, piece)
        await asyncio.sleep(1e-3)
    while not found or found[-1].sequence != FENCE:
        await asyncio.sleep(1e-3)
        with suppress(BlockingIOError):
            found += decoder.feed(os.read(file, 4096))
    os.close(file)
    return found[:-1]


def test_it_answers_whole_frames_alone_and_each_command_once(tmp_path: Path) -> None:
    async def check() -> None:
        device = FakeDevice(VirtualClock())
        station = SerialStation(device, ARM)
        path = station.listen(tmp_path / "rig")
        command = frames.encode(frames.COMMAND_FRAME, 9, SAFE)
        assert [frame.kind for frame in await said(path, frames.encode(frames.IDENTIFY_FRAME, 3, b""))] == [
            frames.IDENTITY_FRAME
        ]
        (answer,) = await said(path, b"rubbish" + command[:5], command[:9], command[9:], command, command)
        assert answer == (frames.READING_FRAME, 9, frames.pack_words(WIRE.reading_words(device.reading())))
        assert len(device.obeyed) == 1
        bad = [
            frames.encode(frames.COMMAND_FRAME, 10, SAFE + b"\0\0"),
            frames.encode(frames.COMMAND_FRAME, 10, SAFE[:-1]),
        ]
        mine = [frames.encode(frames.READING_FRAME, 10, SAFE), frames.encode(0x55, 10, SAFE)]
        assert await said(path, *bad, *mine) == []
        assert len(device.obeyed) == 1
        station.close()

    asyncio.run(check())
    assert list(tmp_path.iterdir()) == []


def test_spoilt_replies_are_damaged_but_never_take_a_neighbour_along(tmp_path: Path) -> None:
    async def check() -> None:
        device = FakeDevice(VirtualClock())
        station = SerialStation(device, ARM)
        path = station.listen()
        for number in range(0, 200, 2):
            device.link.spoil(ReplyFault.CRC, 1)
            found = await said(path, *(frames.encode(frames.COMMAND_FRAME, number + more, SAFE) for more in range(2)))
            assert [frame.sequence for frame in found] == [number + 1]
        station.close()

    asyncio.run(check())


def test_a_name_that_is_taken(tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("mine")
    (tmp_path / "old").symlink_to("/dev/pts/gone")

    async def check() -> None:
        with pytest.raises(OutputError, match=r"taken: can't be made .*give a name that is free"):
            SerialStation(FakeDevice(VirtualClock()), ARM).listen(tmp_path / "taken")
        station = SerialStation(FakeDevice(VirtualClock()), ARM)
        assert station.listen(tmp_path / "old") == str(tmp_path / "old")
        assert (tmp_path / "old").is_char_device()
        station.close()

    asyncio.run(check())
    assert (tmp_path / "taken").read_text() == "mine"
