"""Random arms with all that URDF and MJCF allow: mass matrix, gravity, tip and limits are those that MuJoCo has."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from layflat.bridge import save_arm
from layflat.bridge.robots import ChainEnds, ImportedArm, import_arm
from layflat.machine import Machine, parameters
from layflat.physics.arms import ARM_KINDS
from tests.bridge.random_robots import RandomRobot, random_mjcf, random_urdf

mujoco: Any = pytest.importorskip("mujoco")

GRAVITY = (0.3, -1.0, -9.0)


def of_ours(machine: Machine, angles: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    mass, pull = parameters.mass_and_pull(parameters.arm(machine), machine.arm.payload, angles.tolist())
    bodies: Any = ARM_KINDS.named(machine.arm.kind).bodies
    return [mass, pull, bodies(machine.arm, list(machine.joints.values())).poses(angles)[-1][1]]


def of_mujoco(model: Any, robot: RandomRobot, positions: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """Mass matrix, torques of gravity and tip, where the robot's joints have these positions."""
    data = mujoco.MjData(model)
    for name, position in zip(robot.joints, positions, strict=True):
        data.joint(name).qpos = position
    for name in ("left-slide", "right-slide"):
        if robot.file.suffix == ".urdf" and mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, name) >= 0:
            data.joint(name).qpos = {"left-slide": 0.0, "right-slide": 0.02}[name]
    mujoco.mj_forward(model, data)
    full, own = np.zeros((model.nv, model.nv)), [int(model.joint(name).dofadr[0]) for name in robot.joints]
    mujoco.mj_fullM(model, data, full)
    tip = data.site(robot.tool).xpos if robot.file.suffix == ".xml" else data.body(robot.tool).xpos
    return [full[np.ix_(own, own)], -data.qfrc_bias[own], tip]


def imported(robot: RandomRobot) -> ImportedArm:
    gravity = GRAVITY if robot.file.suffix == ".urdf" else None
    return import_arm(robot.file, ends=ChainEnds(to=robot.to, tool=robot.tool), gravity=gravity)


def assert_close(ours: list[NDArray[np.float64]], theirs: list[NDArray[np.float64]], within: float = 1e-9) -> None:
    for a, b in zip(ours, theirs, strict=True):
        assert np.abs(a - b).max() <= within * max(np.abs(b).max(), 1e-3)


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("write", [random_urdf, random_mjcf])
def test_it_is_the_arm_that_mujoco_has(write: Callable[[Path, int], RandomRobot], seed: int, tmp_path: Path) -> None:
    robot = write(tmp_path, seed)
    arm = imported(robot)
    model = mujoco.MjModel.from_xml_path(str(robot.file))
    if robot.file.suffix == ".urdf":
        model.opt.gravity[:] = GRAVITY
    rng = np.random.default_rng(seed)
    middles = np.array([turn.middle for turn in arm.turning])
    for _ in range(3):
        angles = rng.uniform(-1.0, 1.0, len(robot.joints))
        theirs = of_mujoco(model, robot, middles + angles)
        assert_close(of_ours(arm.machine, angles), theirs)
    for turn, limits, soft in zip(arm.turning, robot.limits, robot.soft, strict=True):
        assert turn.limits == pytest.approx(limits, abs=1e-12)
        works = limits if soft is None else soft
        assert turn.middle == pytest.approx(0.5 * sum(works), abs=1e-12)
        assert turn.middle - 0.5 * turn.works >= works[0] - 1e-9
        assert turn.middle + 0.5 * turn.works <= works[1] + 1e-9
        assert turn.middle - 0.5 * turn.mechanical >= limits[0] - 1e-9
        assert turn.middle + 0.5 * turn.mechanical <= limits[1] + 1e-9


@pytest.mark.parametrize("suffix", [".xml", ".urdf"])
@pytest.mark.parametrize("seed", range(6))
def test_what_is_exported_is_still_the_arm_that_mujoco_had(seed: int, suffix: str, tmp_path: Path) -> None:
    robot = random_mjcf(tmp_path, seed)
    arm = imported(robot)
    save_arm(arm.machine, tmp_path / f"out{suffix}")
    before = mujoco.MjModel.from_xml_path(str(robot.file))
    after = mujoco.MjModel.from_xml_path(str(tmp_path / f"out{suffix}"))
    angles = np.random.default_rng(seed).uniform(-0.5, 0.5, len(robot.joints))
    theirs = of_mujoco(before, robot, np.array([turn.middle for turn in arm.turning]) + angles)
    data, full = mujoco.MjData(after), np.zeros((after.nv, after.nv))
    data.qpos[:] = angles
    mujoco.mj_forward(after, data)
    mujoco.mj_fullM(after, data, full)
    if suffix == ".urdf":
        full += np.diag([stage.joint.armature for stage in arm.chain.stages])
    assert_close([full, -data.qfrc_bias], theirs[:2])
