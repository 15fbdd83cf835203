"""The firmware's logic behind a pseudo-terminal, in real time, driven by the host's own driver."""

from __future__ import annotations

import os
import threading
import time
import tty
from collections.abc import Iterator
from contextlib import suppress

import numpy as np
import pytest

from layflat.rig.device_state import DeviceState
from layflat.rig.driver import Driver, LinkError, RigCommand, SensorReading
from layflat.rig.drivers import create_driver
from tests.rig.devices import ARM, WIRE
from tests.rig.firmwares import firmware


class Board:
    """Pins that are not there; the serial line is a terminal, the time real."""

    def __init__(self) -> None:
        self.near, self.device = os.openpty()
        tty.setraw(self.device)
        os.set_blocking(self.near, False)
        self.pressed, self.on = False, True
        self.let_in: list[bool] = []
        self.driven = [0, 0]
        self.thread = threading.Thread(target=self._run)
        self.thread.start()

    def _run(self) -> None:
        station = firmware("station").Station(self, firmware("settings"))
        while self.on:
            station.step()
            time.sleep(1e-4)

    def close(self) -> None:
        self.on = False
        self.thread.join()
        os.close(self.near)
        os.close(self.device)

    def ticks(self) -> int:
        return time.monotonic_ns() // 1000

    def elapsed(self, then: int) -> int:
        return self.ticks() - then

    def received(self) -> bytes:
        with suppress(BlockingIOError):
            return os.read(self.near, 1000)
        return b""

    def send(self, data: bytes) -> None:
        os.write(self.near, data)

    def stopped(self) -> bool:
        return self.pressed

    def angle(self, joint: int) -> int:
        return 500 + joint

    def pressure(self, joint: int) -> int:
        return 3000 + joint

    def supply(self) -> int:
        return 1638

    def drive(self, counts: list[int]) -> None:
        self.driven = list(counts)

    def air(self, on: bool) -> None:
        self.let_in.append(on)

    def switch(self, outputs: int) -> None: ...

    def alive(self) -> None:
        pass


@pytest.fixture
def board() -> Iterator[Board]:
    found = Board()
    yield found
    found.close()


@pytest.fixture
def driver(board: Board) -> Iterator[Driver]:
    found = create_driver(f"serial://{os.ttyname(board.device)}", ARM)
    assert found.configure().dithers
    found.activate()
    yield found
    found.finalize()


def cycle(driver: Driver, *, reset: bool = False, air: bool = True) -> SensorReading:
    """One exchange; replies may be late where cores are shared."""
    driver.write(RigCommand(np.array([6.0, 4.0]), air, reset))
    for _ in range(5):
        with suppress(LinkError):
            return driver.read()
    return driver.read()


def test_from_the_reset_through_silence_and_e_stop_to_the_next_reset(board: Board, driver: Driver) -> None:
    assert cycle(driver).device is DeviceState.DUMPED
    reading = cycle(driver, reset=True)
    assert reading.device is DeviceState.RUNNING
    assert reading.angles.tolist() == [WIRE.angle.value(500), WIRE.angle.value(501)]
    assert board.let_in[-1]
    assert board.driven != [0xFFFF, 0xFFFF]
    time.sleep(0.6)
    assert board.driven == [0xFFFF, 0xFFFF]
    assert not board.let_in[-1]
    assert cycle(driver).device is DeviceState.DUMPED
    assert cycle(driver, reset=True).device is DeviceState.RUNNING
    board.pressed = True
    time.sleep(0.05)
    assert not board.let_in[-1]
    reading = cycle(driver)
    assert (reading.stopped, reading.device) == (True, DeviceState.DUMPED)
    board.pressed = False
    assert cycle(driver).device is DeviceState.DUMPED
    assert cycle(driver, reset=True).device is DeviceState.RUNNING
    driver.deactivate()
    time.sleep(0.01)
    assert not board.let_in[-1]
    driver.activate()
