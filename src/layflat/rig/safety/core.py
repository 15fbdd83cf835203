"""Numbers of a rig's control cycle, and the stages of compiled code that run on them."""

from collections.abc import Callable, Sequence
from functools import partial
from math import inf, isfinite, nan
from struct import Struct

import numpy as np

from layflat.arrays import Array
from layflat.lanes import Like
from layflat.machine import Machine, parameters
from layflat.physics.air_balance import AirEstimate
from layflat.physics.joint import REST_PRESSURE_RATIO
from layflat.rig.driver import SensorReading
from layflat.rig.law import ArmLaw
from layflat.rig.named import NamedRows
from layflat.rig.safety import cycle as compiled
from layflat.rig.safety import cycle_numbers as numbers
from layflat.rig.safety import demands, detectors, estimator
from layflat.rig.safety.detectors import bounds
from layflat.rig.safety.faults import Fault
from layflat.rig.safety.limits import joint_settings, rig_settings

MIN_FILL_FRACTION = (
    0.4  # of the supply's gauge pressure; joints with less are compliant, and accelerate each other further
)
RIPPLE_NAME, MIN_RIPPLE_NAME = "detectors.trace.ripple", "detectors.valve_unresponsive.ripple"
INPUTS_HEADER = Struct(f"{numbers.INPUT_OFFSETS.even}d")  # of the inputs: written in half the time of an array's slice


