"""Control cycle of a rig as an object file of this computer's processor, in double or single precision."""

import ctypes
from collections.abc import Callable
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.export.compiled import object_file, portable_entry
from layflat.export.entries import number_of
from layflat.export.firmware.cycle import CycleEntries
from layflat.export.targets import Target
from layflat.jit import objects
from layflat.lanes import leaves
from layflat.machine import Machine
from layflat.rig.safety.core import CycleCore
from tests.export.firmware.recordings import REALS


class HostCycle:
    """Control cycle of a machine, as it is exported."""

    def __init__(self, machine: Machine, precision: str) -> None:
        self.entries, self.real, self.precision = CycleEntries(machine), REALS[precision], precision
        self.texts = {entry.name: portable_entry(entry, "rig", precision) for entry in self.entries}
        _, run = self.entries
        code = object_file(run, self.texts[run.name], "rig", Target(objects.host(), "host"))
        loaded: Any = objects.load(code, "rig_cycle_run")
        kinds = [ctypes.c_void_p] * (len(run.arguments) - 1)
        self._function = ctypes.cast(loaded, ctypes.CFUNCTYPE(ctypes.c_int32, *kinds, ctypes.c_int32))
        entries = self.entries
        constants = entries.rig, entries.settings, entries.arm, entries.law_settings, entries.workspace
        self._constants = [np.array(list(leaves(one)), self.real) for one in constants]
        self._sizes = list(
            map(number_of, (entries.inputs, entries.samples, entries.memory, entries.law_memory, entries.report))
        )

    def run(self, numbers: Array, stages: int) -> tuple[int, Array]:
        """Return outcome and numbers after stages on numbers, which are in the order of the board's program."""
        rig, settings, arm, law, workspace = self._constants
        copy = numbers.astype(self.real)
        inputs, samples, memory, law_memory, report = np.split(copy, np.cumsum(self._sizes)[:-1])
        order = rig, settings, inputs, samples, memory, arm, law, law_memory, report, workspace
        outcome = self._function(*(one.ctypes.data for one in order), int(stages))
        return outcome, copy

    def perform(self, core: CycleCore) -> Callable[[int], int]:
        """Return the function that performs stages on the numbers of a rig's loop."""
        assert core.law is not None
        arrays = core.inputs.array[0], core._joint_inputs, core.memory.array, core.law.memory.array[0]
        places = *arrays, core.law.report.array

        def performed(stages: int) -> int:
            outcome, after = self.run(np.concatenate([place.ravel() for place in places]), stages)
            for place, part in zip(places, np.split(after, np.cumsum(self._sizes)[:-1]), strict=True):
                place[:] = part.reshape(place.shape)
            return outcome

        return performed
