"""Drivers that another process can make for itself."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from layflat.machine import load
from layflat.rig.driver import Driver, DriverError, SensorReading
from layflat.rig.loop import LoopRecorder
from tests.rig.fake_rig import FakeDriver
from tests.rig.plant_bench import PlantBench


def simulated() -> Driver:
    machine = load("paper-arm")
    return FakeDriver(machine, PlantBench(machine, np.zeros(len(machine.joints)), gauge=0.0))


def absent() -> Driver:
    raise DriverError("nobody answers", where="modbus://127.0.0.1:5020", right="start the device")


def of_one_joint() -> Driver:
    machine = load("paper-small-joint")
    return FakeDriver(machine, PlantBench(machine, np.zeros(1)))


def breaking() -> Driver:
    driver = simulated()
    driver.read = _break  # type: ignore[method-assign]
    return driver


def _break() -> SensorReading:
    raise RuntimeError("out of order")


class LineRecorder(LoopRecorder):
    """Keeps lines in a file."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def event(self, text: str) -> None:
        with self._path.open("a", encoding="utf-8") as file:
            file.write(text + "\n")