class CycleCore:
    """Control cycle of a rig: its numbers by name, and its stages; without a control law it has the detectors alone.

    Raises:
        MachineError: the machine has no valve or sensors.
    """

    def __init__(self, machine: Machine, law: ArmLaw | None = None) -> None:
        names = list(machine.joints)
        self.rig = NamedRows([rig_settings(machine)])
        self.settings = NamedRows([joint_settings(machine, name) for name in names])
        self.memory, self.inputs = (
            NamedRows([numbers.MEMORY_TEMPLATE] * len(names)),
            NamedRows([numbers.INPUTS_TEMPLATE]),
        )
        self.law = law
        self._joint_inputs, self._head = np.zeros((len(names), numbers.JOINT_INPUT_COUNT)), self.inputs.array[0]
        settings = self.rig.array[0], self.settings.array
        arrays = (*settings, self._head, self._joint_inputs, self.memory.array)
        self._perform: Callable[..., int]
        if law is None:
            self._perform = compiled.judge_samples.bind(*arrays)
        else:
            self._perform = _bound_cycle(NamedRows([parameters.arm(machine)]), law, arrays)
            self._signals = np.empty((len(names), numbers.RECORDED_WIDTH + len(law.recorded) + 1))
            written = self._signals, self._joint_inputs, self.memory.array, law.report.array, law.recorded
            self._write_signals = compiled.write_signals.bind(*written)
        # Inputs: samples (rad, Pa), and the demands of the host (rad, rad/s, rad/s2), (joints,).
        self.angles, self.pressures, self._host_demands, *self._host_rates = self._joint_inputs.T[:5]
        self._demand_age, self._plans = 0.0, law is not None and law.kind.plans
        self.between: Callable[[], object] | None = None  # called between the control law and the gate of its voltages
        self.law_voltages = self.memory["law_voltage"]  # voltages of the control law, before their gate, V, (joints,)
        self.demands, self.voltages = self.memory["demand.demand"], self.memory["voltage"]  # after their gates, rad, V
        self.faults, self.outcomes = self.memory["fault"], self.memory["outcome"]  # of each joint in this cycle
        self.memory.replace("stream", demands.DemandStream())
        self.voltages[:] = self.law_voltages[:] = self.rig["centre"][0]
        self.reset()

    def reset(self) -> None:
        """Reset the memory of the detectors; the estimate of the air, and demands, are kept."""
        self.memory.replace("detectors", detectors.INITIAL_MEMORY)
        self.inputs.replace("lines", bounds.SupplyMemory())
        self.inputs["even"][0] = compiled.MIN_EVEN_TIME

    def initialize_air(self, reading: SensorReading, *, filled: bool) -> None:
        """Initialize the estimate of the air in the hoses.

        Args:
            reading: first reading of the sensors.
            filled: whether the hoses hold the pressure that they settle to with centred valves; else they are empty.
        """
        empty = self.rig["ambient"][0]
        held = max(REST_PRESSURE_RATIO * reading.supply if filled else empty, empty)
        for j, (angle, pressure) in enumerate(zip(reading.angles, reading.pressures, strict=True)):
            half = 0.5 * pressure if isfinite(pressure) else 0.0
            self.memory.replace("air", AirEstimate(held + half, held - half, angle, 0.0, 0.0), j)

    def wake(self, reading: SensorReading) -> None:
        """Initialize control law and estimators with a reading."""
        angles, pressures = reading.angles.tolist(), reading.pressures.tolist()
        for j, (angle, pressure) in enumerate(zip(angles, pressures, strict=True)):
            self.memory.replace("estimator", estimator.start_estimator(angle, pressure), j)
        if self.law is not None:
            self.law.wake(angles, pressures)

    def load_reading(self, reading: SensorReading) -> None:
        """Load the samples of a reading into the inputs."""
        self.angles[:], self.pressures[:] = reading.angles, reading.pressures

    def load_demands(
        self, angles: Sequence[float], velocities: Sequence[float] | None = None,
        accelerations: Sequence[float] | None = None, since: float = 0.0,
    ) -> None:  # fmt: skip
        """Load the demands of the host into the inputs; see `HostRequest`.

        Args:
            angles: rad, (joints,).
            velocities: rad/s, (joints,); None: derived from the angles, as the next.
            accelerations: rad/s2, (joints,).
            since: time since the instant for which they are meant, s.

        Only laws that plan their motion use more than the angles.
        """
        self._host_demands[:] = angles
        if self._plans:
            v, a = self._host_rates
            v[:], a[:] = nan if velocities is None else velocities, nan if accelerations is None else accelerations
            self._demand_age = since

    def perform(
        self, stages: int, supply_now: float, elapsed: float, since: float, level: float, *, follow: bool = False,
        wake: bool = False,
    ) -> int:  # fmt: skip
        """Perform stages of a cycle on the samples and demands that were loaded.

        Args:
            stages: flags of cycle_numbers.py; without a law only the detectors run, whatever the flags.
            supply_now: absolute pressure of the supply, Pa.
            elapsed: time since the last samples, s.
            since: time since the last cycle, s.
            level: level of detection (see detectors/sample.py).
            follow: whether demands are obeyed.
            wake: whether controllers are initialized with the present samples.

        Returns:
            Flags of the outcome (see cycle_numbers.py); after a detected fault no further stage was performed.
        """
        INPUTS_HEADER.pack_into(self._head, 0, supply_now, elapsed, since, level, follow, wake, self._demand_age)
        if self.law is None:
            return self._perform()
        if self.between is None:
            return self._perform(stages)
        outcome = self._perform(stages & ~numbers.GATE_STAGE)
        if outcome & numbers.FAULT_DETECTED:
            return outcome
        if stages & numbers.CONTROL_STAGE:
            self.between()
        return outcome | self._perform(stages & numbers.GATE_STAGE)

    def freeze(self, angles: Array | None = None) -> None:
        """Set the demands to constant angles, rad, (joints,); default: those at which the joints are or can stop.

        With a law that plans its motion the default is the angle that braking leads to: a joint that stops at once
        accelerates the others. It is clipped to the working stroke. Where an angle is not finite, the demand stays.
        """
        held = self._stopping_angles() if angles is None else angles
        self.demands[:] = self.memory["demand.reference"][:] = np.where(np.isfinite(held), held, self.demands)
        self.memory["velocity"][:] = self.memory["acceleration"][:] = 0.0

    def _stopping_angles(self) -> Array:
        """Return the angles at which joints that stop now are held, rad, (joints,)."""
        angles, working = self.memory["estimate.averaged_angle"], self.settings["moving.working"]
        if self._plans:
            velocity = self.memory["estimate.averaged_velocity"]
            angles = angles + 0.5 * velocity * np.abs(velocity) / self.settings["moving.braking"]
        return np.clip(angles, -working, working)

    def has_air(self, supply_now: float, ready: float) -> bool:
        """Return whether the supply is at least `ready` (both absolute, Pa) and every joint has the ripple of air.

        Where the ripple of a joint can't be detected, the supply alone counts.
        """
        if not supply_now >= ready:
            return False
        threshold, ripple = self.settings[MIN_RIPPLE_NAME], self.memory[RIPPLE_NAME]
        return not (threshold > 0.0).all() or bool(((threshold < ripple) & (ripple < inf)).all())

    def hoses_are_filled(self, supply_now: float) -> bool:
        """Return whether every joint's hoses hold, on average, `MIN_FILL_FRACTION` of the supply's gauge pressure.

        `supply_now` is absolute, Pa; pressures of hoses are those of the air estimate.
        """
        empty = self.rig["ambient"][0]
        held = self.memory["air.pressure_a"] + self.memory["air.pressure_b"]
        return bool((held >= 2.0 * (empty + MIN_FILL_FRACTION * (supply_now - empty))).all())

    @property
    def detected_faults(self) -> tuple[Fault, list[Fault]]:
        """Return the fault of the machine as a whole and that of each joint, from the last detection."""
        return Fault(int(self.inputs["fault"][0])), [Fault(int(fault)) for fault in self.faults.tolist()]

    def record(self, rows: Array) -> None:
        """Write the signals of each joint, as in `record.RowLayout` without faults, into rows, (joints, numbers)."""
        assert self.law is not None  # only cores with a law record
        self._write_signals()
        rows[:] = self._signals

    @property
    def max_lead(self) -> float:
        """Return the greatest distance of any joint's demand from its reference, rad."""
        return float(np.abs(self.demands - self.memory["demand.reference"]).max())


def _bound_cycle(arm: NamedRows, law: ArmLaw, arrays: tuple[Array, ...]) -> Callable[..., int]:
    """Return the cycle of an arm with a control law as a function of the stages; plain Python if the law is.

    `arrays` are those of the cycle without the law.
    """
    n, kind = len(law.report.array), law.kind
    column = list(kind.signals).index(kind.gives_up) if kind.gives_up is not None else -1
    scratch = np.zeros((2 * n + 4, n + 1))
    numbers = (*arrays, arm.array[0], law.settings.array[0], law.memory.array[0], law.report.array, scratch)
    likes = compiled.CycleLikes(arm.like, law.settings.like, law.memory.like)
    if kind.compiled:
        likes = compiled.CycleLikes(*map(Like.from_tuple, likes))
        return compiled.run_cycle.bind(likes, (0.0,) * n, column, *numbers, 0)
    return partial(compiled.run_cycle.py_func, likes, (0.0,) * n, column, *numbers)
