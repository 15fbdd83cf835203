"""The device in C on a simulated board answers its host over a serial line."""

import os
import re
import subprocess
import tty
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from layflat.export.firmware.station import DEVICE_FOLDER, station_settings
from layflat.machine import load
from layflat.rig import frames
from layflat.rig.device_state import DeviceState
from layflat.rig.driver import RigCommand
from layflat.rig.drivers.linked import read_pieces
from layflat.rig.wire import Identity, Wire
from tests.export.firmware.boards import BOARDS, link, require_tools

ARM, WIRE = load("paper-arm"), Wire.for_machine(load("paper-arm"))
PATIENCE = 20.0  # for a reply of the simulated processor, s
FLASH, RAM = 8 * 1024, 4 * 1024  # bytes that are enough


@pytest.fixture(scope="module", params=["cortex-m7", "cortex-m4f"])
def line(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[int]:
    """Serial line of a board with the device."""
    require_tools()
    folder, board = tmp_path_factory.mktemp("station"), BOARDS[request.param]._replace(flash=FLASH, ram=RAM)
    (folder / "settings.c").write_text(station_settings(ARM))
    for name in ("frames.h", "station.h"):
        (folder / name).write_text((DEVICE_FOLDER / name).read_text())
    sources = [DEVICE_FOLDER / f"{name}.c" for name in ("frames", "station", "station_main", "board_mps2")]
    image = link(board, [folder / "settings.c", *sources], [], folder)
    command: list[str | Path] = [*board.emulator.split(), "-serial", "pty", "-kernel", image.path]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        path = re.search(r"/dev/pts/\d+", process.stdout.readline())
        assert path is not None
        file = os.open(Path(path[0]), os.O_RDWR | os.O_NOCTTY)
        tty.setraw(file)
        yield file
        os.close(file)
        process.kill()


def request_words(file: int, kind: int, sequence: int, words: list[int]) -> frames.SerialFrame:
    """Return the frame that answers one."""
    decoder = frames.Decoder()
    os.write(file, frames.encode(kind, sequence, frames.pack_words(words)))
    for piece in read_pieces(file, lambda size: os.read(file, size), PATIENCE):
        for frame in decoder.feed(piece):
            if frame.sequence == sequence:
                return frame
    raise AssertionError("no answer")


def test_it_identifies_itself_as_the_machine_s_device(line: int) -> None:
    frame = request_words(line, frames.IDENTIFY_FRAME, 7, [])
    assert frame.kind == frames.IDENTITY_FRAME
    identity = Identity.from_words(frames.unpack_words(frame.payload))
    assert identity == Identity.for_machine(ARM)
    identity.check(ARM, "board")


def test_it_obeys_after_a_reset_and_dumps_when_nobody_speaks(line: int) -> None:
    request_words(line, frames.IDENTIFY_FRAME, 100, [])
    states = []
    for number, reset in enumerate((False, True, True)):
        words = WIRE.command_words(RigCommand(np.array([6.0, 4.0]), air=True, reset=reset))
        frame = request_words(line, frames.COMMAND_FRAME, 101 + number, words)
        assert frame.kind == frames.READING_FRAME
        states.append(WIRE.reading(frames.unpack_words(frame.payload)).device)
    assert states[0] is DeviceState.DUMPED
    assert states[1] is DeviceState.RUNNING
