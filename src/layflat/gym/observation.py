"""Observations: what a policy sees of its arm, as numbers of about 1.

Rows stand in blocks, each with an item per joint:

| block | meaning | unit |
|---|---|---|
| angle | reading of the angle | half the sensor's range |
| pressure | reading of the differential pressure | half the sensor's range |
| rate | change of the angle since the step before, by its duration | `RATE_UNIT` |
| action | the last action | 1 |
| error | goal less angle | half the sensor's range |
| goal rate | of goals that move: the coming change of the goal, by the step's duration | `RATE_UNIT` |

Of the true state there are angle, velocity, pressures of both hoses by half the range of the sensor of differential
pressure, action, error, and the payload in kg.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from gymnasium.spaces import Box

from layflat.arrays import Array
from layflat.gym.tasks import EnvOptions
from layflat.machine import Machine
from layflat.machine.parameters import valve_and_sensors
from layflat.sim.batch import Batch

RATE_UNIT = 5.0  # rad/s
READING_BOUND = 1.001  # greatest reading by half the range: converters end there, numbers are rounded
ANGLE_BOUND = 4.0  # of true angles and errors, by half the range of the sensor
VELOCITY_BOUND, PRESSURE_BOUND, PAYLOAD_BOUND = 200.0, 50.0, 1e3  # of the true state, in the units of the observation


class ArmObserver:
    """Maker of observations, (rows, arms) float32, for many arms that are observed together.

    Args:
        machine: machine whose sensors are read.
        count: number of arms.
        options: options of the environment.
        moving: whether goals move.

    Attributes:
        names: name of each row.
        space: space of an arm's observation.
    """

    def __init__(self, machine: Machine, count: int, options: EnvOptions, *, moving: bool) -> None:
        _, angle_sensor, pressure_sensor = valve_and_sensors(machine)
        self._joints, self._count = len(machine.joints), count
        self._angle_unit, self._pressure_unit = 0.5 * angle_sensor.range, 0.5 * pressure_sensor.range
        period = options.cycles * machine.cycle
        self._rate_factor = self._angle_unit / (RATE_UNIT * period)
        self._goal_rate_factor = 1.0 / (RATE_UNIT * period)
        self._last = np.zeros((self._joints, count), np.float32)
        readings = {"angle": READING_BOUND, "pressure": READING_BOUND, "rate": 2.0 * READING_BOUND * self._rate_factor}
        if options.observe == "state":
            readings = {"angle": ANGLE_BOUND, "pressure a": PRESSURE_BOUND, "pressure b": PRESSURE_BOUND,
                        "velocity": VELOCITY_BOUND}  # fmt: skip
        blocks = readings | {"action": 1.0, "error": 2.0 * ANGLE_BOUND}
        blocks |= {"goal rate": VELOCITY_BOUND} if moving else {}
        self._rows = {name: slice(i * self._joints, (i + 1) * self._joints) for i, name in enumerate(blocks)}
        self.names = [f"{block} {joint}" for block in blocks for joint in machine.joints]
        bounds = [bound for bound in blocks.values() for _ in machine.joints]
        if options.observe == "state":
            self.names, bounds = [*self.names, "payload"], [*bounds, PAYLOAD_BOUND]
        bound = np.array(bounds, np.float32)
        self.space = Box(-bound, bound, dtype=np.float32)
        self.read: Callable[[Array, Batch], None] = (
            self._read_sensors if options.observe == "sensors" else self._read_state
        )

    def new(self) -> Array:
        """Return an array for the observations of all arms, unset."""
        return np.empty((len(self.names), self._count), np.float32)

    def write_readings(self, rows: Array, angle: Array, pressure: Array) -> None:
        """Write the blocks of the sensors; rates are counted from the readings of `keep` or `restart`.

        Args:
            rows: array of `new`.
            angle: readings, (joints, arms), rad.
            pressure: readings, (joints, arms), Pa.
        """
        n = self._joints
        here = rows[:n]
        np.multiply(angle, 1.0 / self._angle_unit, out=here)
        np.multiply(pressure, 1.0 / self._pressure_unit, out=rows[n : 2 * n])
        rate = rows[2 * n : 3 * n]
        np.subtract(here, self._last, out=rate)
        np.multiply(rate, self._rate_factor, out=rate)

    def keep(self, rows: Array) -> None:
        """Keep the angles in these rows: the coming rates are counted from them."""
        self._last[:] = rows[: self._joints]

    def restart(self, angle: Array, arms: Any = slice(None)) -> None:
        """Count the coming rates of some arms from readings of their angles, (joints, arms), rad."""
        self._last[:, arms] = np.multiply(angle[:, arms], 1.0 / self._angle_unit, dtype=np.float32)

    def write_demand(self, rows: Array, action: Array | float, goal: Array, coming: Array | None = None) -> None:
        """Write action, error, and the rate of a goal that moves.

        Args:
            rows: array of `new`, with its readings.
            action: (joints, arms).
            goal: angles, (joints, arms), rad.
            coming: angles of the goal after the coming step; None for a goal that rests.
        """
        rows[self._rows["action"]] = action
        error = rows[self._rows["error"]]
        np.multiply(goal, 1.0 / self._angle_unit, out=error)
        np.subtract(error, rows[: self._joints], out=error)
        if coming is not None:
            rate = rows[self._rows["goal rate"]]
            np.subtract(coming, goal, out=rate)
            np.multiply(rate, self._goal_rate_factor, out=rate)

    def _read_sensors(self, rows: Array, batch: Batch) -> None:
        self.write_readings(rows, batch.sensed_angle.T, batch.sensed_pressure.T)

    def _read_state(self, rows: Array, batch: Batch) -> None:
        for name, values, unit in (
            ("angle", batch.angle, self._angle_unit), ("pressure a", batch.pressure_a, self._pressure_unit),
            ("pressure b", batch.pressure_b, self._pressure_unit), ("velocity", batch.velocity, RATE_UNIT),
        ):  # fmt: skip
            np.multiply(values.T, 1.0 / unit, out=rows[self._rows[name]])
        rows[-1] = batch.inputs["payload"]
