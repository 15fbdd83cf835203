"""Physical scene of a cell: built from a description and a seed, settled, then stepped."""

from collections.abc import Callable
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.bridge.arm import arm_spec
from layflat.cell.extras import mujoco
from layflat.cell.file.model import Cell
from layflat.cell.scene.belt import BeltDrive, add_belt
from layflat.cell.scene.furniture import add_furniture
from layflat.cell.scene.grip import Grip, LiftDrive
from layflat.cell.scene.movables import add_fruit, add_shapes, add_tool
from layflat.cell.scene.produce import SHELF_GRID, SHELF_HEIGHT, SceneFruit, add_clutter, draw_fruit
from layflat.cell.scene.truth import SceneTruth, TruthRecorder
from layflat.errors import CellError
from layflat.machine import changed

SETTLED_SPEED = 2e-3  # upper limit of all fruit's speed in a settled scene, m/s
MAX_SETTLING_TIME = 4.0  # of fruit, s
ROCKING_TIME = 0.1  # time constant of a fruit's rocking, by damping of soft skin and flesh, s
MAX_ATTEMPTS = 10  # scenes drawn until all fruit stays in its tray


class Scene:
    """Packing cell in MuJoCo, with fruit, lights and noise drawn by a seed.

    Same cell and seed, same scene; the timestep is `step`, s. Raise CellError if there is no room for the fruit, or it
    does not come to rest in its trays.

    Attributes:
        model: MjModel; its hinges have the names of the machine's joints, without drive, damping or limits.
        data: MjData.
        lift: set `lift.demand`, m of stroke.
        cup: set `cup.on`; `cup.vacuum` is the reading of a vacuum sensor.
        belt: the conveyor's drive; None where there is none.
        board_held: True while the calibration board is before the camera; set False to remove it.
    """

    def __init__(self, cell: Cell, seed: int, *, step: float = 1e-3) -> None:
        """Draw scenes, `MAX_ATTEMPTS` at most, until all fruit has come to rest, and begin with the arm at home."""
        self._mj = mujoco()
        self.cell, self.seed, self.board_held = cell, seed, False
        for attempt in range(MAX_ATTEMPTS):
            rng = np.random.default_rng([seed, attempt])
            self.fruits = draw_fruit(cell, rng)
            self.model = _build_spec(cell, self.fruits, rng, step).compile()
            self.data = self._mj.MjData(self.model)
            if self._settle_fruit():
                break
        else:
            raise CellError("fruit does not stay in its trays", where=cell.origin, right="give higher tray walls")
        self.lift = LiftDrive(cell.lift, step)
        self._grip = Grip(self.model, self.data, cell, self.fruits)
        self._recorder = TruthRecorder(self.model, self.data, cell, self.fruits)
        self.belt = None if cell.conveyor is None else BeltDrive(self.model, self.data, cell.conveyor, self.fruits)
        self.cup = self._grip.cup
        slide = self.model.joint("lift")
        self._slide = int(slide.qposadr[0]), int(slide.dofadr[0])
        self._motor = self.model.actuator("lift").id

    def step(self, count: int = 1, advance: Callable[[Any], None] | None = None) -> None:
        """Advance by a number of timesteps.

        Args:
            count: number of timesteps.
            advance: function of the MjData in place of `mj_step`, such as `PneumaticJoints.step` of the bridge.
        """
        place, speed = self._slide
        for _ in range(count):
            self.data.ctrl[self._motor] = self.lift.force(self.data.qpos[place], self.data.qvel[speed])
            if self.belt is not None and self.belt.advance(self._grip.held):
                self._recorder.restart()
            if advance is None:
                self._mj.mj_step(self.model, self.data)
            else:
                advance(self.data)
            self._grip.update()
            self._recorder.record()

    @property
    def stroke(self) -> float:
        """Stroke of the lift, down from its upper end, m, as a sensor on the cylinder measures it."""
        return float(self.data.qpos[self._slide[0]])

    @property
    def stroke_speed(self) -> float:
        """Speed of the lift, downwards, m/s."""
        return float(self.data.qvel[self._slide[1]])

    def hold_board(self, position: Array, orientation: Array) -> None:
        """Hold the calibration board before the camera: its middle, m, and its quaternion, w first."""
        self.data.mocap_pos[0], self.data.mocap_quat[0] = position, orientation
        self._mj.mj_kinematics(self.model, self.data)
        self.board_held = True

    def truth(self) -> SceneTruth:
        """Return the truth of the scene now, for evaluation only."""
        return self._recorder.truth(self._grip, None if self.belt is None else self.belt.here)

    def _settle_fruit(self) -> bool:
        """Simulate heavily damped fruit until it rests, then restore all else, at time 0 and home.

        Return whether it came to rest in `MAX_SETTLING_TIME`, in its trays or at its positions on the shelf.
        """
        model, data = self.model, self.data
        for name, angle in self.cell.mount.home.items():
            data.qpos[model.joint(name).qposadr[0]] = angle
        rest = data.qpos.copy()
        free = model.jnt_type == self._mj.mjtJoint.mjJNT_FREE
        dofs = np.add.outer(model.jnt_dofadr[free], np.arange(6)).ravel()
        others = np.setdiff1d(np.arange(model.nq), np.add.outer(model.jnt_qposadr[free], np.arange(7)))
        model.dof_damping[dofs] = model.dof_M0[dofs] / ROCKING_TIME
        while data.time < MAX_SETTLING_TIME:
            self._mj.mj_step(model, data, 50)
            fast = np.abs(data.qvel[dofs].reshape(-1, 6)[:, :3]).max(initial=0.0)
            if fast < SETTLED_SPEED and data.time > 0.2:
                break
        else:
            return False
        model.dof_damping[dofs.reshape(-1, 6)[:, :3]] = 0.0
        data.qpos[others] = rest[others]
        data.qvel[:], data.qacc_warmstart[:], data.time = 0.0, 0.0, 0.0
        self._mj.mj_forward(model, data)
        for fruit in self.fruits:
            x, y, z = data.body(fruit.name).xpos
            if fruit.comes is not None:
                if z < SHELF_HEIGHT or not np.allclose(
                    (x, y), fruit.position[:2], atol=SHELF_GRID[1] / 2 - fruit.diameter / 2
                ):
                    return False
                continue
            tray = self.cell.tray_at(float(x), float(y))
            if tray is None or z >= 2 * tray.height + tray.wall:
                return False
        return True


