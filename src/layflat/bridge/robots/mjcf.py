"""Robots from MJCF, read by MuJoCo: its defaults, its geoms' masses, its ways to say an orientation."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.bridge.arm import engine
from layflat.bridge.pieces import BODY
from layflat.bridge.robots.mesh_files import mesh_look
from layflat.bridge.robots.mjcf_spec import compile_mjcf
from layflat.bridge.robots.robot import FIXED, HINGE, SLIDE, Body, Inertial, Link, Look, Pose, Robot
from layflat.errors import InputError

WORLD = "world"
UNNAMED = "MuJoCo Model"  # name of a model whose file gives it none
DRAWN = 3  # groups of geoms below this one are shown by MuJoCo's viewer


def read_mjcf(file: Path, text: str = "", *, meshes: bool = True) -> Robot:
    """Return the robot of an MJCF.

    Args:
        file: the file, beside which MuJoCo finds what it names.
        text: what stands in it, where MuJoCo can't read its encoding.
        meshes: whether to take meshes along for drawing.

    Raises:
        InputError: MuJoCo refuses the file, or it is not installed.
    """
    mj = engine("view")
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
            raise InputError("has numbers that are infinite or none", where=str(file), right="mend its numbers")
    try:
        robot = _Model(mj, spec, model, file, meshes=meshes).robot()
    except UnicodeDecodeError:
        what, right = "has names that are not UTF-8", "save it, and what it includes, as UTF-8"
        raise InputError(what, where=str(file), right=right) from None
    robot.notes += notes
    return robot


class _Model:
    def __init__(self, mj: Any, spec: Any, model: Any, file: Path, *, meshes: bool) -> None:
        self.mj, self.spec, self.model, self.file, self.meshes = mj, spec, model, file, meshes
        self.names = [WORLD, *(model.body(i).name or f"body {i}" for i in range(1, model.nbody))]

    def robot(self) -> Robot:
        model = self.model
        bodies = {name: Body(name) for name in self.names}
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
            "" if self.spec.modelname == UNNAMED else self.spec.modelname,
            "body",
            WORLD,
            bodies,
            links,
            frames,
            self._gravity(),
            self._loops(),
            self._left_out(),
        )

    def _gravity(self) -> Array:
        """Return gravity, m/s2, which an option may name and a flag switch off."""
        gravity: Array = self.model.opt.gravity.copy()
        disabled = self.model.opt.disableflags & self.mj.mjtDisableBit.mjDSBL_GRAVITY
        return np.zeros(3) if disabled else gravity

    def _axes(self, quaternion: Array) -> Array:
        axes = np.zeros(9)
        self.mj.mju_quat2Mat(axes, np.array(quaternion, float))
        return axes.reshape(3, 3)

    def _inertial(self, i: int) -> Inertial:
        model, axes = self.model, self._axes(self.model.body_iquat[i])
        inertia = axes @ np.diag(model.body_inertia[i]) @ axes.T
        return Inertial(float(model.body_mass[i]), model.body_ipos[i].copy(), inertia)

    def _link(self, i: int) -> Link:
        model, name, parent = self.model, self.names[i], self.names[self.model.body_parentid[i]]
        pose = Pose(self._axes(model.body_quat[i]), model.body_pos[i].copy())
        count, j = int(model.body_jntnum[i]), int(model.body_jntadr[i])
        if count == 0:
            return Link(name, FIXED, parent, name, pose)
        kind = self.mj.mjtJoint(int(model.jnt_type[j])).name.removeprefix("mjJNT_").lower()
        called = model.joint(j).name or f"{name}-joint"
        if count > 1:
            return Link(called, f"one of {count} joints of the body {name!r}", parent, name, pose)
        if kind not in {HINGE, "slide"}:
            return Link(called, {"free": "floating"}.get(kind, kind), parent, name, pose)
        limits = (float(model.jnt_range[j][0]), float(model.jnt_range[j][1])) if model.jnt_limited[j] else None
        return Link(
            called,
            HINGE if kind == HINGE else SLIDE,
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
        """Return the working stroke, which our own exports have, about the middle of a joint's limits."""
        strokes = [float(one.data[0]) for one in self.spec.numerics if one.name == f"{joint}.working_stroke"]
        if not strokes or limits is None:
            return None
        middle = 0.5 * (limits[0] + limits[1])
        return middle - 0.5 * strokes[0], middle + 0.5 * strokes[0]

    def _looks(self, i: int) -> list[Look]:
        """Return what a body is drawn by: geoms that touch nothing, if it has such, or all that are shown."""
        model = self.model
        own = np.arange(model.body_geomadr[i], model.body_geomadr[i] + model.body_geomnum[i])
        shown = [int(k) for k in own if model.geom_group[k] < DRAWN]
        only = [k for k in shown if not model.geom_contype[k] and not model.geom_conaffinity[k]]
        looks = [self._look(k) for k in only or shown if not model.geom(k).name.endswith(BODY)]
        return [look for look in looks if look is not None]

    def _look(self, k: int) -> Look | None:
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
            return Look(kind, pose, sizes[kind])
        if kind != "mesh" or not self.meshes:
            return None
        mesh = int(model.geom_dataid[k])
        inner = Pose(self._axes(model.mesh_quat[mesh]), model.mesh_pos[mesh].copy())
        return mesh_look(self.spec, model, self.file, pose, mesh, inner)

    def _loops(self) -> list[tuple[str, set[str]]]:
        """Return the constraints that are active, by name, and the bodies that each ties to each other."""
        model, loops = self.model, []
        for k in np.flatnonzero(model.eq_active0):
            kind = self.mj.mjtEq(int(model.eq_type[k])).name.removeprefix("mjEQ_").lower()
            ids = [i for i in (int(model.eq_obj1id[k]), int(model.eq_obj2id[k])) if i >= 0]
            if kind == "joint":
                tied = self._around(ids)
            elif kind == "tendon":
                tied = self._around([j for i in ids for j in self._joints_of_tendon(i)])
            elif kind in {"connect", "weld"}:
                sites = model.eq_objtype[k] == self.mj.mjtObj.mjOBJ_SITE
                tied = {self.names[model.site_bodyid[i] if sites else i] for i in ids}
            else:
                continue
            loops.append((f"{model.equality(k).name or kind}", tied))
        return loops

    def _around(self, joints: Iterable[int]) -> set[str]:
        """Return the bodies that joints move against each other."""
        bodies = [int(self.model.jnt_bodyid[j]) for j in joints]
        return {self.names[i] for body in bodies for i in (body, int(self.model.body_parentid[body]))}

    def _joints_of_tendon(self, tendon: int) -> list[int]:
        model = self.model
        wraps = range(model.tendon_adr[tendon], model.tendon_adr[tendon] + model.tendon_num[tendon])
        return [int(model.wrap_objid[w]) for w in wraps if model.wrap_type[w] == self.mj.mjtWrap.mjWRAP_JOINT]

    def _left_out(self) -> list[str]:
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
