"""The firmware that runs the law, on simulated boards: cycles of a loop replayed, number by number."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from layflat.arrays import Array
from layflat.export.firmware.station import DEVICE_FOLDER
from layflat.export.targets import EXPORT_TARGETS
from layflat.machine import load
from layflat.rig.safety.requests import RequestWire
from layflat.rig.wire import Wire
from tests.export.firmware.boards import BOARDS, SOURCES, WHOLE_CHECK, execute, link, require_tools
from tests.export.firmware.controllers import CController, Firmware
from tests.export.firmware.loop_cycles import Cycle, counts_of, request_frame, run_cycles
from tests.export.firmware.recordings import REALS

JOINTS, FRAME, SENT, NUMBERS_EVERY = 7, 256, 2048, 20  # as in board/replay.c and station.h
GIVEN = np.dtype([
    ("time", np.uint32), ("stopped", np.int32), ("supply", np.uint32), ("joints", np.uint32, (2, JOINTS)),
    ("size", np.uint32), ("bytes", np.uint8, FRAME),
])  # fmt: skip
MADE = np.dtype([
    ("air", np.int32), ("outputs", np.uint8), ("_", np.uint8, 3), ("voltage", np.uint32, JOINTS),
    ("ticks", np.uint32), ("stack", np.uint32), ("size", np.uint32), ("bytes", np.uint8, SENT),
])  # fmt: skip


class Limits(NamedTuple):
    """Limits of a firmware."""

    instructions: int  # of a cycle in which a request is answered
    flash: int  # bytes
    ram: int  # with the stack, bytes


def given_rows(machine: Any, cycles: list[Cycle]) -> Any:
    """Return what a board reads and hears in each cycle."""
    wire, requests, n = Wire.for_machine(machine), RequestWire.for_machine(machine), len(machine.joints)
    rows = np.zeros(len(cycles), GIVEN)
    for k, cycle in enumerate(cycles):
        frame, counts = request_frame(requests, k, cycle.request), counts_of(wire, cycle.reading)
        rows[k]["time"], rows[k]["stopped"], rows[k]["supply"] = cycle.time, cycle.reading.stopped, counts[0]
        rows[k]["joints"][:, :n] = np.reshape(counts[1:], (n, 2)).T
        rows[k]["size"], rows[k]["bytes"][: len(frame)] = len(frame), list(frame)
    return rows


class Here:
    """The same cycles on this computer."""

    def __init__(self, library: Any, rows: Any, joints: int) -> None:
        device = CController(library, joints)
        self.made, self.numbers = np.zeros(len(rows), MADE), list[Array]()
        for k, row in enumerate(rows):
            bench = device.bench
            bench.time, bench.open, bench.sent = int(row["time"]), bool(row["stopped"]), b""
            bench.counts = [int(row["supply"]), *row["joints"][:, :joints].T.ravel().tolist()]
            bench.bytes = bytes(row["bytes"][: row["size"]])
            device.step()
            made = self.made[k]
            made["air"], made["outputs"], made["voltage"][:joints] = bench.on, bench.switched, bench.driven
            made["size"], made["bytes"][: len(bench.sent)] = len(bench.sent), list(bench.sent)
            if k % NUMBERS_EVERY == 0:
                self.numbers.append(device.numbers("memory", "results"))


def read_results(path: Path, count: int, numbers: np.dtype[Any]) -> tuple[Any, Any]:
    """Return what a board made in each cycle, and its numbers in some."""
    data, made, kept, at = path.read_bytes(), [], [], 0
    for k in range(count):
        made.append(np.frombuffer(data, MADE, 1, at)[0])
        at += MADE.itemsize
        if k % NUMBERS_EVERY == 0:
            kept.append(np.frombuffer(data, numbers, 1, at)[0])
            at += numbers.itemsize
    assert at == len(data)
    return np.array(made), np.array(kept)


@pytest.mark.parametrize(
    ("name", "target", "precision", "seconds", "limits"),
    [
        ("paper-arm", "cortex-m7", "double", 4.0, Limits(18_000, 64 * 1024, 8 * 1024)),
        *(
            pytest.param(*row, marks=WHOLE_CHECK)
            for row in (
                ("paper-arm", "cortex-m7", "double", 62.0, Limits(18_000, 64 * 1024, 8 * 1024)),
                ("paper-arm-tracking", "cortex-m7", "double", 62.0, Limits(40_000, 128 * 1024, 16 * 1024)),
                ("paper-arm", "cortex-m4f", "single", 62.0, Limits(22_000, 64 * 1024, 8 * 1024)),
                ("paper-arm-tracking", "cortex-m4f", "single", 62.0, Limits(43_000, 128 * 1024, 16 * 1024)),
            )
        ),
    ],
)
def test_a_board_does_in_every_cycle_what_this_computer_does(
    name: str, target: str, precision: str, seconds: float, limits: Limits, tmp_path: Path
) -> None:
    require_tools()
    machine, board = load(name), BOARDS[target]
    firmware, here, there = Firmware(machine, precision), tmp_path / "here", tmp_path / "there"
    here.mkdir()
    there.mkdir()
    rows = given_rows(machine, list(run_cycles(machine, seconds)))
    expected = Here(firmware.build(here), rows, len(machine.joints))
    sources, objects = firmware.write(there, EXPORT_TARGETS[target])
    for header in DEVICE_FOLDER.glob("*.h"):
        (there / header.name).write_text(header.read_text())
    image = link(board, [*sources, SOURCES / "replay.c"], objects, there)
    rows.tofile(there / "in.bin")
    execute(image, timeout=1200.0)
    real = REALS[precision]
    made, numbers = read_results(there / "out.bin", len(rows), np.dtype((real, expected.numbers[0].size)))
    n = len(machine.joints)
    for field in ("air", "outputs", "size"):
        np.testing.assert_array_equal(made[field], expected.made[field])
    np.testing.assert_array_equal(made["voltage"][:, :n], expected.made["voltage"][:, :n])
    np.testing.assert_array_equal(numbers, np.array(expected.numbers))
    sent = [row["bytes"][: row["size"]].tobytes() for row in made]
    assert sent == [row["bytes"][: row["size"]].tobytes() for row in expected.made]
    used = image.ram - GIVEN.itemsize - MADE.itemsize + int(made["stack"][-1])
    figures = Limits(int(made["ticks"].max() * board.tick), image.flash, used)
    assert all(figure < limit for figure, limit in zip(figures, limits, strict=True)), figures
