"""Other tools' views of an arm in a file: mass matrix, torques of gravity, tip, limits and meshes."""

import os
from collections.abc import Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

mujoco: Any = import_module("mujoco")
mujoco.set_mju_user_warning(lambda _: None)  # of textures, which do not count here


@dataclass(frozen=True)
class View:
    """An arm as a tool has it; None where the tool does not know."""

    mass: Array | None = None  # mass matrix, (n, n)
    pull: Array | None = None  # torques of gravity on the joints, N m, (n,)
    tip: Array | None = None  # m, (3,)
    limits: Array | None = None  # rad, (n, 2)
    meshes: int | None = None  # that it has found


def in_mujoco(model: Any, joints: Sequence[str], positions: Array, tip: str = "", held: Any = None) -> View:
    """Return MuJoCo's view of joints by name; others are where the file draws them, or at `held` (name: position)."""
    data = mujoco.MjData(model)
    for name, position in {**dict(zip(joints, positions, strict=True)), **(held or {})}.items():
        data.joint(name).qpos = position
    mujoco.mj_forward(model, data)
    own = [int(model.joint(name).dofadr[0]) for name in joints]
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    place = None
    if tip:
        place = (
            data.site(tip).xpos if mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, tip) >= 0 else data.body(tip).xpos
        )
    limits = np.array([model.joint(name).range for name in joints])
    return View(full[np.ix_(own, own)], -data.qfrc_bias[own], place, limits, int(model.nmesh))


def of_original(file: Path, joints: Sequence[str], positions: Array, gravity: Array) -> tuple[str, View]:
    """Return a tool and its view of a robot's own file: MuJoCo, or Pinocchio where it refuses a body off the arm."""
    try:
        model = original(file)
    except ValueError:
        if file.suffix == ".xml":
            raise
        return "Pinocchio", in_pinocchio(file, joints, positions, gravity)
    model.opt.gravity[:] = gravity
    return "MuJoCo", in_mujoco(model, joints, positions)


def as_it_is(file: Path) -> Any:
    """Return MuJoCo's model of a file with all that is drawn."""
    return mujoco.MjModel.from_xml_path(str(file))


def original(file: Path) -> Any:
    """Return MuJoCo's model of a robot's file; of a URDF without what is drawn, whose meshes MuJoCo may not find."""
    if file.suffix == ".xml":
        return as_it_is(file)
    root = ElementTree.parse(file).getroot()
    for link in root.findall("link"):
        for part in [*link.findall("visual"), *link.findall("collision")]:
            link.remove(part)
    for extra in root.findall("mujoco"):
        root.remove(extra)
    settings = ElementTree.SubElement(root, "mujoco")
    ElementTree.SubElement(settings, "compiler", fusestatic="false")
    return mujoco.MjModel.from_xml_string(ElementTree.tostring(root, encoding="unicode"))


def in_pinocchio(file: Path, joints: Sequence[str], angles: Array, gravity: Array, tip: str = "") -> View:
    """Return Pinocchio's view of a URDF; joints that are not named are at zero."""
    pinocchio: Any = import_module("pinocchio")

    model = pinocchio.buildModelFromUrdf(str(file))
    data = model.createData()
    model.gravity.linear = gravity
    order = [model.joints[model.getJointId(name)].idx_v for name in joints]
    moved = np.zeros(model.nv)
    moved[order] = angles
    positions = pinocchio.integrate(model, pinocchio.neutral(model), moved)  # a joint without limits has two numbers
    mass = np.triu(pinocchio.crba(model, data, positions))
    mass = mass + mass.T - np.diag(mass.diagonal())
    pull = -pinocchio.computeGeneralizedGravity(model, data, positions)
    pinocchio.framesForwardKinematics(model, data, positions)
    if not tip:
        return View(mass[np.ix_(order, order)], pull[order])
    place = data.oMf[model.getFrameId(tip)].translation
    limits = np.column_stack([model.lowerPositionLimit[order], model.upperPositionLimit[order]])
    return View(mass[np.ix_(order, order)], pull[order], place, limits)


def in_pybullet(file: Path, joints: Sequence[str], angles: Array, gravity: Array) -> View:
    """Return PyBullet's view of an exported URDF."""
    pybullet: Any = import_module("pybullet")

    with _quiet():
        client = pybullet.connect(pybullet.DIRECT)
        try:
            pybullet.setGravity(*gravity.tolist())
            body = pybullet.loadURDF(str(file), useFixedBase=True, flags=pybullet.URDF_USE_INERTIA_FROM_FILE)
            infos = [pybullet.getJointInfo(body, i) for i in range(pybullet.getNumJoints(body))]
            numbers = {info[1].decode(): info[0] for info in infos}
            links = {info[12].decode(): info[0] for info in infos}
            own = [numbers[name] for name in joints]
            for i, angle in zip(own, angles.tolist(), strict=True):
                pybullet.resetJointState(body, i, angle)
            moving = [info[0] for info in infos if info[2] != pybullet.JOINT_FIXED]
            order = [moving.index(i) for i in own]
            at = [pybullet.getJointState(body, i)[0] for i in moving]
            mass = np.array(pybullet.calculateMassMatrix(body, at))
            rest = [0.0] * len(at)
            pull = -np.array(pybullet.calculateInverseDynamics(body, at, rest, rest))
            tip = np.array(pybullet.getLinkState(body, links["tool"], computeForwardKinematics=True)[4])
            limits = np.array([infos[i][8:10] for i in own])
            shapes = [shape for shape in pybullet.getVisualShapeData(body) if shape[2] == pybullet.GEOM_MESH]
        finally:
            pybullet.disconnect(client)
    return View(mass[np.ix_(order, order)], pull[order], tip, limits, len(shapes))


def in_yourdfpy(file: Path, joints: Sequence[str], angles: Array) -> View:
    """Return yourdfpy's view of an exported URDF."""
    yourdfpy: Any = import_module("yourdfpy")

    robot = yourdfpy.URDF.load(str(file), load_meshes=True, build_scene_graph=True)
    robot.update_cfg(dict(zip(joints, angles.tolist(), strict=True)))
    tip = robot.get_transform("tool", robot.base_link)[:3, 3]
    limits = np.array([[robot.joint_map[name].limit.lower, robot.joint_map[name].limit.upper] for name in joints])
    named = [
        visual.geometry.mesh.filename
        for link in robot.robot.links
        for visual in link.visuals
        if visual.geometry is not None and visual.geometry.mesh is not None
    ]
    missing = [name for name in named if not (file.parent / name).is_file()]
    return View(None, None, tip, limits, len(named) - len(missing))


@contextmanager
def _quiet() -> Any:
    """Hush what C code writes to stdout."""
    saved, sink = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(sink, 1)
    try:
        yield
    finally:
        os.dup2(saved, 1)
        os.close(saved)
        os.close(sink)
