"""The cell's hardware in simulation, on one clock: the arm behind the rig's control loop, lift and cup."""

from collections.abc import Callable

import numpy as np

from layflat.arrays import Array
from layflat.bridge import MujocoPlant
from layflat.cell.plan.pick import Command, Readings, Relocation
from layflat.cell.scene import Scene
from layflat.errors import RigStoppedError
from layflat.machine import Machine
from layflat.motion.following import following
from layflat.motion.limits import arm_limits
from layflat.motion.meeting import Course, Meeting, meet
from layflat.motion.reach import Angles
from layflat.motion.trajectory import States, at_rest
from layflat.motion.travel import move_arm
from layflat.physics.air import NORMAL_DENSITY
from layflat.rig.clock import SECOND, Clock, VirtualClock
from layflat.rig.device.virtual import VirtualDevice
from layflat.rig.driver import Driver
from layflat.rig.drivers.simulated import SimulatedDriver
from layflat.rig.loop import Loop
from layflat.rig.record import Layout
from layflat.rig.safety.states import State
from layflat.rig.safety.supervisor import HostRequest

LITRES = 1000.0  # in a m3
MEAN_AGE = 1.5  # of averaged angles, cycles: they are means of four samples
SOON = 0.4  # in which a meeting usually comes, s
NOWHERE: Angles = ()  # target of an arm that goes with what moves


class Arm:
    """An arm on a rig whose air is there; it is the host of the rig's loop, and goes to targets within its limits.

    The driver of its rig is not yet configured. The load (kg) is the greatest that it carries, lift included, and the
    speed (m/s) the greatest of its tip.
    """

    ended = False

    def __init__(self, machine: Machine, driver: Driver, clock: Clock, *, load: float, tip_speed: float) -> None:
        self._machine, self._load, self._tip_speed = machine, load, tip_speed
        self._layout = Layout.of(machine)
        driver.configure()
        driver.activate()
        self.loop = Loop(machine, driver, clock, self, None)
        first = driver.read()
        self.loop.begin(first)
        self.angles: Angles = tuple(first.angles.tolist())  # averaged, and led on by what that is late, rad
        self.velocities: Angles = (0.0,) * len(self.angles)  # averaged, rad/s
        self.target: Angles = self.angles  # where it is on the way to, rad
        self._following = following(machine)
        self._asked = at_rest(first.angles)  # in the last cycle
        self._course = at_rest(first.angles[None])  # a row a cycle
        self._at = 0  # row that is next
        self._passing: Course | None = None  # of what it meets, and goes on with after the last row
        self._now = clock.now() / SECOND  # of the last cycle, s

    @property
    def cycle(self) -> float:
        """Of its control loop, s."""
        return self.loop.deadlines.cycle

    def go(self, target: Angles) -> None:
        """Move to a posture, rad."""
        if target != self.target:
            way = move_arm(
                self._machine, self._asked, np.array(target), payload=self._load, tip_speed=self._tip_speed,
                shares=self._following.shares,
            )  # fmt: skip
            self._course, self._at = self._following.demands(way, self.cycle), 1
            self._passing, self.target = None, target

    def meeting(self, course: Course) -> Meeting | None:
        """Return how it would soonest come over what moves, and with its velocity; None where it can't."""
        soon = min(max(course.enters, self._now + SOON), course.leaves)
        if soon < self._now:
            return None
        middle = course.state(soon).angles
        limits = arm_limits(self._machine, self._asked.angles, middle, payload=self._load)
        shares = limits.shares(*self._following.shares)
        return meet(self._machine, self._asked, self._now, course, shares, self._tip_speed)

    def follow(self, course: Course) -> None:
        """Go on to what moves, and with it; where it can't be met, what was known of its course before still counts."""
        if course is not self._passing and (found := self.meeting(course)) is not None:
            self._course, self._at = self._following.demands(found.way, self.cycle), 1
            self._passing, self.target = course, NOWHERE

    def advance(self) -> None:
        """Go through one control cycle; raise RigStoppedError where the rig's supervisor does not let it move."""
        self.loop.cycle()
        supervisor = self.loop.supervisor
        if supervisor.state not in {State.READY, State.MOVING}:
            raise RigStoppedError(f"the rig stopped: {supervisor.ledger.worst.title}")

    def request(self, now: int) -> HostRequest:
        """Return what the course that it is on demands in this cycle."""
        self._now, row = now / SECOND, self._at
        last = len(self._course.angles) - 1
        if row > last and self._passing is not None and self._now < self._passing.leaves:
            self._asked = self._following.demand(self._passing.state(self._now))
        else:
            self._asked = States(*(of[min(row, last)] for of in self._course))
        self._at += 1
        angles, velocities, accelerations = (of.tolist() for of in self._asked)
        return HostRequest(angles, velocities=velocities, accelerations=accelerations)

    def publish(self, row: Array) -> None:
        """Read what the controllers know."""
        angles, velocities = self._layout.named(row, "averaged_angle"), self._layout.named(row, "averaged_velocity")
        self.angles = tuple((angles + MEAN_AGE * self.cycle * velocities).tolist())
        self.velocities = tuple(velocities.tolist())


class Station:
    """A scene's arm, lift and cup, as a control loop of 5 ms meets them: what is measured, and what is commanded.

    The seed is that of the sensors' noise; `each_cycle` is called after every control cycle.
    """

    def __init__(self, scene: Scene, seed: int, each_cycle: Callable[[], object] = lambda: None) -> None:
        cell, self._scene, self._clock = scene.cell, scene, VirtualClock()
        self._plant = MujocoPlant(
            cell.machine, scene.model, scene.data, seed=seed, step=lambda advance: scene.step(1, advance)
        )
        driver = SimulatedDriver(VirtualDevice(cell.machine, self._plant, self._clock, running=True))
        load = cell.lift.body + cell.lift.mass + cell.heaviest_fruit
        self.arm = Arm(cell.machine, driver, self._clock, load=load, tip_speed=cell.limits.speed)
        self._top, self._each_cycle = cell.lift.clearance, each_cycle

    @property
    def time(self) -> float:
        """Since it began, s."""
        return self._clock.now() / SECOND

    @property
    def air(self) -> float:
        """Taken by joints, lift and cup so far, normal litres."""
        joints = sum(ledger.air_taken for ledger in self._plant.ledgers) / NORMAL_DENSITY
        return LITRES * (joints + self._scene.lift.air + self._scene.cup.air)

    def measure(self, relocation: Relocation | None = None) -> Readings:
        """Return what sensors give, and what an image showed of a fruit that was missed."""
        arm, scene = self.arm, self._scene
        lip, speed = self._top - scene.stroke, -scene.stroke_speed
        return Readings(self.time, arm.angles, arm.velocities, scene.cup.vacuum, lip, speed, relocation)

    def advance(self, command: Command, course: Course | None = None) -> None:
        """Go through one control cycle, with the arm on its way to the command's target, or with what is on a course.

        Raises RigStoppedError as `Arm.advance`, DivergedError if the simulation did.
        """
        if course is None:
            self.arm.go(command.target)
        else:
            self.arm.follow(course)
        self._scene.lift.demand = self._top - command.height
        self._scene.cup.on = command.suction
        self.arm.advance()
        self._each_cycle()
