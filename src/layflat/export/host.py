"""Entries of a control law as machine code of this computer: the reference of all other targets."""

import ctypes
from typing import Any

import numpy as np
from numpy.typing import NDArray

from layflat.export.compiled import object_file
from layflat.export.entries import ControlEntries, number_of
from layflat.export.targets import Target
from layflat.jit.objects import host, load
from layflat.lanes import leaves

Numbers = NDArray[np.floating[Any]]

NUMBER_TYPES: dict[str, tuple[Any, Any]] = {
    "double": (np.float64, ctypes.c_double),
    "single": (np.float32, ctypes.c_float),
}
"""Type of a number of NumPy and of ctypes, by precision."""


class HostControl:
    """Control law of a machine, compiled for this computer from the portable text of its entries.

    Args:
        entries: the law's entries.
        texts: portable text of each entry, by its name.
        prefix: prefix of the functions' names.
        precision: "double" or "single".
    """

    def __init__(self, entries: ControlEntries, texts: dict[str, str], prefix: str, precision: str) -> None:
        self.dtype, real = NUMBER_TYPES[precision]
        functions = {}
        for entry in entries:
            arguments = tuple(real if one.like is None else ctypes.c_void_p for one in entry.arguments)
            code = object_file(entry, texts[entry.name], prefix, Target(host(), "this computer"))
            functions[entry.name] = load(code, f"{prefix}_{entry.name}", arguments)
        self._wake, self._step = functions["control_wake"], functions["control_step"]
        self._settings = np.array(list(leaves(entries.settings)), self.dtype)
        self.memory = np.zeros(number_of(entries.memory), self.dtype)
        self.command = np.zeros(number_of(entries.command), self.dtype)
        self.report = np.zeros(number_of(entries.report), self.dtype)

    def wake(self, sensed: Numbers) -> None:
        """Initialise the memory at readings: angles (rad), then differential pressures (Pa)."""
        readings = np.ascontiguousarray(sensed, self.dtype)
        self._wake(self._settings.ctypes.data, readings.ctypes.data, self.memory.ctypes.data)

    def step(self, sensed: Numbers, demand: Numbers, elapsed: float) -> Numbers:
        """Step the law by a cycle; return its command, voltages (V) first.

        Args:
            sensed: readings, as of `wake`.
            demand: angles (rad), velocities, accelerations and stiffnesses of the joints, one after the other.
            elapsed: time since the last cycle, s.
        """
        readings, demands = (np.ascontiguousarray(one, self.dtype) for one in (sensed, demand))
        inputs = (self._settings, self.memory, readings, demands)
        outputs = (self.memory, self.command, self.report)
        addresses = [[one.ctypes.data for one in arrays] for arrays in (inputs, outputs)]
        self._step(*addresses[0], elapsed, *addresses[1])
        return self.command.copy()
