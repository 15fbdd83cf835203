"""Simulated hardware of the cell, on one clock: the arm behind the rig's control loop, lift and cup."""

from collections.abc import Callable

import numpy as np

from layflat.arrays import Array
from layflat.bridge import MujocoPlant
from layflat.cell.plan.pick import CellReadings, PickCommand, Relocation
from layflat.cell.scene import Scene
from layflat.errors import RigStoppedError
from layflat.machine import Machine
from layflat.motion.limits import arm_limits
from layflat.motion.meeting import Meeting, MovingTarget, plan_meeting
from layflat.motion.planar import Angles
from layflat.motion.trajectory import States, rest_states
from layflat.motion.travel import demand_style, plan_move
from layflat.physics.air import NORMAL_DENSITY
from layflat.rig.clock import NS_PER_SECOND, LoopClock, VirtualClock
from layflat.rig.device.virtual import SimulatedDriver, VirtualDevice
from layflat.rig.driver import Driver
from layflat.rig.loop import RigLoop
from layflat.rig.record import RowLayout
from layflat.rig.safety.faults import RigState
from layflat.rig.safety.supervisor import HostRequest

LITRES_PER_CUBIC_METRE = 1000.0
MEAN_AGE = 1.5  # of averaged angles, which are means of four samples, cycles
TYPICAL_MEETING_TIME = 0.4  # until the arm meets a moving fruit, s
NO_TARGET: Angles = ()  # of an arm that follows a moving fruit


class CellArm:
    """Arm on a rig with air supply: the host of the rig's control loop, which moves to targets within its limits.

    Args:
        machine: description.
        driver: driver of the rig, not yet configured.
        clock: clock of the control loop.
        load: greatest load, lift included, kg.
        tip_speed: greatest speed of the tip, m/s.
    """

    ended = False

    def __init__(self, machine: Machine, driver: Driver, clock: LoopClock, *, load: float, tip_speed: float) -> None:
        """Configure and activate the driver, and begin its control loop filled with air, at the present angles."""
        self._machine, self._load, self._tip_speed = machine, load, tip_speed
        self.layout = RowLayout.for_machine(machine)
        self.row: Array = np.zeros(self.layout.width)  # record of the last cycle
        driver.configure()
        driver.activate()
        self.loop = RigLoop(machine, driver, clock, self, None)
        first = driver.read()
        self.loop.start_filled(first)
        self.angles: Angles = tuple(first.angles.tolist())  # averaged, and extrapolated by the delay of that, rad
        self.velocities: Angles = (0.0,) * len(self.angles)  # averaged, rad/s
        self.target: Angles = self.angles  # of the present motion, rad
        self._following = demand_style(machine)
        self._asked = rest_states(first.angles)  # in the last cycle
        self._course = rest_states(first.angles[None])  # a row a cycle
        self._at = 0  # row that is next
        self._passing: MovingTarget | None = None  # of what it meets, and goes on with after the last row
        self._now = clock.now() / NS_PER_SECOND  # of the last cycle, s

    @property
    def cycle(self) -> float:
        """Cycle of the control loop, s."""
        return self.loop.deadlines.cycle

    def go(self, target: Angles) -> None:
        """Plan a motion to joint angles (rad), if they are a new target, from the present demand, for `advance`."""
        if target != self.target:
            way = plan_move(
                self._machine, self._asked, np.array(target), payload=self._load, tip_speed=self._tip_speed,
                fractions=self._following.limit_fractions,
            )  # fmt: skip
            self._course, self._at = self._following.demands(way, self.cycle), 1
            self._passing, self.target = None, target

    def meeting(self, course: MovingTarget) -> Meeting | None:
        """Return the earliest meeting with a moving fruit at its velocity; None where there is none."""
        soon = min(max(course.entry_time, self._now + TYPICAL_MEETING_TIME), course.braking_time)
        if soon < self._now:
            return None
        middle = course.state(soon).angles
        limits = arm_limits(self._machine, self._asked.angles, middle, payload=self._load)
        shares = limits.scaled(*self._following.limit_fractions)
        return plan_meeting(self._machine, self._asked, self._now, course, shares, self._tip_speed)

    def follow(self, course: MovingTarget) -> None:
        """Plan a motion to a moving fruit, if its course is new; where it can't be met, the last motion goes on.

        After the meeting the arm follows the course until its braking time.
        """
        if course is not self._passing and (found := self.meeting(course)) is not None:
            self._course, self._at = self._following.demands(found.motion, self.cycle), 1
            self._passing, self.target = course, NO_TARGET

    def advance(self) -> None:
        """Run one control cycle; raise RigStoppedError if the rig's supervisor has stopped the arm."""
        self.loop.cycle()
        supervisor = self.loop.supervisor
        if supervisor.state not in {RigState.READY, RigState.MOVING}:
            raise RigStoppedError(f"the rig stopped: {supervisor.ledger.worst.title}")

    def request(self, now: int) -> HostRequest:
        """Return the demand of the present motion in this cycle, which begins at `now`, ns."""
        self._now, row = now / NS_PER_SECOND, self._at
        last = len(self._course.angles) - 1
        if row > last and self._passing is not None and self._now < self._passing.braking_time:
            self._asked = self._following.demand(self._passing.state(self._now))
        else:
            self._asked = States(*(of[min(row, last)] for of in self._course))
        self._at += 1
        angles, velocities, accelerations = (of.tolist() for of in self._asked)
        return HostRequest(angles, velocities=velocities, accelerations=accelerations)

    def publish(self, row: Array) -> None:
        """Store a row of the record; set `angles` (extrapolated) and `velocities` from its averages."""
        self.row = row
        angles, velocities = self.layout.named(row, "averaged_angle"), self.layout.named(row, "averaged_velocity")
        self.angles = tuple((angles + MEAN_AGE * self.cycle * velocities).tolist())
        self.velocities = tuple(velocities.tolist())


