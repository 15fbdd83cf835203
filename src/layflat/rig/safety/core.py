"""The numbers of a rig's control cycle, and what performs it on them."""

from collections.abc import Callable, Sequence
from math import inf, isfinite, nan
from struct import Struct

import numpy as np

from layflat.arrays import Array
from layflat.machine import Machine, parameters
from layflat.physics.air_balance import AirEstimate
from layflat.physics.joint import FILLED
from layflat.rig.driver import Reading
from layflat.rig.law import ArmLaw
from layflat.rig.named import NamedRows
from layflat.rig.safety import cycle as compiled
from layflat.rig.safety import cycle_numbers as numbers
from layflat.rig.safety import estimator, moving
from layflat.rig.safety.detectors import joint, supply
from layflat.rig.safety.faults import Fault
from layflat.rig.safety.limits import joint_settings, rig_settings

ENOUGH = 0.4  # of the supply's gauge pressure: joints with less are soft, and fling each other further than filled ones
RIPPLE, LEAST_RIPPLE = "detectors.trace.ripple", "detectors.valve_unresponsive.ripple"
HEAD = Struct(f"{numbers.IN_INPUTS.even}d")  # of the inputs: written in half the time of an array's slice


class Core:
    """A rig's control cycle: its numbers by name, and its stages; without a control law the detectors alone work.

    Raise MachineError if the machine has no valve or sensors.
    """

    def __init__(self, machine: Machine, law: ArmLaw | None = None) -> None:
        names = list(machine.joints)
        self.rig = NamedRows([rig_settings(machine)])
        self.settings = NamedRows([joint_settings(machine, name) for name in names])
        self.memory, self.inputs = NamedRows([numbers.MEMORY] * len(names)), NamedRows([numbers.INPUTS])
        self.law = law
        self._given, self._head = np.zeros((len(names), numbers.JOINT_INPUTS)), self.inputs.array[0]
        about = self.rig.array[0], self.settings.array
        self._arrays: tuple[Array, ...] = (*about, self._head, self._given, self.memory.array)
        self._perform: Callable[..., int] = compiled.judge
        if law is not None:
            arm = NamedRows([parameters.arm(machine)])
            own, memory, report = law.settings, law.memory, law.report
            self._arrays += (arm.array[0], own.array[0], memory.array[0], report.array)
            self._perform = compiled.cycle_with(arm.like, own.like, memory.like, len(names))
        # What comes in: samples (rad, Pa), and the demands of the host (rad, rad/s, rad/s2), (joints,).
        self.angles, self.pressures, self._asked, *self._rates = self._given.T[:5]
        self._meant, self._plans = 0.0, law is not None and law.kind.plans
        self.between: Callable[[], object] | None = None  # is called between control law and the gate of its voltages
        self.voltages_asked = self.memory["asked"]  # what the control law asked for, V, (joints,)
        self.demands, self.voltages = self.memory["demand.demand"], self.memory["voltage"]  # let through, rad and V
        self.faults, self.outcomes = self.memory["fault"], self.memory["outcome"]  # of the joints in this cycle
        self.memory.replace("stream", moving.Stream())
        self.voltages[:] = self.voltages_asked[:] = self.rig["centre"][0]
        self.reset()

    def reset(self) -> None:
        """Forget what the detectors saw; what the hoses hold, and demands, are kept."""
        self.memory.replace("detectors", joint.FRESH)
        self.inputs.replace("lines", supply.Memory())
        self.inputs["even"][0] = compiled.CALM

    def begin(self, reading: Reading, *, filled: bool) -> None:
        """Take the hoses for empty, or for filled as they are when left to themselves."""
        empty = self.rig["ambient"][0]
        held = max(FILLED * reading.supply if filled else empty, empty)
        for j, (angle, pressure) in enumerate(zip(reading.angles, reading.pressures, strict=True)):
            half = 0.5 * pressure if isfinite(pressure) else 0.0
            self.memory.replace("air", AirEstimate(held + half, held - half, angle, 0.0, 0.0), j)

    def wake(self, reading: Reading) -> None:
        """Start control law and estimators at this reading."""
        angles, pressures = reading.angles.tolist(), reading.pressures.tolist()
        for j, (angle, pressure) in enumerate(zip(angles, pressures, strict=True)):
            self.memory.replace("estimator", estimator.woken(angle, pressure), j)
        if self.law is not None:
            self.law.wake(angles, pressures)

    def take(self, reading: Reading) -> None:
        """Take in what was sampled."""
        self.angles[:], self.pressures[:] = reading.angles, reading.pressures

    def ask(
        self, angles: Sequence[float], velocities: Sequence[float] | None = None,
        accelerations: Sequence[float] | None = None, since: float = 0.0,
    ) -> None:  # fmt: skip
        """Take in what the host asks for, rad, rad/s and rad/s2, meant so many seconds ago; see `HostRequest`."""
        self._asked[:] = angles
        if self._plans:
            v, a = self._rates
            v[:], a[:] = nan if velocities is None else velocities, nan if accelerations is None else accelerations
            self._meant = since

    def perform(
        self, stages: int, supply_now: float, elapsed: float, since: float, level: float, *, follow: bool = False,
        wake: bool = False,
    ) -> int:  # fmt: skip
        """Perform stages of a cycle and return what came of them; both are flags of cycle.py.

        What comes in are the first fields of `cycle.Inputs`: absolute supply (Pa), times since the last samples and
        since the last cycle (s), what there is to watch, whether demands are obeyed, whether controllers begin anew.
        """
        HEAD.pack_into(self._head, 0, supply_now, elapsed, since, level, follow, wake, self._meant)
        if self.law is None:
            return self._perform(*self._arrays)
        if self.between is None:
            return self._perform(*self._arrays, stages)
        came = self._perform(*self._arrays, stages & ~numbers.GATE)
        if came & numbers.FOUND:
            return came
        if stages & numbers.CONTROL:
            self.between()
        return came | self._perform(*self._arrays, stages & numbers.GATE)

    def freeze(self, angles: Array | None = None) -> None:
        """From now on ask the joints for these angles, rad; where they are not given, for those where they are.

        A law that plans its motion is asked to brake instead: what stops at once flings the other joints on. Joints
        beyond their working stroke are led back to it.
        """
        wanted = self._stopping() if angles is None else angles
        self.demands[:] = self.memory["demand.reference"][:] = np.where(np.isfinite(wanted), wanted, self.demands)
        self.memory["velocity"][:] = self.memory["acceleration"][:] = 0.0

    def _stopping(self) -> Array:
        """Return where joints are held that are to stop, rad."""
        place, working = self.memory["estimate.averaged_angle"], self.settings["moving.working"]
        if self._plans:
            velocity = self.memory["estimate.averaged_velocity"]
            place = place + 0.5 * velocity * np.abs(velocity) / self.settings["moving.braking"]
        return np.clip(place, -working, working)

    def air_is_there(self, supply_now: float, ready: float) -> bool:
        """Return whether supply (absolute, Pa) and ripple are those of a machine that can move."""
        if not supply_now >= ready:
            return False
        least, ripple = self.settings[LEAST_RIPPLE], self.memory[RIPPLE]
        return not (least > 0.0).all() or bool(((least < ripple) & (ripple < inf)).all())

    def hoses_are_filled(self, supply_now: float) -> bool:
        """Return whether every pair of hoses holds what it takes to move well; supply absolute, Pa."""
        empty = self.rig["ambient"][0]
        held = self.memory["air.pressure_a"] + self.memory["air.pressure_b"]
        return bool((held >= 2.0 * (empty + ENOUGH * (supply_now - empty))).all())

    @property
    def found(self) -> tuple[Fault, list[Fault]]:
        """Faults of the machine as a whole, and of each joint, as they were judged last."""
        return Fault(int(self.inputs["fault"][0])), [Fault(int(fault)) for fault in self.faults.tolist()]

    def record(self, rows: Array) -> None:
        """Write what is known of each joint, as in `record.Layout` and without faults, (joints, numbers)."""
        assert self.law is not None  # who asks has given one
        compiled.record(rows, self._given, self.memory.array, self.law.report.array, self.law.recorded)

    @property
    def lead(self) -> float:
        """Return how far any demand is ahead of its reference at most, rad."""
        return float(np.abs(self.demands - self.memory["demand.reference"]).max())
