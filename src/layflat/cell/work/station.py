"""The cell's hardware in simulation: the arm behind a rig's control loop, lift and cup, on one clock."""

from __future__ import annotations

from collections.abc import Callable
from math import pi

from layflat.bridge import MujocoPlant
from layflat.cell.file.model import Cell
from layflat.cell.plan.pick import Command, Measured, Sighting
from layflat.cell.scene import Scene
from layflat.cell.work.arm import Arm
from layflat.cell.work.tool import SceneTool, Tool
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
            load=cell.lift.body + cell.lift.mass + heaviest(cell), tip_speed=cell.limits.speed,
        )  # fmt: skip
        self.tool: Tool = SceneTool(scene)
        self._each_cycle = each_cycle

    @property
    def time(self) -> float:
        """Since it began, s."""
        return self._clock.now() / SECOND

    @property
    def air(self) -> float:
        """Taken by joints, lift and cup so far, normal litres."""
        joints = sum(ledger.air_taken for ledger in self._plant.pneumatics.ledgers) / NORMAL_DENSITY
        return LITRES * (joints + self._scene.lift.air + self._scene.cup.air)

    def measure(self, sighting: Sighting | None = None) -> Measured:
        """What sensors say, and what a picture told."""
        arm, tool = self.arm, self.tool
        return Measured(self.time, arm.angles, arm.velocities, tool.vacuum, tool.height, tool.speed, sighting)

    def turn(self, command: Command) -> None:
        """One control cycle.

        Raises:
            RigStoppedError: the rig's supervisor does not let it move.
            DivergedError: the simulation left all meaning.
        """
        self.arm.go(command.target)
        self.tool.obey(command.height, suction=command.suction)
        self.arm.turn()
        self._each_cycle()


def heaviest(cell: Cell) -> float:
    """Mass of the heaviest fruit that comes in any tray, taken for an ellipsoid, kg."""
    kinds = [cell.produce[kind] for tray in cell.tray.values() for kind in tray.produce]
    return max(pi / 6 * kind.diameter.most**3 * kind.flattening.most * kind.density.most for kind in kinds)
