"""Drivers that another process can make for itself."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from fake_rig import FakeDriver
from plant_bench import PlantBench

from layflat.machine import load
from layflat.rig.driver import Capabilities, Command, Driver, DriverError, FarState, Reading
from layflat.rig.loop import NoRecorder


def simulated() -> Driver:
    machine = load("paper-arm")
    return FakeDriver(machine, PlantBench(machine, np.zeros(len(machine.joints)), gauge=0.0))


def absent() -> Driver:
    raise DriverError("nobody answers", where="modbus://127.0.0.1:5020", right="start the far side")


def of_one_joint() -> Driver:
    machine = load("paper-small-joint")
    return FakeDriver(machine, PlantBench(machine, np.zeros(1)))


def breaking() -> Driver:
    driver = simulated()
    driver.read = _break  # type: ignore[method-assign]
    return driver


def _break() -> Reading:
    raise RuntimeError("out of order")


class Still(Driver):
    """Costs no time: the sensors say the same two things in turn."""

    def __init__(self) -> None:
        super().__init__()
        self._k = 0

    def read(self) -> Reading:
        self._k += 1
        swing = (0.0, 4e3, 0.0, -4e3)[self._k % 4]
        return Reading(np.array([0.0, 0.0]), np.array([swing, swing]), 5.01325e5, False, FarState.RUNNING)

    def write(self, command: Command) -> None: ...

    def _configure(self) -> Capabilities:
        return Capabilities(2, 0.0, 10.0, 5.0, True, 0.001)

    def _activate(self) -> None: ...

    def _deactivate(self) -> None: ...

    def _finalize(self) -> None: ...


class LineRecorder(NoRecorder):
    """Keeps lines in a file."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def event(self, text: str) -> None:
        with self._path.open("a", encoding="utf-8") as file:
            file.write(text + "\n")
