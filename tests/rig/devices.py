"""A device without a machine: it counts the commands that it obeys, and says so by the first joint's angle."""

from __future__ import annotations

import asyncio
import gc
import threading
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from layflat import changed, load
from layflat.machine.model import Machine
from layflat.rig.clock import LoopClock, VirtualClock
from layflat.rig.device.modbus_server import ModbusStation
from layflat.rig.device.process import DeviceProcess, ModbusPort, SerialPort
from layflat.rig.device.serial_server import SerialStation
from layflat.rig.device.virtual import DeviceLink, ReplyFault, VirtualDevice
from layflat.rig.device_state import DeviceState
from layflat.rig.driver import Capabilities, RigCommand, SensorReading
from layflat.rig.wire import Wire


def patient(machine: Machine, seconds: float = 0.3) -> Machine:
    """Replies may take long: tests share their cores."""
    for link in ("modbus", "serial"):
        machine = changed(machine, f"interface.{link}.timeout", seconds)
    return machine


ARM = patient(load("paper-arm"))
WIRE = Wire.for_machine(ARM)


def angle_after(commands: int) -> float:
    """What the first joint's sensor says after so many commands were obeyed."""
    return WIRE.angle.value(1000 + commands)


class FakeDevice(VirtualDevice):
    def __init__(self, clock: LoopClock, able: Capabilities | None = None) -> None:
        self.capabilities = able or Capabilities(2, 0.0, 10.0, 5.0, True, 1e-3)
        self.link = DeviceLink()
        self.clock, self.ticks = clock, 0
        self.obeyed: list[RigCommand] = []

    def obey(self, command: RigCommand) -> None:
        self.obeyed.append(command)

    def reading(self) -> SensorReading:
        angles = np.array([angle_after(len(self.obeyed)), WIRE.angle.low])
        pressures = np.array([WIRE.pressure.value(4096), WIRE.pressure.value(7)])
        return SensorReading(angles, pressures, WIRE.supply.value(1638), False, DeviceState.CENTRED)

    def tick(self) -> None:
        self.ticks += 1


def spoil(device: FakeDevice, kind: ReplyFault | None, replies: float = 1.0) -> None:
    """Spoil coming replies; without a kind nothing is heard either."""
    if kind is None:
        device.link.silent = True
    else:
        device.link.spoil(kind, replies)


def heal(device: FakeDevice) -> None:
    device.link.mend()


def truth(device: FakeDevice) -> dict[str, Any]:
    return {"obeyed": device.obeyed, "ticks": device.ticks, "now": device.clock.now()}


def advance(device: FakeDevice, until: int) -> int:
    """Let time pass up to an instant (ns); the instant reached."""
    device.clock.wait(until)
    device.tick()
    return device.clock.now()


def burst(device: FakeDevice) -> None:
    raise ZeroDivisionError("no such hose")


def frozen(device: FakeDevice) -> int:
    """Objects that the collector leaves alone."""
    return gc.get_freeze_count()


def device_process(
    at: ModbusPort | SerialPort, machine: Machine = ARM, able: Capabilities | None = None, *, lockstep: bool = True
) -> DeviceProcess:
    return DeviceProcess(partial(FakeDevice, able=able), machine, at, lockstep=lockstep)


class Threaded:
    """A device in a thread of this process, which starts sooner; its clock stands still."""

    def __init__(self, at: ModbusPort | SerialPort) -> None:
        self.device = FakeDevice(VirtualClock())
        self._loop = asyncio.new_event_loop()
        if isinstance(at, ModbusPort):
            station = ModbusStation(self.device, ARM)
            port = self._loop.run_until_complete(station.listen(at.host, at.port))
            self.address, self._close = f"modbus://{at.host}:{port}", station.close
        else:
            terminal = SerialStation(self.device, ARM)
            path = self._loop.run_until_complete(self._opened(terminal))
            self.address, self._close = f"serial://{path}", terminal.close
        self._thread = threading.Thread(target=self._loop.run_forever)

    async def _opened(self, terminal: SerialStation) -> str:
        return terminal.listen()

    def __enter__(self) -> Threaded:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._loop.call_soon_threadsafe(self._close)
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.run_until_complete(asyncio.sleep(0.01))
        self._loop.close()

    def call(self, function: Callable[..., Any], *arguments: Any) -> Any:
        return function(self.device, *arguments)
