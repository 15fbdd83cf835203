"""A control law cycle by cycle in plain Python, for tests that drive a plant themselves."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from layflat.control import Demand, Sensed, step, wake

Array = NDArray[np.float64]


class Controller:
    """A law with some settings, woken at these angles (rad) and differential pressures (Pa)."""

    def __init__(self, settings: Any, angles: Array, pressures: Array) -> None:
        self.settings, self.still = settings, (0.0,) * len(angles)
        self.memory = wake(settings, Sensed(tuple(angles.tolist()), tuple(pressures.tolist())))
        self.report: tuple[Any, ...] = ()

    def voltages(self, angles: Array, pressures: Array, elapsed: float, demands: Array) -> Array:
        """Voltages of a cycle."""
        sensed = Sensed(tuple(angles.tolist()), tuple(pressures.tolist()))
        demand = Demand(tuple(demands.tolist()), self.still, self.still, self.still)
        self.memory, command, self.report = step(self.settings, self.memory, sensed, demand, elapsed)
        return np.array(command.voltage)
