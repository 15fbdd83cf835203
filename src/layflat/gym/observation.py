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

from typing import Any

import numpy as np
from gymnasium.spaces import Box

from layflat.arrays import Array
from layflat.gym.kernel import ObservedArrays, StepArrays, compare_with_goals, read_sensors
from layflat.gym.rewards import FAR_SCALE, NEAR_SCALE, SUCCESS_DISTANCE
from layflat.gym.tasks import EnvOptions
from layflat.machine import Machine
from layflat.machine.parameters import valve_and_sensors
from layflat.sim.batch import Batch

RATE_UNIT = 5.0  # rad/s
READING_BOUND = 1.001  # greatest reading by half the range: converters end there, numbers are rounded
ANGLE_BOUND = 4.0  # of true angles and errors, by half the range of the sensor
VELOCITY_BOUND, PRESSURE_BOUND, PAYLOAD_BOUND = 200.0, 50.0, 1e3  # of the true state, in the units of the observation


class ArmObserver:
    """Observer of many arms: makes observations, (rows, arms) float32, and rewards them.

    Args:
        machine: machine whose sensors are read.
        count: number of arms.
        options: options of the environment.
        moving: whether goals move.

    Attributes:
        names: name of each row.
        space: space of an arm's observation.
        action: last action, float32, (joints, arms), to be set before `compare`.
        of_pool: goal of each arm, a number of the pool, (arms,).
        steps: steps of each arm's episode, (arms,).
    """

    def __init__(self, machine: Machine, count: int, options: EnvOptions, *, moving: bool) -> None:
        _, angle_sensor, pressure_sensor = valve_and_sensors(machine)
        self._joints, self._count = len(machine.joints), count
        self._angle_unit, self._pressure_unit = 0.5 * angle_sensor.range, 0.5 * pressure_sensor.range
        period = options.cycles * machine.cycle
        rates = self._angle_unit / (RATE_UNIT * period), 1.0 / (RATE_UNIT * period)
        readings = {"angle": READING_BOUND, "pressure": READING_BOUND, "rate": 2.0 * READING_BOUND * rates[0]}
        if options.observe == "state":
            readings = {"angle": ANGLE_BOUND, "pressure a": PRESSURE_BOUND, "pressure b": PRESSURE_BOUND,
                        "velocity": VELOCITY_BOUND}  # fmt: skip
        self._first_demand = len(readings) * self._joints  # row
        blocks = readings | {"action": 1.0, "error": 2.0 * ANGLE_BOUND}
        blocks |= {"goal rate": VELOCITY_BOUND} if moving else {}
        self.names = [f"{block} {joint}" for block in blocks for joint in machine.joints]
        bounds = [bound for bound in blocks.values() for _ in machine.joints]
        if options.observe == "state":
            self.names, bounds = [*self.names, "payload"], [*bounds, PAYLOAD_BOUND]
        bound = np.array(bounds, np.float32)
        self.space = Box(-bound, bound, dtype=np.float32)
        self.of_pool, self.steps = np.zeros(count, np.int64), np.zeros(count, np.int64)
        shape = len(machine.joints), count
        self._arrays = StepArrays(
            np.zeros((len(bound), count), np.float32), np.zeros(shape, np.float32), np.array(rates, np.float32),
            np.zeros(shape, np.float32), np.zeros(count), np.zeros(count), np.zeros(count, bool),
        )  # fmt: skip
        self.action = self._arrays.action

    def bind(self, seen: Array, tips: Array, goals: Array, goal_tips: Array) -> None:
        """Set the arrays that are observed, of one type of numbers (see `ObservedArrays`); live ones are C-contiguous.

        Args:
            seen: live readings of angle and differential pressure, and others, (joints, signals, arms), rad, Pa.
            tips: live positions of the tips, (3, arms), m.
            goals: angles of the pool's goals, (instants, joints, pool), rad.
            goal_tips: positions of the tip there, (instants, 3, pool), m.
        """
        units = 1.0 / self._angle_unit, 1.0 / self._pressure_unit, FAR_SCALE, NEAR_SCALE, SUCCESS_DISTANCE
        scales = np.array(units, goals.dtype)
        goals, goal_tips = np.ascontiguousarray(goals), np.ascontiguousarray(goal_tips)
        self._seen, numbers = seen, {name: np.zeros(self._count, goals.dtype) for name in ("distances", "rewards")}
        self._arrays = step = self._arrays._replace(**numbers)
        observed = ObservedArrays(seen, tips, goals, goal_tips, self.of_pool, self.steps, scales)
        self._read = read_sensors.bind(observed, step, 1)
        self._compare = compare_with_goals.bind(observed, step, self._first_demand)

    def restart(self, arms: Any = slice(None)) -> None:
        """Count the coming rates of some arms from their present readings."""
        self._arrays.last[:, arms] = np.multiply(self._seen[:, 0, arms], 1.0 / self._angle_unit, dtype=np.float32)

    def read_sensors(self, *, keeps: bool = True) -> None:
        """Read the sensors; where `keeps`, the coming rates are counted from these angles."""
        self._read(int(keeps))

    def read_state(self, batch: Batch) -> None:
        """Read the true state in place of the sensors."""
        rows, n = self._arrays.rows, self._joints
        for i, (values, unit) in enumerate((
            (batch.angle, self._angle_unit), (batch.pressure_a, self._pressure_unit),
            (batch.pressure_b, self._pressure_unit), (batch.velocity, RATE_UNIT),
        )):  # fmt: skip
            np.multiply(values.T, 1.0 / unit, out=rows[i * n : (i + 1) * n])
        rows[-1] = batch.inputs["payload"]

    def compare(self) -> Array:
        """Compare the arms with their goals after the action in `action`; return observations, (rows, arms)."""
        self._compare()
        return self._arrays.rows.copy()

    @property
    def rewards(self) -> Array:
        """Rewards of the last comparison, (arms,)."""
        return self._arrays.rewards.copy()

    def info(self) -> dict[str, Any]:
        """Return the information of the last comparison: distances (m), and whether tips are there, (arms,) each."""
        return {"distance": self._arrays.distances.copy(), "is_success": self._arrays.successes.copy()}
