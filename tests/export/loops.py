"""Closed loops of control law and plant in Python, with the noise of the exported examples."""

import ctypes
from collections.abc import Iterator

import numpy as np
from numba import cfunc, types

from layflat.arrays import Array
from layflat.control import Demand, Sensed, step, wake
from layflat.export.compiled import portable_entry
from layflat.export.entries import ControlEntries, Entry
from layflat.export.host import HostControl, Numbers
from layflat.export.recording import DURATION, MOVE_TIME, cycles_of, move_target, record
from layflat.lanes import leaves
from layflat.machine import Machine, parameters
from layflat.sim.plant import SteppedPlant

MASK, FACTOR = (1 << 64) - 1, 2685821657736338717


def example_noise() -> Iterator[float]:
    """Numbers of the example's generator: sums of twelve of a xorshift64*."""
    word = 1
    while True:
        total = -6.0
        for _ in range(12):
            word ^= word >> 12
            word ^= (word << 25) & MASK
            word ^= word >> 27
            total += ((word * FACTOR & MASK) >> 11) / 9007199254740992.0
        yield total


class NoisyPlant(SteppedPlant):
    """A stepped plant whose sensors have the noise of an example."""

    def __init__(self, machine: Machine) -> None:
        super().__init__(machine, noise=False)
        numbers = example_noise()
        samples = (np.array([[next(numbers), next(numbers)] for _ in machine.joints]) for _ in iter(int, 1))
        self._noise = iter([np.zeros((len(machine.joints), 2))])
        self._after = samples

    def wake(self) -> tuple[Array, Array]:
        """Readings without noise; those after them have the example's."""
        readings = self.sense()
        self._noise = self._after
        return readings


def python_trace(machine: Machine) -> Array:
    """The trace that the example prints, of the stepped plant and the law as Python runs it."""
    n, cycles, first = len(machine.joints), cycles_of(DURATION, machine), cycles_of(MOVE_TIME, machine)
    plant, settings = NoisyPlant(machine), parameters.control(machine)
    zeros = (0.0,) * n
    memory = wake(settings, Sensed(*(tuple(row.tolist()) for row in plant.wake())))
    rows = np.empty((cycles, 1 + 4 * n))
    for k in range(cycles):
        demand = Demand(zeros if k < first else move_target(machine), zeros, zeros, zeros)
        sensed = Sensed(*(tuple(row.tolist()) for row in plant.sense()))
        memory, command, _ = step(settings, memory, sensed, demand, machine.cycle)
        plant.drive(np.array(command.voltage), command.shares)
        plant.advance((k + 1) * machine.cycle)
        seen = np.column_stack([plant.angles, plant.pressures, command.voltage])
        rows[k] = [(k + 1) * machine.cycle, *seen.ravel()]
    return rows


def jit_voltages(machine: Machine) -> Numbers:
    """Voltages of the recorded example in single precision, by the law as numba's own compiler compiles it."""
    entries, prefix = ControlEntries(machine, 4), "checked"
    texts = {entry.name: portable_entry(entry, prefix, "single") for entry in entries}
    recorded = record(machine, HostControl(entries, texts, prefix, "single"))
    woken, stepped = (cfunc(c_signature(entry))(entry.function).ctypes for entry in entries)
    n, dtype = len(machine.joints), np.float32
    settings, memory, command, report = (
        np.array(list(leaves(one)), dtype)
        for one in (entries.settings, entries.memory, entries.command, entries.report)
    )
    rows = np.empty((len(recorded.sensed), n), dtype)
    rest = recorded.rest.astype(dtype)
    woken(*map(pointer, (settings, rest, memory)))
    for k, (sensed, demand) in enumerate(
        zip(recorded.sensed.astype(dtype), recorded.demand.astype(dtype), strict=True)
    ):
        inputs, outputs = (settings, memory, sensed, demand), (memory, command, report)
        stepped(*map(pointer, inputs), machine.cycle, *map(pointer, outputs))
        rows[k] = command[:n]
    return rows


def pointer(array: Numbers) -> ctypes._Pointer:  # type: ignore[type-arg]
    return array.ctypes.data_as(ctypes.POINTER(ctypes.c_float))


def c_signature(entry: Entry) -> object:
    kinds = (types.float32 if one.like is None else types.CPointer(types.float32) for one in entry.arguments)
    return types.void(*kinds)
