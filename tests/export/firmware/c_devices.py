"""Devices in C on this computer: their sources as a library, whose board is a bench in Python."""

import ctypes
import shutil
import subprocess
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pytest

from layflat.export.firmware.station import DEVICE_FOLDER

WAVE, MAX_JOINTS = 32, 7
uint8, uint16, uint32, int16, int32, c_int, size_t = (
    ctypes.c_uint8, ctypes.c_uint16, ctypes.c_uint32, ctypes.c_int16, ctypes.c_int32, ctypes.c_int, ctypes.c_size_t,
)  # fmt: skip
FLAGS = (
    "-shared -fPIC -O1 -std=c99 -ffp-contract=off -Wall -Wextra -Wpedantic -Wconversion -Werror -fsanitize=undefined "
    "-fno-sanitize-recover"
)
BOARD = """
#include "station.h"
void (*sample)(station_samples *);
void (*driven)(const station_outputs *);
size_t (*receive)(uint8_t *, size_t);
void (*sent)(const uint8_t *, size_t);
void board_sample(station_samples *samples) { sample(samples); }
void board_drive(const station_outputs *outputs) { driven(outputs); }
size_t board_receive(uint8_t *bytes, size_t size) { return receive(bytes, size); }
void board_send(const uint8_t *bytes, size_t size) { sent(bytes, size); }
extern const size_t station_bytes;
const size_t station_bytes = sizeof(station);
"""


class Samples(ctypes.Structure):
    _fields_ = (
        ("time", uint32), ("stopped", c_int), ("supply", uint32), ("angle", uint32 * MAX_JOINTS),
        ("pressure", uint32 * MAX_JOINTS),
    )  # fmt: skip


class Outputs(ctypes.Structure):
    _fields_ = (("air", c_int), ("outputs", uint8), ("voltage", uint32 * MAX_JOINTS))


class Bench:
    """Inputs and outputs of a device: what it reads is set, what it does is kept; serves the device in Python, too."""

    def __init__(self, joints: int) -> None:
        self.time, self.open, self.counts = 0, False, [0] * (1 + 2 * joints)
        self.joints, self.bytes = joints, b""
        self.sent, self.driven, self.on, self.switched = b"", [0] * joints, False, 0

    def ticks(self) -> int:
        return self.time

    def elapsed(self, then: int) -> int:
        return (self.time - then) & 0xFFFFFFFF

    def received(self) -> bytes:
        data, self.bytes = self.bytes, b""
        return data

    def send(self, data: bytes) -> None:
        self.sent += data

    def stopped(self) -> bool:
        return self.open

    def supply(self) -> int:
        return self.counts[0]

    def angle(self, joint: int) -> int:
        return self.counts[1 + 2 * joint]

    def pressure(self, joint: int) -> int:
        return self.counts[2 + 2 * joint]

    def drive(self, counts: list[int]) -> None:
        self.driven = list(counts)

    def air(self, on: bool) -> None:
        self.on = on

    def switch(self, outputs: int) -> None:
        self.switched = outputs

    def alive(self) -> None: ...


def build_library(folder: Path, sources: Iterable[Path], objects: Iterable[Path] = ()) -> Any:
    """Return a library of sources in a folder, which also holds their headers, with the board; skip without tools."""
    if shutil.which("cc") is None:
        pytest.skip("needs a C compiler: cc")
    (folder / "board.c").write_text(BOARD)
    command: list[str | Path] = [
        "cc",
        *FLAGS.split(),
        f"-I{folder}",
        f"-I{DEVICE_FOLDER}",
        folder / "board.c",
        *sources,
        *objects,
    ]
    done = subprocess.run([*command, "-lm", "-o", folder / "device.so"], capture_output=True, text=True, check=False)
    if done.returncode or done.stderr:
        pytest.fail(done.stderr)
    return ctypes.CDLL(str(folder / "device.so"))


class CBoard:
    """Board of a library on a bench."""

    def __init__(self, library: Any, bench: Bench) -> None:
        self.bench, self.library = bench, library
        kinds: dict[str, tuple[Any, Any]] = {
            "sample": (self.sample, ctypes.CFUNCTYPE(None, ctypes.POINTER(Samples))),
            "driven": (self.driven, ctypes.CFUNCTYPE(None, ctypes.POINTER(Outputs))),
            "receive": (self.receive, ctypes.CFUNCTYPE(size_t, ctypes.POINTER(uint8), size_t)),
            "sent": (self.sent, ctypes.CFUNCTYPE(None, ctypes.POINTER(uint8), size_t)),
        }
        self.callbacks = []
        for name, (function, kind) in kinds.items():
            self.callbacks.append(kind(function))
            ctypes.c_void_p.in_dll(library, name).value = ctypes.cast(self.callbacks[-1], ctypes.c_void_p).value

    def sample(self, samples: Any) -> None:
        bench, out = self.bench, samples.contents
        out.time, out.stopped, out.supply = bench.time, bench.open, bench.supply()
        for j in range(bench.joints):
            out.angle[j], out.pressure[j] = bench.angle(j), bench.pressure(j)

    def driven(self, outputs: Any) -> None:
        out = outputs.contents
        self.bench.on, self.bench.switched = bool(out.air), out.outputs
        self.bench.driven = list(out.voltage[: self.bench.joints])

    def receive(self, into: Any, size: int) -> int:
        data, self.bench.bytes = self.bench.bytes[:size], self.bench.bytes[size:]
        ctypes.memmove(into, data, len(data))
        return len(data)

    def sent(self, data: Any, size: int) -> None:
        self.bench.send(bytes(data[:size]))
