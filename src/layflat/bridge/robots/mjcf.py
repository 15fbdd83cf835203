"""Import of robots from MJCF by MuJoCo's own compiler."""

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from layflat.arrays import Array
from layflat.bridge.arm import import_mujoco, without_warnings
from layflat.bridge.mjcf import realizable_inertia
from layflat.bridge.pieces import JOINT_BODY_NAME
from layflat.bridge.robots.mesh_files import mesh_look
from layflat.bridge.robots.robot import (
    FIXED_JOINT,
    HINGE_JOINT,
    SLIDE_JOINT,
    Inertial,
    Pose,
    Robot,
    RobotBody,
    RobotLink,
    VisualShape,
)
from layflat.errors import InputError
from layflat.physics.arms.bodies import inertia_matrix

COMPILE_ADVICE = {
    "mass and inertia of moving": "give it an inertial, or geoms with mass",
    "A + B >= C": "no principal moment of inertia can be greater than the other two together",
    "axis too small": 'give an axis such as "0 0 1"',
    "opening file": "put the file there, or leave meshes out: `meshes=False`",
    "inertia from mesh": "give the body an inertial: without its mesh nobody knows its mass",
}
"""Advice by a part of MuJoCo's error message."""
WORLD_NAME = "world"
DEFAULT_MODEL_NAME = "MuJoCo Model"  # name of a model whose file gives it none
FIRST_HIDDEN_GROUP = 3  # groups of geoms from this one on are hidden by MuJoCo's viewer


def compile_mjcf(mj: Any, file: Path, text: str, *, meshes: bool) -> tuple[Any, Any, list[str]]:
    """Return the specification of a model, the compiled model, and notes on changes that made it compile.

    Args:
        mj: the package `mujoco`.
        file: file of the model, relative to which MuJoCo searches other files.
        text: content of the file, where MuJoCo can't read its encoding; else empty.
        meshes: whether to read meshes. Without, bodies that have an inertial lose them, and others are refused.

    Raises:
        InputError: MuJoCo refuses the file.
    """
    try:
        with without_warnings(mj):
            spec = _read_spec(mj, file, text)
            if not meshes:
                _delete_meshes(spec, file)
            try:
                return spec, spec.compile(), []
            except ValueError as error:
                if "A + B >= C" not in str(error):
                    raise
            notes = list(_round_inertias(spec))
            return spec, spec.compile(), notes
    except InputError:
        raise
    except Exception as error:  # ValueError and others
        message = " ".join(str(error).split()).removeprefix("XML Error: ").removeprefix("Error: ")
        right = next(
            (line for part, line in COMPILE_ADVICE.items() if part in message), "mend the file: MuJoCo must take it"
        )
        _refuse(file, message[:1].lower() + message[1:], right)


def _read_spec(mj: Any, file: Path, text: str) -> Any:
    """Return MuJoCo's specification of a file, or of its decoded `text` if it is not in UTF-8.

    Raise InputError if that text includes other files.
    """
    if not text:
        return mj.MjSpec.from_file(str(file))
    if "<include" in text:
        _refuse(file, "is not in UTF-8, and includes other files", "save it as UTF-8")
    spec = mj.MjSpec.from_string(text)
    spec.modelfiledir = str(file.parent)
    return spec


def _delete_meshes(spec: Any, file: Path) -> None:
    """Delete the meshes of a model; raise InputError if the mass of a body depends on one."""
    for geom in [geom for geom in spec.geoms if geom.meshname]:
        body = geom.parent
        if not body.explicitinertial and body is not spec.worldbody and geom.mass != 0.0 and geom.density != 0.0:
            what = f"body {body.name!r} gets its mass from the mesh {geom.meshname!r}"
            _refuse(file, what, "give it an inertial, or import meshes: `meshes=True`")
        spec.delete(geom)
    for mesh in list(spec.meshes):
        spec.delete(mesh)


def _round_inertias(spec: Any) -> Iterator[str]:
    """Replace inertias that are impossible by rounding by the nearest possible ones; yield a note on each."""
    for body in spec.bodies:
        if not body.explicitinertial:
            continue
        full = np.array(body.fullinertia, float)
        is_full = bool(np.isfinite(full).all())
        inertia = inertia_matrix(full.tolist()) if is_full else np.diag(np.array(body.inertia, float))
        nearest = realizable_inertia(inertia)
        if nearest is None or nearest is inertia:
            continue
        if is_full:
            body.fullinertia = [*nearest.diagonal(), nearest[0, 1], nearest[0, 2], nearest[1, 2]]
        else:
            body.inertia = nearest.diagonal()
        share = np.abs(nearest - inertia).max() / np.abs(inertia).max()
        yield f"inertia of body {body.name!r} is rounded to that of no body: taken {share:.1g} of it smaller"


def _refuse(file: Path, what: str, right: str) -> NoReturn:
    raise InputError(what, where=str(file), right=right)


