"""The cell's arm behind the rig's control loop: given a target, it goes there within its limits."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from layflat.cell.plan.motion import LEAD, move_arm
from layflat.cell.reach import Angles
from layflat.errors import RigStoppedError
from layflat.machine import Machine
from layflat.rig.clock import Clock
from layflat.rig.driver import Driver
from layflat.rig.law import layout_of
from layflat.rig.loop import Loop, Recorder
from layflat.rig.record import RIG_SIGNALS
from layflat.rig.safety.faults import TABLE
from layflat.rig.safety.states import State
from layflat.rig.safety.supervisor import HostRequest

Array = NDArray[np.float64]

ANGLE, VELOCITY = (list(RIG_SIGNALS).index(name) for name in ("averaged_angle", "averaged_velocity"))


class Arm:
    """An arm on a rig whose air is there; it is the host of the rig's loop.

    Args:
        machine: with controller and gains.
        driver: of its rig, not yet configured.
        clock: that the loop waits by.
        load: greatest that it carries, lift included, kg.
        tip_speed: greatest of the tip, m/s.
        recorder: what keeps the cycles.

    Attributes:
        angles: averaged, rad.
        velocities: averaged, rad/s.
        target: where it is on the way to, rad.
    """

    ended = False

    def __init__(
        self, machine: Machine, driver: Driver, clock: Clock, *,
        load: float, tip_speed: float, recorder: Recorder | None = None,
    ) -> None:  # fmt: skip
        self._machine, self._load, self._tip_speed = machine, load, tip_speed
        self._layout = layout_of(machine)
        driver.configure()
        driver.activate()
        self.loop = Loop(machine, driver, clock, self, recorder)
        first = driver.read()
        self.loop.begin(first)
        self.angles: Angles = tuple(first.angles.tolist())
        self.velocities: Angles = (0.0,) * len(self.angles)
        self.target: Angles = self.angles
        self._demand, self._course, self._at = first.angles.copy(), first.angles[None], 0

    @property
    def cycle(self) -> float:
        """Of its control loop, s."""
        return self.loop.deadlines.cycle

    def go(self, target: Angles) -> None:
        """Move to a posture, rad."""
        if target != self.target:
            path = move_arm(
                self._machine, self._demand, np.array(target), payload=self._load, tip_speed=self._tip_speed
            )
            self._course, self._at, self.target = path.demand(self.cycle, lead=LEAD), 0, target

    def advance(self) -> None:
        """Go through one control cycle.

        Raises:
            RigStoppedError: the rig's supervisor does not let it move.
        """
        self.loop.cycle()
        supervisor = self.loop.supervisor
        if supervisor.state not in {State.READY, State.MOVING}:
            worst = supervisor.ledger.worst
            raise RigStoppedError(f"the rig stopped: {TABLE[worst].title}")

    def request(self, now: int) -> HostRequest:  # noqa: ARG002  (as the rig's hosts)
        """Return the next row of the course that it is on."""
        self._demand = self._course[min(self._at, len(self._course) - 1)]
        self._at += 1
        return HostRequest(self._demand.tolist())

    def publish(self, row: Array) -> None:
        """Read what the controllers know."""
        joints = [row[self._layout.of_joint(j)] for j in range(len(self.angles))]
        self.angles = tuple(float(joint[ANGLE]) for joint in joints)
        self.velocities = tuple(float(joint[VELOCITY]) for joint in joints)
