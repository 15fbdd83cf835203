"""Statuses of a device that runs the law itself, put together by hand."""

from typing import Any

import numpy as np

from layflat.machine import load
from layflat.rig.device_state import DeviceState
from layflat.rig.driver import SensorReading
from layflat.rig.safety.faults import Fault, RigState, ValveMode
from layflat.rig.safety.requests import DeviceStatus, RequestWire
from tests.rig.devices import WIRE

ARM = load("paper-arm")
REQUESTS = RequestWire.for_machine(ARM)


def status(**changed: Any) -> DeviceStatus:
    """Return a status of the paper's arm in motion."""
    angles = np.array([WIRE.angle.value(2048), WIRE.angle.value(1000)])
    pressures = np.array([WIRE.pressure.value(2048), WIRE.pressure.value(3000)])
    reading = SensorReading(angles, pressures, WIRE.supply.value(1638), False, DeviceState.RUNNING)
    signals = np.arange(2.0 * REQUESTS.signals).reshape(2, -1)
    moving = RigState.MOVING, ValveMode.FOLLOW, False, 0, Fault.NONE, [Fault.NONE] * 2
    return DeviceStatus(reading, *moving, 7, 0, [], signals)._replace(**changed)
