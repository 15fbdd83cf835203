"""The cell's hardware in simulation: the arm behind a rig's control loop, lift and cup, on one clock."""

from __future__ import annotations

from collections.abc import Callable

from layflat.bridge import MujocoPlant
from layflat.cell.plan.pick import Command, Readings, Relocation
from layflat.cell.scene import Scene
from layflat.cell.work.arm import Arm
from layflat.physics.air import NORMAL_DENSITY
from layflat.rig.clock import SECOND, VirtualClock
from layflat.rig.device.virtual import VirtualDevice
from layflat.rig.drivers.simulated import SimulatedDriver

LITRES = 1000.0
"""In a m3."""


class Station:
    """A scene's arm, lift and cup, as a control loop of 5 ms meets them: what is measured, and what is commanded.

    Args:
        scene: settled.
        seed: of the sensors' noise.
        each_cycle: is called after every control cycle.
    """

    def __init__(self, scene: Scene, seed: int, each_cycle: Callable[[], object] = lambda: None) -> None:
        cell, self._scene, self._clock = scene.cell, scene, VirtualClock()
        self._plant = MujocoPlant(
            cell.machine, scene.model, scene.data, seed=seed, step=lambda advance: scene.step(1, advance)
        )
        device = VirtualDevice(cell.machine, self._plant, self._clock, running=True)
        self.arm = Arm(
            cell.machine, SimulatedDriver(device), self._clock,
            load=cell.lift.body + cell.lift.mass + cell.heaviest_fruit, tip_speed=cell.limits.speed,
        )  # fmt: skip
        self._top = cell.lift.clearance
        self._each_cycle = each_cycle

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
        height = self._top - scene.stroke
        return Readings(
            self.time, arm.angles, arm.velocities, scene.cup.vacuum, height, -scene.stroke_speed, relocation
        )

    def advance(self, command: Command) -> None:
        """Go through one control cycle.

        Raises:
            RigStoppedError: the rig's supervisor does not let it move.
            DivergedError: the simulation diverged.
        """
        self.arm.go(command.target)
        self._scene.lift.demand = self._top - command.height
        self._scene.cup.on = command.suction
        self.arm.advance()
        self._each_cycle()
