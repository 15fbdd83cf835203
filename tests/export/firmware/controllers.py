"""Devices in C that run the law themselves, on a bench of this computer."""

import ctypes
from pathlib import Path
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.export.compiled import object_file, portable_entry
from layflat.export.firmware.controller import controller_sources
from layflat.export.firmware.station import DEVICE_FOLDER
from layflat.export.firmware.supervisor import SupervisorEntries
from layflat.export.header import Api
from layflat.export.targets import Target
from layflat.jit.objects import host
from layflat.machine import Machine
from layflat.rig import frames
from tests.export.firmware.c_devices import Bench, CBoard, build_library, size_t

ENDS = """
#include "controller.h"
#define PART(part) \\
    extern const size_t controller_##part, controller_##part##_bytes; \\
    const size_t controller_##part = offsetof(controller, part); \\
    const size_t controller_##part##_bytes = sizeof(((controller *)0)->part);
PART(inputs)
PART(memory)
PART(results)
extern const size_t controller_bytes, controller_real, controller_counts;
const size_t controller_bytes = sizeof(controller), controller_real = sizeof(rig_real);
const size_t controller_counts = offsetof(controller, station.counts);
"""


class Firmware:
    """Firmware of a machine, without its board: sources, and the supervisor as portable code.

    Args:
        machine: the machine.
        precision: of the supervisor's numbers.
    """

    def __init__(self, machine: Machine, precision: str = "double") -> None:
        self.machine, self.precision, self.entries = machine, precision, SupervisorEntries(machine)
        self._texts = {entry.name: portable_entry(entry, "rig", precision) for entry in self.entries}

    def write(self, folder: Path, target: Target) -> tuple[list[Path], list[Path]]:
        """Write headers, generated sources and object files to a folder; return all sources and the object files."""
        entries, sources = self.entries, [DEVICE_FOLDER / f"{name}.c" for name in ("controller", "station", "frames")]
        api, tables = Api("rig", self.precision, tuple(entries), entries.comments), list(entries.tables())
        texts = {"rig.h": api.header("rig", entries.constants(), tables), "rig.c": api.source("rig.h", tables)}
        for name, text in (*texts.items(), *controller_sources(self.machine, self.precision)):
            (folder / name).write_text(text)
        objects = []
        for entry in entries:
            objects.append(folder / f"{entry.name}.o")
            objects[-1].write_bytes(object_file(entry, self._texts[entry.name], "rig", target))
        return [*sources, folder / "rig.c", folder / "machine.c"], objects

    def build(self, folder: Path) -> Any:
        """Return a library for this computer, built in a folder; skip the test without a compiler of C."""
        sources, objects = self.write(folder, Target(host(), "host"))
        (folder / "ends.c").write_text(ENDS)
        return build_library(folder, [*sources, folder / "ends.c"], objects)


class CController(CBoard):
    """Device that was just switched on, on a bench; it may go on from another's memory.

    Args:
        library: library from `Firmware.build`.
        joints: number of joints.
    """

    def __init__(self, library: Any, joints: int) -> None:
        super().__init__(library, Bench(joints))
        self.memory = ctypes.create_string_buffer(size_t.in_dll(library, "controller_bytes").value)
        self.restart()

    def restart(self) -> None:
        """Switch it off and on."""
        settings = ctypes.c_char.in_dll(self.library, "machine_controller")
        self.bench.bytes = b""
        self.library.controller_start(self.memory, ctypes.byref(settings))

    def step(self) -> None:
        self.library.controller_step(self.memory)

    def answers(self, kind: int, sequence: int, payload: bytes) -> list[frames.SerialFrame]:
        """Return the frames that answer one, which is sent whole at this instant."""
        return self.answers_to(frames.encode(kind, sequence, payload))

    def answers_to(self, data: bytes) -> list[frames.SerialFrame]:
        """Return the frames that answer bytes."""
        self.bench.sent, self.bench.bytes = b"", self.bench.bytes + data
        while self.bench.bytes:
            self.step()
        return frames.Decoder().feed(self.bench.sent)

    def numbers(self, *parts: str) -> Array:
        """Return the numbers of structs of the supervisor: inputs, memory or results."""
        return np.concatenate([self._numbers(part) for part in parts])

    def _numbers(self, part: str) -> Array:
        start, size = (size_t.in_dll(self.library, f"controller_{part}{end}").value for end in ("", "_bytes"))
        real = np.dtype(f"f{size_t.in_dll(self.library, 'controller_real').value}")
        numbers: Array = np.frombuffer(bytes(self.memory), real, size // real.itemsize, start)
        return numbers

    def counts(self) -> list[int]:
        """Return the voltages without dither, in counts."""
        start = size_t.in_dll(self.library, "controller_counts").value
        counts: list[int] = np.frombuffer(bytes(self.memory), np.uint32, self.bench.joints, start).tolist()
        return counts
