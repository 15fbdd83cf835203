"""The rig that is tried: a loop in this process, a device in another, and a clock that both live by.

Time passes on both sides only while the loop waits for its next deadline: trials go faster than real ones, over the
real protocol, and the same seed gives the same instants.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from math import inf, nan
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from layflat.machine import Machine
from layflat.rig.clock import SECOND
from layflat.rig.device.process import DeviceProcess
from layflat.rig.device.virtual import VirtualDevice
from layflat.rig.driver import DeviceState, Driver
from layflat.rig.loop import Loop, Recorder
from layflat.rig.safety.detectors.following import reached
from layflat.rig.safety.limits import joint_limits
from layflat.rig.safety.states import State
from layflat.rig.safety.supervisor import HostRequest, Supervisor

Array = NDArray[np.float64]


class Truth(NamedTuple):
    """What is so on the device, whatever its sensors say."""

    angles: tuple[float, ...]
    """rad"""
    velocities: tuple[float, ...]
    """rad/s"""
    pressures: tuple[float, ...]
    """The higher of each joint's hoses, absolute, Pa."""
    supply: float
    """Of the line, absolute, Pa."""
    device: DeviceState


def truth(device: VirtualDevice) -> Truth:
    """Look at a device from within."""
    plant = device.plant
    highest = plant.pressures.max(axis=1)
    return Truth(
        tuple(plant.angles.tolist()), tuple(plant.velocities.tolist()), tuple(highest.tolist()), plant.supply,
        device.state,
    )  # fmt: skip


class SharedClock:
    """The device's clock and the loop's in one; something may be made to happen at an instant between deadlines."""

    def __init__(self, device: DeviceProcess) -> None:
        self._device, self._now = device, 0
        self._due: tuple[int, Callable[[], None]] | None = None

    def now(self) -> int:
        """Nanoseconds, as last waited for."""
        return self._now

    def wait(self, until: int) -> None:
        """Let time pass on the device."""
        if self._due is not None and self._due[0] <= until:
            at, action = self._due
            self._due = None
            self._pass(at)
            action()
        self._pass(until)

    def at(self, instant: int, action: Callable[[], None]) -> None:
        """Have something done once, as soon as time comes there."""
        self._due = instant, action

    def _pass(self, until: int) -> None:
        if until > self._now:
            self._device.advance(until)
            self._now = until


@dataclass
class Script:
    """A host that asks for random moves, and stops talking when told to."""

    joints: int
    demands: list[float] = field(default_factory=list)
    silent_since: int | None = None
    """From this instant on (ns) nothing new is heard of it."""
    edges: set[str] = field(default_factory=set)
    ended: bool = False

    def __post_init__(self) -> None:
        self.demands = [nan] * self.joints

    def request(self, now: int) -> HostRequest:
        """What is wanted now."""
        edges, self.edges = self.edges, set()
        age = 0.0 if self.silent_since is None else (now - self.silent_since) / SECOND
        return HostRequest(self.demands, "start" in edges, "stop" in edges, "reset" in edges, age)

    def publish(self, row: Array) -> None:
        """Nobody looks on."""


class KillableRecorder:
    """Keeps nothing, and dies when told to; what was said is kept."""

    def __init__(self) -> None:
        self.dead = False
        self.lines: list[str] = []

    def push(self, row: Array) -> None:
        """Forget a row."""

    def event(self, text: str) -> None:
        """Keep a line."""
        self.lines.append(text)

    def alive(self) -> bool:
        """Until it is told to die."""
        return not self.dead


class FaultInjectingLoop(Loop):
    """A loop whose controllers can be made to ask for nonsense."""

    def inject(self, joint: int, voltage: float | None) -> None:
        """Let a joint's controller ask for a voltage from now on, V; None lets it be."""
        core = self.supervisor.core
        core.between = None if voltage is None else lambda: core.voltages_asked.__setitem__(joint, voltage)


@dataclass
class Peaks:
    """How far things went since they were last cleared."""

    angles: list[float]
    """Greatest turn from mid-stroke of each joint, rad."""
    pressure: float = 0.0
    """Highest in any hose, absolute, Pa."""
    above_supply: float = -inf
    """Highest in any hose less the highest that the line has had, Pa."""


class TrialRig:
    """A loop with its virtual rig, ready to be tried.

    Args:
        machine: with controller.
        device: in lockstep.
        driver: to the device, unconfigured.
        recorder: what keeps the rows.
    """

    def __init__(
        self, machine: Machine, device: DeviceProcess, driver: Driver, recorder: Recorder | None = None
    ) -> None:
        self.machine, self.device = machine, device
        self.clock = SharedClock(device)
        self.host = Script(len(machine.joints))
        self.recorder = KillableRecorder()
        driver.configure()
        self.driver = driver
        self.loop = FaultInjectingLoop(machine, driver, self.clock, self.host, recorder or self.recorder)
        driver.activate()
        assert machine.controller is not None  # the loop has taken its gains
        self.period = machine.controller.cycle
        self.following = [joint_limits(machine, name).following for name in machine.joints]
        self.peaks = Peaks([0.0] * len(machine.joints))
        self._line = 0.0
        self.truth: Truth = device.call(truth)
        self.reaches = list(self.truth.angles)
        """Where each joint's demand has led it by now, as the watch of the following error means it, rad."""

    @property
    def supervisor(self) -> Supervisor:
        """Of the loop."""
        return self.loop.supervisor

    @property
    def lead(self) -> float:
        """How far any joint's demand is ahead of what it could reach, rad."""
        return self.supervisor.core.lead

    def cycle(self) -> None:
        """One control cycle, and a look at what is so."""
        self.loop.cycle()
        self.look()

    def look(self) -> None:
        """See what is so on the device, and keep the peaks."""
        self.truth = self.device.call(truth)
        peaks = self.peaks
        peaks.angles = [max(a, abs(b)) for a, b in zip(peaks.angles, self.truth.angles, strict=True)]
        self._line = max(self._line, self.truth.supply)
        for j, (angle, demand) in enumerate(zip(self.truth.angles, self.supervisor.demands, strict=True)):
            self.reaches[j] = reached(self.following[j], self.reaches[j], angle, demand, self.period)
        peaks.pressure = max(peaks.pressure, *self.truth.pressures)
        peaks.above_supply = max(peaks.above_supply, max(self.truth.pressures) - self._line)

    def clear_peaks(self) -> None:
        """Begin anew with the peaks."""
        self.peaks = Peaks([0.0] * len(self.machine.joints))

    def ready(self) -> bool:
        """Bring the air, and whether it came within the time that the machine's file gives."""
        self.host.edges = {"reset"}
        self.cycle()
        self.host.edges = {"start"}
        for _ in range(round((self.machine.safety.start_time + 0.5) / self.period)):
            self.cycle()
            if self.supervisor.state in {State.READY, State.MOVING}:
                return True
        return False
