"""The cell's hardware in simulation, on one clock: the arm behind the rig's control loop, lift and cup."""

from collections.abc import Callable

import numpy as np

from layflat.arrays import Array
from layflat.bridge import MujocoPlant
from layflat.cell.plan.pick import Command, Readings, Relocation
from layflat.cell.scene import Scene
from layflat.errors import RigStoppedError
from layflat.machine import Machine
from layflat.motion.reach import Angles
from layflat.motion.travel import LEAD, move_arm
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
        self.angles: Angles = tuple(first.angles.tolist())  # averaged, rad
        self.velocities: Angles = (0.0,) * len(self.angles)  # averaged, rad/s
        self.target: Angles = self.angles  # where it is on the way to, rad
        self._demand, self._course, self._at = first.angles.copy(), first.angles[None], 0

    @property
    def cycle(self) -> float:
        """Of its control loop, s."""
        return self.loop.deadlines.cycle

    def go(self, target: Angles) -> None:
        """Move to a posture, rad."""
        if target != self.target:
            start, end = self._demand, np.array(target)
            path = move_arm(self._machine, start, end, payload=self._load, tip_speed=self._tip_speed)
            self._course, self._at, self.target = path.demand(self.cycle, lead=LEAD), 0, target

    def advance(self) -> None:
        """Go through one control cycle; raise RigStoppedError where the rig's supervisor does not let it move."""
        self.loop.cycle()
        supervisor = self.loop.supervisor
        if supervisor.state not in {State.READY, State.MOVING}:
            raise RigStoppedError(f"the rig stopped: {supervisor.ledger.worst.title}")

    def request(self, now: int) -> HostRequest:  # noqa: ARG002  (as the rig's hosts)
        """Return the next row of the course that it is on."""
        self._demand = self._course[min(self._at, len(self._course) - 1)]
        self._at += 1
        return HostRequest(self._demand.tolist())

    def publish(self, row: Array) -> None:
        """Read what the controllers know."""
        self.angles = tuple(self._layout.named(row, "averaged_angle").tolist())
        self.velocities = tuple(self._layout.named(row, "averaged_velocity").tolist())


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

    def advance(self, command: Command) -> None:
        """Go through one control cycle; raise RigStoppedError as `Arm.advance`, DivergedError if the simulation did."""
        self.arm.go(command.target)
        self._scene.lift.demand = self._top - command.height
        self._scene.cup.on = command.suction
        self.arm.advance()
        self._each_cycle()