class CellStation:
    """Arm, lift and cup of a scene as seen by the machine's control loop: sensor readings and commands.

    Args:
        scene: physical scene.
        seed: seed of the sensors' noise.
        each_cycle: called after every control cycle.
    """

    def __init__(self, scene: Scene, seed: int, each_cycle: Callable[[], object] = lambda: None) -> None:
        """Make the scene's machine a virtual device, filled with air, behind a control loop on a virtual clock."""
        cell, self._scene, self._clock = scene.cell, scene, VirtualClock()
        self._plant = MujocoPlant(
            cell.machine, scene.model, scene.data, seed=seed, step=lambda advance: scene.step(1, advance)
        )
        driver = SimulatedDriver(VirtualDevice(cell.machine, self._plant, self._clock, running=True))
        load = cell.lift.body + cell.lift.mass + cell.heaviest_fruit
        self.arm = CellArm(cell.machine, driver, self._clock, load=load, tip_speed=cell.limits.speed)
        self._top, self._each_cycle = cell.lift.clearance, each_cycle

    @property
    def time(self) -> float:
        """Time since the start, s."""
        return self._clock.now() / NS_PER_SECOND

    @property
    def air(self) -> float:
        """Air consumption of joints, lift and cup so far, normal litres."""
        joints = sum(ledger.air_taken for ledger in self._plant.ledgers) / NORMAL_DENSITY
        return LITRES_PER_CUBIC_METRE * (joints + self._scene.lift.air + self._scene.cup.air)

    def measure(self, relocation: Relocation | None = None) -> CellReadings:
        """Return the sensor readings of the present cycle; nothing moves, and no image is taken.

        Args:
            relocation: result of the image that the last command requested, to be among the readings; None without one.
        """
        arm, scene = self.arm, self._scene
        lip, speed = self._top - scene.stroke, -scene.stroke_speed
        return CellReadings(self.time, arm.angles, arm.velocities, scene.cup.vacuum, lip, speed, relocation)

    def advance(self, command: PickCommand, course: MovingTarget | None = None) -> None:
        """Run one control cycle with a command in force, then call `each_cycle`.

        Args:
            command: target of the arm, height of the lift and suction.
            course: motion of a fruit that the arm follows in place of the command's target; None: it moves to that.

        Raises:
            RigStoppedError: as from `CellArm.advance`.
            DivergedError: the simulation diverged.
        """
        if course is None:
            self.arm.go(command.target)
        else:
            self.arm.follow(course)
        self._scene.lift.demand = self._top - command.height
        self._scene.cup.on = command.suction
        self.arm.advance()
        self._each_cycle()