def _build_spec(cell: Cell, fruits: list[SceneFruit], rng: np.random.Generator, step: float) -> Any:
    """Return an MjSpec of the cell with its arm, lift, cup and fruit."""
    mj = mujoco()
    # Lift, cup and fruit move by themselves.
    spec = arm_spec(changed(cell.machine, "arm.payload", cell.lift.body))
    for body in spec.worldbody.bodies:
        body.pos = np.add(body.pos, [0.0, 0.0, cell.mount.height])
        body.sleep = mj.mjtSleepPolicy.mjSLEEP_NEVER
    spec.modelname = cell.name
    spec.option.timestep = step
    spec.option.integrator = mj.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.enableflags |= int(mj.mjtEnableBit.mjENBL_SLEEP)
    spec.stat.extent, spec.stat.center = 1.5, [0.3, 0.3, 0.1]
    spec.visual.map.znear, spec.visual.map.zfar = 0.1, 4.0
    spec.visual.quality.shadowsize, spec.visual.quality.offsamples = 2048, 0
    # Fruit is drawn as a polyhedron within it: with MuJoCo's 28 slices it would be 0.4 % too small.
    spec.visual.quality.numslices, spec.visual.quality.numstacks = 64, 32
    add_furniture(spec, cell, rng)
    if cell.conveyor is not None:
        add_belt(spec, cell.conveyor)
    add_shapes(spec, cell)
    add_tool(spec, cell)
    for fruit in fruits:
        add_fruit(spec, cell, fruit)
    add_clutter(spec, cell, fruits, rng)
    return spec
