"""The rig that is tried: a loop in this process, a device in another, and a clock that both live by.

Time passes on both sides only while the loop waits for its next deadline: trials go faster than real ones, over the
real protocol, and the same seed gives the same instants.
"""

from collections.abc import Callable
from math import inf, nan
from typing import NamedTuple

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.machine.parameters import torque_constant
from layflat.rig.abilities import falls, pulls
from layflat.rig.clock import SECOND
from layflat.rig.device.process import DeviceProcess
from layflat.rig.device.virtual import VirtualDevice
from layflat.rig.driver import DeviceState, Driver
from layflat.rig.loop import Loop, Recorder
from layflat.rig.safety.detectors.following import reached
from layflat.rig.safety.limits import joint_limits
from layflat.rig.safety.states import State
from layflat.rig.safety.supervisor import HostRequest


class Truth(NamedTuple):
    """What is so on the device, whatever its sensors say."""

    angles: list[float]  # rad
    velocities: list[float]  # rad/s
    pressures: list[float]  # the higher of each joint's hoses, absolute, Pa
    supply: float  # of the line, absolute, Pa
    device: DeviceState


def elapse(device: VirtualDevice, until: int) -> Truth:
    """Let time pass on a device up to an instant (ns), and look at it from within; called there."""
    device.clock.wait(until)
    device.tick()
    plant = device.plant
    highest = plant.pressures.max(axis=1).tolist()
    return Truth(plant.angles.tolist(), plant.velocities.tolist(), highest, plant.supply, device.state)


class SharedClock:
    """The device's clock and the loop's in one; something may be made to happen at an instant between deadlines."""

    def __init__(self, device: DeviceProcess) -> None:
        self._device, self._now = device, 0
        self.truth: Truth = device.call(elapse, 0)  # of the device, now
        self._due: tuple[int, Callable[[], object]] | None = None

    def now(self) -> int:
        """Nanoseconds, as last waited for."""
        return self._now

    def wait(self, until: int) -> None:
        """Let time pass on the device."""
        if self._due is not None and self._due[0] <= until:
            (at, action), self._due = self._due, None
            self.wait(at)
            action()
        if until > self._now:
            self._now, self.truth = until, self._device.call(elapse, until)

    def at(self, instant: int, action: Callable[[], object]) -> None:
        """Have something done once, as soon as time comes there."""
        self._due = instant, action


class Script:
    """A host that asks for random moves, and stops talking when told to."""

    ended = False

    def __init__(self, joints: int) -> None:
        self.demands = [nan] * joints
        self.silent_since: int | None = None  # from this instant on (ns) nothing new is heard of it
        self.edges: set[str] = set()

    def request(self, now: int) -> HostRequest:
        """What is wanted now."""
        edges, self.edges = self.edges, set()
        age = 0.0 if self.silent_since is None else (now - self.silent_since) / SECOND
        return HostRequest(self.demands, "start" in edges, "stop" in edges, "reset" in edges, age)

    def publish(self, row: Array) -> None:
        """Nobody looks on."""


class KillableRecorder(Recorder):
    """Keeps no rows, but what was said, and dies when told to."""

    def __init__(self) -> None:
        self.dead = False
        self.lines: list[str] = []

    def event(self, text: str) -> None:
        """Keep a line."""
        self.lines.append(text)

    def alive(self) -> bool:
        """Until it is told to die."""
        return not self.dead


class TrialRig:
    """A loop of a machine with its virtual rig, ready to be tried: a device in lockstep, and a driver to it."""

    def __init__(self, machine: Machine, device: DeviceProcess, driver: Driver) -> None:
        self.machine, self.device, self.period = machine, device, machine.cycle
        self.clock, self.host, self.recorder = SharedClock(device), Script(len(machine.joints)), KillableRecorder()
        driver.configure()
        self.loop = Loop(machine, driver, self.clock, self.host, self.recorder)
        self.supervisor = self.loop.supervisor
        driver.activate()
        self.following = [joint_limits(machine, name).following for name in machine.joints]
        # Pressures with which hoses carry an arm that is let down, Pa, (joints,).
        self.carries = pulls(machine) / [torque_constant(joint) for joint in machine.joints.values()] * falls(machine)
        self._line = 0.0
        self.reaches = list(self.truth.angles)  # where demands have led the joints, as `following` means it, rad
        self.clear_peaks()

    @property
    def truth(self) -> Truth:
        """What is so on the device."""
        return self.clock.truth

    def clear_peaks(self) -> None:
        """Begin anew with the peaks."""
        self.furthest = [0.0] * len(self.machine.joints)  # greatest turn from mid-stroke of each joint since then, rad
        self.above_supply = -inf  # highest pressure in any hose since then, less the highest that the line ever had, Pa

    def cycle(self) -> None:
        """One control cycle, and a look at what came of it."""
        self.loop.cycle()
        self.look()

    def look(self) -> None:
        """Keep the peaks of what is so on the device."""
        self._line = max(self._line, self.truth.supply)
        self.above_supply = max(self.above_supply, max(self.truth.pressures) - self._line)
        for j, (angle, demand) in enumerate(zip(self.truth.angles, self.supervisor.demands, strict=True)):
            self.furthest[j] = max(self.furthest[j], abs(angle))
            self.reaches[j] = reached(self.following[j], self.reaches[j], angle, demand, self.period)

    def ready(self) -> None:
        """Bring the air, or give up after the time in which the machine's file says that it comes."""
        self.host.edges = {"reset"}
        self.cycle()
        self.host.edges = {"start"}
        for _ in range(round((self.machine.safety.start_time + 0.5) / self.period)):
            self.cycle()
            if self.supervisor.state in {State.READY, State.MOVING}:
                return
