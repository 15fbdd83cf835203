"""Cycles of a control law in a closed loop with its machine, recorded on this computer."""

import ctypes
from typing import Any, NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.control import Demand, Sensed, step, wake
from layflat.export.compiled import SIZE_BY_PRECISION, object_file, portable_entry
from layflat.export.entries import ControlEntries, number_of
from layflat.export.targets import Target
from layflat.jit import objects
from layflat.lanes import leaves
from layflat.machine import Machine
from layflat.sim.plant import SteppedPlant

REALS: dict[str, Any] = {"double": np.dtype(np.float64), "single": np.dtype(np.float32)}
DEMAND_CYCLES = 60  # between two jumps of the demands


class Recording(NamedTuple):
    """Inputs of a control law: those of its first cycle, and a row of sensors and demands for each cycle."""

    first: Array
    rows: Array


def record_closed_loop(machine: Machine, cycles: int, seed: int = 1) -> Recording:
    """Return the inputs of a law in a closed loop: demands that jump, and some that move, and noisy sensors.

    Args:
        machine: the machine.
        cycles: number of control cycles.
        seed: seed of demands and noise.
    """
    settings = ControlEntries(machine, 8).settings
    plant, rng, n = SteppedPlant(machine, seed=seed), np.random.default_rng(seed), len(machine.joints)
    half = np.array([0.5 * joint.stops.working_stroke for joint in machine.joint.values()])
    demand, velocity, rows, memory = np.zeros(n), np.zeros(n), [], None
    first = np.concatenate(plant.sense())
    for k in range(cycles):
        if k % DEMAND_CYCLES == 0:
            demand = rng.uniform(-0.8, 0.8, n) * half
            velocity = rng.uniform(-1.0, 1.0, n) * (k // DEMAND_CYCLES % 3 == 2)
        demand = np.clip(demand + machine.cycle * velocity, -half, half)
        angles, pressures = (first[:n], first[n:]) if k == 0 else plant.sense()
        rows.append(np.concatenate([angles, pressures, demand, velocity, np.zeros(2 * n)]))
        sensed = Sensed(tuple(angles.tolist()), tuple(pressures.tolist()))
        asked = Demand(tuple(demand.tolist()), tuple(velocity.tolist()), (0.0,) * n, (0.0,) * n)
        memory = wake(settings, sensed) if memory is None else memory
        memory, command, _ = step(settings, memory, sensed, asked, machine.cycle)
        plant.drive(np.array(command.voltage))
        plant.advance((k + 1) * machine.cycle)
    return Recording(first, np.array(rows))


def interpreted_results(machine: Machine, recording: Recording) -> Array:
    """Return memory, command and report of each cycle, as Python itself computes them, without the compiler."""
    settings, n = ControlEntries(machine, 8).settings, len(machine.joints)
    parts = [tuple(map(float, part)) for part in recording.first.reshape(2, n)]
    memory, results = wake(settings, Sensed(*parts)), []
    for row in recording.rows:
        parts = [tuple(map(float, part)) for part in row.reshape(6, n)]
        memory, command, report = step(settings, memory, Sensed(*parts[:2]), Demand(*parts[2:]), machine.cycle)
        results.append([*leaves(memory), *leaves(command), *leaves(report)])
    return np.array(results, float)


class HostLaw:
    """Control law as an object file of this computer's processor."""

    def __init__(self, machine: Machine, precision: str) -> None:
        self.machine, self.real = machine, REALS[precision]
        self.entries, target = ControlEntries(machine, SIZE_BY_PRECISION[precision]), Target(objects.host(), "host")
        self._functions, self.texts = dict[str, Any](), dict[str, str]()
        for entry in self.entries:
            self.texts[entry.name] = text = portable_entry(entry, "law", precision)
            number = ctypes.c_double if precision == "double" else ctypes.c_float
            kinds = [ctypes.c_void_p if one.like is not None else number for one in entry.arguments]
            loaded: Any = objects.load(object_file(entry, text, "law", target), f"law_{entry.name}")
            self._functions[entry.name] = ctypes.cast(loaded, ctypes.CFUNCTYPE(None, *kinds))

    @property
    def voltages(self) -> slice:
        """Columns of the voltages in its results."""
        first = number_of(self.entries.memory)
        return slice(first, first + len(self.machine.joints))

    def results(self, recording: Recording) -> Array:
        """Return memory, command and report of each cycle."""
        entries, real = self.entries, self.real
        sizes = [number_of(value) for value in (entries.memory, entries.command, entries.report)]
        settings = np.array(list(leaves(entries.settings)), real)
        rows, first = recording.rows.astype(real), recording.first.astype(real)
        out, (memory, command, report) = [], [np.zeros(size, real) for size in sizes]
        self._functions["control_wake"](*map(_address, (settings, first, memory)))
        for row in rows:
            sensed, demand = np.split(row, [len(first)])
            self._functions["control_step"](
                *map(_address, (settings, memory, sensed, demand)), self.machine.cycle,
                *map(_address, (memory, command, report)),
            )  # fmt: skip
            out.append(np.concatenate([memory, command, report]))
        return np.array(out)


def _address(array: Any) -> int:
    return int(array.ctypes.data)
