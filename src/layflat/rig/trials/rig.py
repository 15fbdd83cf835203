"""Rig of the trials: a loop in this process, a device in another, and a clock that both share.

Time passes on both sides only while the loop waits for its next deadline: trials run faster than real time, over the
real protocol, and the same seed leads to the same instants.
"""

from collections.abc import Callable
from math import inf, nan
from typing import NamedTuple

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.machine.parameters import torque_constant
from layflat.rig.abilities import falls_without_air, max_gravity_torques
from layflat.rig.clock import NS_PER_SECOND
from layflat.rig.device.process import DeviceProcess
from layflat.rig.device.virtual import VirtualDevice
from layflat.rig.device_state import DeviceState
from layflat.rig.driver import Driver
from layflat.rig.loop import LoopRecorder, RigLoop
from layflat.rig.safety.detectors.following import advance_expected_angle
from layflat.rig.safety.faults import RigState
from layflat.rig.safety.limits import detector_limits
from layflat.rig.safety.supervisor import HostRequest


class DeviceTruth(NamedTuple):
    """True state of the device, whatever its sensors report."""

    angles: list[float]  # rad
    velocities: list[float]  # rad/s
    pressures: list[float]  # the higher of each joint's hoses, absolute, Pa
    supply: float  # of the line, absolute, Pa
    device: DeviceState


def advance_device(device: VirtualDevice, until: int) -> DeviceTruth:
    """Advance a device to an instant (ns), and return its true state; called on the device."""
    device.clock.wait(until)
    device.tick()
    plant = device.plant
    highest = plant.pressures.max(axis=1).tolist()
    return DeviceTruth(plant.angles.tolist(), plant.velocities.tolist(), highest, plant.supply, device.state)


class SharedClock:
    """Clock of device and loop in one; an action can be scheduled at an instant between deadlines."""

    def __init__(self, device: DeviceProcess) -> None:
        self._device, self._now = device, 0
        self.truth: DeviceTruth = device.call(advance_device, 0)  # of the device, now
        self._due: tuple[int, Callable[[], object]] | None = None

    def now(self) -> int:
        """Return the instant last waited for, ns."""
        return self._now

    def wait(self, until: int) -> None:
        """Advance the device to an instant (ns), unless it has passed, and perform the scheduled action on the way."""
        if self._due is not None and self._due[0] <= until:
            (at, action), self._due = self._due, None
            self.wait(at)
            action()
        if until > self._now:
            self._now, self.truth = until, self._device.call(advance_device, until)

    def schedule(self, instant: int, action: Callable[[], object]) -> None:
        """Schedule an action to be performed once, at an instant, ns; it replaces one that is scheduled."""
        self._due = instant, action


class ScriptedHost:
    """Host whose requests are attributes, and which can fall silent."""

    ended = False

    def __init__(self, joints: int) -> None:
        self.demands = [nan] * joints
        self.silent_since: int | None = None  # instant from which on it is silent, ns
        self.edges: set[str] = set()

    def request(self, now: int) -> HostRequest:
        """Return the host's request at an instant, ns; each edge is returned once."""
        edges, self.edges = self.edges, set()
        age = 0.0 if self.silent_since is None else (now - self.silent_since) / NS_PER_SECOND
        return HostRequest(self.demands, "start" in edges, "stop" in edges, "reset" in edges, age)

    def publish(self, row: Array) -> None:
        """Ignore a row."""


class KillableRecorder(LoopRecorder):
    """Recorder that keeps events but no rows, and can be killed."""

    def __init__(self) -> None:
        self.dead = False
        self.lines: list[str] = []

    def event(self, text: str) -> None:
        """Keep a line."""
        self.lines.append(text)

    def is_alive(self) -> bool:
        """Return whether it is not killed."""
        return not self.dead


class TrialRig:
    """Loop of a machine with its virtual rig: a device in lockstep, and a driver to it."""

    def __init__(self, machine: Machine, device: DeviceProcess, driver: Driver) -> None:
        self.machine, self.device, self.period = machine, device, machine.cycle
        self.clock, self.host, self.recorder = (
            SharedClock(device),
            ScriptedHost(len(machine.joints)),
            KillableRecorder(),
        )
        driver.configure()
        self.loop = RigLoop(machine, driver, self.clock, self.host, self.recorder)
        self.supervisor = self.loop.supervisor
        driver.activate()
        self.following = [detector_limits(machine, name).following for name in machine.joints]
        # Differential pressures with which hoses carry an arm that is lowered, Pa, (joints,).
        self.carries = (
            max_gravity_torques(machine)
            / [torque_constant(joint) for joint in machine.joints.values()]
            * falls_without_air(machine)
        )
        self._line = 0.0
        self.reaches = list(self.truth.angles)  # expected angles of the joints, as of `following`, rad
        self.clear_peaks()

    @property
    def truth(self) -> DeviceTruth:
        """Return the true state of the device."""
        return self.clock.truth

    def clear_peaks(self) -> None:
        """Reset the peaks."""
        self.furthest = [0.0] * len(self.machine.joints)  # greatest turn from mid-stroke of each joint since then, rad
        self.above_supply = -inf  # highest pressure in any hose since then, less the highest that the line ever had, Pa

    def cycle(self) -> None:
        """Perform one control cycle, and update peaks and expected angles."""
        self.loop.cycle()
        self.update_peaks()

    def update_peaks(self) -> None:
        """Update the peaks, and advance the expected angles by a cycle, with the true state of the device."""
        self._line = max(self._line, self.truth.supply)
        self.above_supply = max(self.above_supply, max(self.truth.pressures) - self._line)
        for j, (angle, demand) in enumerate(zip(self.truth.angles, self.supervisor.demands, strict=True)):
            self.furthest[j] = max(self.furthest[j], abs(angle))
            self.reaches[j] = advance_expected_angle(self.following[j], self.reaches[j], angle, demand, self.period)

    def ready(self) -> None:
        """Reset, then start softly; return once the rig obeys, or else 0.5 s after the machine's start time."""
        self.host.edges = {"reset"}
        self.cycle()
        self.host.edges = {"start"}
        for _ in range(round((self.machine.safety.start_time + 0.5) / self.period)):
            self.cycle()
            if self.supervisor.state in {RigState.READY, RigState.MOVING}:
                return
