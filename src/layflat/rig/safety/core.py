"""Numbers of a rig's control cycle by name, and the compiled code that runs on them."""

from collections.abc import Callable, Sequence
from functools import partial
from math import nan
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.lanes import Like
from layflat.machine import Machine, parameters
from layflat.rig.driver import SensorReading
from layflat.rig.law import ArmLaw
from layflat.rig.named import NamedRows
from layflat.rig.safety import cycle_numbers as numbers
from layflat.rig.safety import estimator
from layflat.rig.safety.cycle import CycleLikes, judge_samples, write_signals
from layflat.rig.safety.faults import Fault
from layflat.rig.safety.limits import joint_settings, rig_settings
from layflat.rig.safety.supervision import COMMAND_PART, CONTROL_PART, run_cycle


class RigNumbers:
    """Numbers of a rig's cycle, without a control law; the arrays stay the same.

    Raises:
        MachineError: the machine has no valve or sensors.
    """

    def __init__(self, machine: Machine) -> None:
        n = len(machine.joints)
        self.rig = NamedRows([rig_settings(machine)])
        self.settings = NamedRows([joint_settings(machine, name) for name in machine.joints])
        self.inputs, self.samples = (
            NamedRows([numbers.INPUTS_TEMPLATE]),
            NamedRows([numbers.JOINT_INPUTS_TEMPLATE] * n),
        )
        self.machine, self.memory = NamedRows([numbers.FIRST_MEMORY]), NamedRows([numbers.FIRST_JOINT_MEMORY] * n)
        self.results, self.commands = NamedRows([numbers.FIRST_RESULTS]), NamedRows([numbers.FIRST_COMMAND] * n)
        self.events = NamedRows([numbers.NO_EVENT] * numbers.max_events(n))
        self.rows = numbers.CycleRows(
            self.rig.array[0], self.settings.array, self.inputs.array[0], self.samples.array, self.machine.array[0],
            self.memory.array, self.results.array[0], self.commands.array, self.events.array,
        )  # fmt: skip
        # Inputs: samples (rad, Pa), and the demands of the host (rad, rad/s, rad/s2), (joints,).
        self.angles, self.pressures, self.requested, *self.rates = self.samples.array.T
        self.memory["voltage"][:] = self.memory["law_voltage"][:] = self.rig["centre"][0]

    def load_reading(self, reading: SensorReading) -> None:
        """Load the samples of a reading into the inputs."""
        self.angles[:], self.pressures[:] = reading.angles, reading.pressures

    def bind_detectors(self, level: float) -> Callable[[], object]:
        """Return the function that runs the detectors on the inputs, at a level of detection (detectors/sample.py)."""
        return judge_samples.bind(self.rows, level)

    @property
    def detected_faults(self) -> tuple[Fault, list[Fault]]:
        """Return the fault of the machine as a whole and that of each joint, from the last detection."""
        return Fault(int(self.machine["fault"][0])), [Fault(int(fault)) for fault in self.memory["fault"].tolist()]


class CycleCore(RigNumbers):
    """Control cycle of a rig with a control law.

    Raises:
        MachineError: the machine has no valve or sensors.
    """

    def __init__(self, machine: Machine, law: ArmLaw) -> None:
        super().__init__(machine)
        self.law = law
        n, width = len(machine.joints), numbers.RECORDED_WIDTH + len(law.recorded) + 1
        self._signals, self._plans = np.empty((n, width)), law.kind.plans
        self._write_signals = write_signals.bind(self._signals, self.rows, law.report.array, law.recorded)
        self._run = _bound_cycle(NamedRows([parameters.arm(machine)]), law, self.rows)
        self.between: Callable[[], object] | None = None  # called between the control law and the gate of its voltages
        self.law_voltages = self.memory["law_voltage"]  # voltages of the control law, before their gate, V, (joints,)
        self.demands, self.voltages = self.memory["demand.demand"], self.memory["voltage"]  # after their gates, rad, V

    def wake(self, reading: SensorReading) -> None:
        """Initialize control law and estimators with a reading."""
        angles, pressures = reading.angles.tolist(), reading.pressures.tolist()
        for j, (angle, pressure) in enumerate(zip(angles, pressures, strict=True)):
            self.memory.replace("estimator", estimator.start_estimator(angle, pressure), j)
        self.law.wake(angles, pressures)
        self.machine["wake"][0] = 0.0

    def load_demands(
        self, angles: Sequence[float], velocities: Sequence[float] | None = None,
        accelerations: Sequence[float] | None = None,
    ) -> None:  # fmt: skip
        """Load the demands of the host into the inputs; see `HostRequest`.

        Args:
            angles: rad, (joints,).
            velocities: rad/s, (joints,); None: derived from the angles, as the next.
            accelerations: rad/s2, (joints,).

        Only laws that plan their motion use more than the angles.
        """
        self.requested[:] = angles
        if self._plans:
            v, a = self.rates
            v[:], a[:] = nan if velocities is None else velocities, nan if accelerations is None else accelerations

    def run(self) -> None:
        """Run a cycle on the inputs."""
        if self.between is None:
            self._run(CONTROL_PART | COMMAND_PART)
            return
        self._run(CONTROL_PART)
        if self.inputs["answered"][0]:
            self.between()
        self._run(COMMAND_PART)

    def record(self, rows: Array) -> None:
        """Write the signals of each joint, as in `record.RowLayout`, into rows, (joints, numbers)."""
        self._write_signals()
        rows[:] = self._signals

    @property
    def max_lead(self) -> float:
        """Return the greatest distance of any joint's demand from its reference, rad."""
        return float(np.abs(self.demands - self.memory["demand.reference"]).max())


def _bound_cycle(arm: NamedRows, law: ArmLaw, rows: numbers.CycleRows) -> Callable[[int], Any]:
    """Return the cycle of an arm with a control law as a function of its parts; plain Python if the law is."""
    n, kind = len(law.report.array), law.kind
    column = list(kind.signals).index(kind.gives_up) if kind.gives_up is not None else -1
    law_rows = numbers.LawRows(
        arm.array[0], law.settings.array[0], law.memory.array[0], law.report.array, np.zeros((2 * n + 4, n + 1))
    )
    likes = CycleLikes(Like.from_tuple(arm.like), law.settings.like, law.memory.like)
    if not kind.compiled:
        return partial(run_cycle.py_func, likes, (0.0,) * n, column, rows, law_rows)
    likes = CycleLikes(*(one if isinstance(one, Like) else Like.from_tuple(one) for one in likes))
    return run_cycle.bind(likes, (0.0,) * n, column, rows, law_rows, 0)