def read_mjcf(file: Path, text: str = "", *, meshes: bool = True) -> Robot:
    """Return the robot of an MJCF.

    Args:
        file: the file, relative to which MuJoCo searches other files.
        text: content of the file, where MuJoCo can't read its encoding.
        meshes: whether to import meshes for drawing.

    Raises:
        InputError: MuJoCo refuses the file or is not installed, or the file has numbers that are not finite, or names
            that are not UTF-8.
    """
    mj = import_mujoco("view")
    spec, model, notes = compile_mjcf(mj, file, text, meshes=meshes)
    for what in (
        "body_mass",
        "body_inertia",
        "body_ipos",
        "body_pos",
        "jnt_pos",
        "geom_pos",
        "site_pos",
        "qpos0",
        "jnt_range",
    ):
        if not np.isfinite(getattr(model, what)).all() or not np.isfinite(model.opt.gravity).all():
            raise InputError("has numbers that are not finite", where=str(file), right="mend its numbers")
    try:
        robot = _Model(mj, spec, model, file, meshes=meshes).robot()
    except UnicodeDecodeError:
        what, right = "has names that are not UTF-8", "save it, and what it includes, as UTF-8"
        raise InputError(what, where=str(file), right=right) from None
    robot.notes += notes
    return robot


class _Model:
    """Compiled model of an MJCF, read by the indices of its bodies and geoms."""

    def __init__(self, mj: Any, spec: Any, model: Any, file: Path, *, meshes: bool) -> None:
        self.mj, self.spec, self.model, self.file, self.meshes = mj, spec, model, file, meshes
        self.names = [WORLD_NAME, *(model.body(i).name or f"body {i}" for i in range(1, model.nbody))]

    def robot(self) -> Robot:
        """Return the compiled model as a robot: bodies, joints, sites as frames, and the names of omitted elements."""
        model = self.model
        bodies = {name: RobotBody(name) for name in self.names}
        links = []
        for i, name in enumerate(self.names[1:], 1):
            bodies[name].inertial = self._inertial(i)
            bodies[name].solid = bool(model.body_geomnum[i])
            bodies[name].looks = self._looks(i)
            links.append(self._link(i))
        frames = {
            model.site(k).name: (
                self.names[model.site_bodyid[k]],
                Pose(self._axes(model.site_quat[k]), model.site_pos[k].copy()),
            )
            for k in range(model.nsite)
            if model.site(k).name
        }
        return Robot(
            self.file,
            "" if self.spec.modelname == DEFAULT_MODEL_NAME else self.spec.modelname,
            "body",
            WORLD_NAME,
            bodies,
            links,
            frames,
            self._gravity(),
            self._loops(),
            self._omitted_elements(),
        )

    def _gravity(self) -> Array:
        """Return gravity, m/s2, which an option may name and a flag switch off."""
        gravity: Array = self.model.opt.gravity.copy()
        disabled = self.model.opt.disableflags & self.mj.mjtDisableBit.mjDSBL_GRAVITY
        return np.zeros(3) if disabled else gravity

    def _axes(self, quaternion: Array) -> Array:
        """Return the axes (3, 3) of a unit quaternion (w, x, y, z)."""
        axes = np.zeros(9)
        self.mj.mju_quat2Mat(axes, np.array(quaternion, float))
        return axes.reshape(3, 3)

    def _inertial(self, i: int) -> Inertial:
        """Return the inertial of body i, in its frame."""
        model, axes = self.model, self._axes(self.model.body_iquat[i])
        inertia = axes @ np.diag(model.body_inertia[i]) @ axes.T
        return Inertial(float(model.body_mass[i]), model.body_ipos[i].copy(), inertia)

    def _link(self, i: int) -> RobotLink:
        """Return body i's connection to its parent; its kind is fixed, hinge or slide, else words for a refusal."""
        model, name, parent = self.model, self.names[i], self.names[self.model.body_parentid[i]]
        pose = Pose(self._axes(model.body_quat[i]), model.body_pos[i].copy())
        count, j = int(model.body_jntnum[i]), int(model.body_jntadr[i])
        if count == 0:
            return RobotLink(name, FIXED_JOINT, parent, name, pose)
        kind = self.mj.mjtJoint(int(model.jnt_type[j])).name.removeprefix("mjJNT_").lower()
        called = model.joint(j).name or f"{name}-joint"
        if count > 1:
            return RobotLink(called, f"one of {count} joints of the body {name!r}", parent, name, pose)
        if kind not in {HINGE_JOINT, "slide"}:
            return RobotLink(called, {"free": "floating"}.get(kind, kind), parent, name, pose)
        limits = (float(model.jnt_range[j][0]), float(model.jnt_range[j][1])) if model.jnt_limited[j] else None
        return RobotLink(
            called,
            HINGE_JOINT if kind == HINGE_JOINT else SLIDE_JOINT,
            parent,
            name,
            pose,
            model.jnt_axis[j].copy(),
            model.jnt_pos[j].copy(),
            limits,
            self._soft_limits(called, limits),
            float(model.qpos0[model.jnt_qposadr[j]]),
            float(model.dof_armature[model.jnt_dofadr[j]]),
        )

    def _soft_limits(self, joint: str, limits: tuple[float, float] | None) -> tuple[float, float] | None:
        """Return the ends of a joint's working stroke, about the middle of its limits and in their unit.

        None if it has no limits, or the MJCF no numeric "JOINT.working_stroke".
        """
        strokes = [float(one.data[0]) for one in self.spec.numerics if one.name == f"{joint}.working_stroke"]
        if not strokes or limits is None:
            return None
        middle = 0.5 * (limits[0] + limits[1])
        return middle - 0.5 * strokes[0], middle + 0.5 * strokes[0]

    def _looks(self, i: int) -> list[VisualShape]:
        """Return the shapes that a body is drawn by: visible geoms that do not collide, or all visible ones.

        Bodies of joints, by their name, are omitted.
        """
        model = self.model
        geoms = np.arange(model.body_geomadr[i], model.body_geomadr[i] + model.body_geomnum[i])
        shown = [int(k) for k in geoms if model.geom_group[k] < FIRST_HIDDEN_GROUP]
        only = [k for k in shown if not model.geom_contype[k] and not model.geom_conaffinity[k]]
        looks = [self._visual_shape(k) for k in only or shown if not model.geom(k).name.endswith(JOINT_BODY_NAME)]
        return [look for look in looks if look is not None]

    def _visual_shape(self, k: int) -> VisualShape | None:
        """Return geometry k as a shape (m), or None if its type is not drawn or meshes are left out."""
        model, a, b, c = self.model, *(float(value) for value in self.model.geom_size[k])
        kind = self.mj.mjtGeom(int(model.geom_type[k])).name.removeprefix("mjGEOM_").lower()
        pose = Pose(self._axes(model.geom_quat[k]), model.geom_pos[k].copy())
        sizes = {
            "sphere": (2 * a,),
            "capsule": (2 * a, 2 * b),
            "cylinder": (2 * a, 2 * b),
            "box": (2 * a, 2 * b, 2 * c),
        }
        if kind in sizes:
            return VisualShape(kind, pose, sizes[kind])
        if kind != "mesh" or not self.meshes:
            return None
        mesh = int(model.geom_dataid[k])
        inner = Pose(self._axes(model.mesh_quat[mesh]), model.mesh_pos[mesh].copy())
        return mesh_look(self.spec, model, self.file, pose, mesh, inner)

    def _loops(self) -> list[tuple[str, set[str]]]:
        """Return the active equality constraints of joints, tendons and bodies: names, and the bodies they tie."""
        model, loops = self.model, []
        for k in np.flatnonzero(model.eq_active0):
            kind = self.mj.mjtEq(int(model.eq_type[k])).name.removeprefix("mjEQ_").lower()
            ids = [i for i in (int(model.eq_obj1id[k]), int(model.eq_obj2id[k])) if i >= 0]
            if kind == "joint":
                tied = self._bodies_moved_by(ids)
            elif kind == "tendon":
                tied = self._bodies_moved_by([j for i in ids for j in self._joints_of_tendon(i)])
            elif kind in {"connect", "weld"}:
                sites = model.eq_objtype[k] == self.mj.mjtObj.mjOBJ_SITE
                tied = {self.names[model.site_bodyid[i] if sites else i] for i in ids}
            else:
                continue
            loops.append((f"{model.equality(k).name or kind}", tied))
        return loops

    def _bodies_moved_by(self, joints: Iterable[int]) -> set[str]:
        """Return the bodies that joints move against each other."""
        bodies = [int(self.model.jnt_bodyid[j]) for j in joints]
        return {self.names[i] for body in bodies for i in (body, int(self.model.body_parentid[body]))}

    def _joints_of_tendon(self, tendon: int) -> list[int]:
        """Return the indices of the joints that a tendon couples."""
        model = self.model
        wraps = range(model.tendon_adr[tendon], model.tendon_adr[tendon] + model.tendon_num[tendon])
        return [int(model.wrap_objid[w]) for w in wraps if model.wrap_type[w] == self.mj.mjtWrap.mjWRAP_JOINT]

    def _omitted_elements(self) -> list[str]:
        """Return, in words, the sorts of elements of the model that a description of an arm can't hold."""
        model = self.model
        touching = bool(np.any(model.geom_contype) or np.any(model.geom_conaffinity))
        counts = {
            "collision geometry": touching,
            "actuators": model.nu,
            "tendons": model.ntendon,
            "armature of tendons": np.any(model.tendon_armature),
            "springs of joints": np.any(model.jnt_stiffness),
            "damping and friction of joints": np.any(model.dof_damping) or np.any(model.dof_frictionloss),
            "compensation of gravity": np.any(model.body_gravcomp),
        }
        return [text for text, count in counts.items() if count]
