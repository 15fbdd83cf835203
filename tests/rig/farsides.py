"""A device without a machine: it counts the commands that it obeys, and says so by the first joint's angle."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from layflat import changed, load
from layflat.machine.model import Machine
from layflat.rig.clock import Clock
from layflat.rig.driver import Capabilities, Command, FarState, Reading
from layflat.rig.far.link import Link, Spoil
from layflat.rig.far.process import FarSide, ModbusPort, SerialPort
from layflat.rig.wire.content import Wire


def patient(machine: Machine, seconds: float = 0.3) -> Machine:
    """Replies may take long: tests share their cores."""
    for link in ("modbus", "serial"):
        machine = changed(machine, f"interface.{link}.timeout", seconds)
    return machine


ARM = patient(load("paper-arm"))
WIRE = Wire.of(ARM)


def angle_after(commands: int) -> float:
    """What the first joint's sensor says after so many commands were obeyed."""
    return WIRE.angle.value(1000 + commands)


class FakeDevice:
    def __init__(self, clock: Clock, able: Capabilities | None = None) -> None:
        self.capabilities = able or Capabilities(2, 0.0, 10.0, 5.0, True, 1e-3)
        self.link = Link()
        self.clock, self.ticks = clock, 0
        self.obeyed: list[Command] = []

    def obey(self, command: Command) -> None:
        self.obeyed.append(command)

    def reading(self) -> Reading:
        angles = np.array([angle_after(len(self.obeyed)), WIRE.angle.low])
        pressures = np.array([WIRE.pressure.value(4096), WIRE.pressure.value(7)])
        return Reading(angles, pressures, WIRE.supply.value(1638), False, FarState.CENTRED)

    def tick(self) -> None:
        self.ticks += 1


def spoil(device: FakeDevice, kind: Spoil | None, replies: float = 1.0) -> None:
    """Spoil coming replies; without a kind nothing is heard either."""
    if kind is None:
        device.link.silent = True
    else:
        device.link.spoil(kind, replies)


def heal(device: FakeDevice) -> None:
    device.link.mend()


def truth(device: FakeDevice) -> dict[str, Any]:
    return {"obeyed": device.obeyed, "ticks": device.ticks, "now": device.clock.now()}


def burst(device: FakeDevice) -> None:
    raise ZeroDivisionError("no such hose")


def far_side(
    at: ModbusPort | SerialPort, machine: Machine = ARM, able: Capabilities | None = None, *, lockstep: bool = True
) -> FarSide:
    return FarSide(partial(FakeDevice, able=able), machine, at, lockstep=lockstep)
