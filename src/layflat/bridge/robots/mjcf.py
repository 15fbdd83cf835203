"""Robots from MJCF, read by MuJoCo: its defaults, its geoms' masses, its ways to say an orientation."""

from pathlib import Path
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.bridge.arm import engine, without_warnings
from layflat.bridge.pieces import BODY
from layflat.bridge.robots.robot import FIXED, HINGE, Body, Inertial, Link, Look, Pose, Robot
from layflat.errors import InputError

WORLD = "world"
DRAWN = 3  # groups of geoms below this one are shown by MuJoCo's viewer
RIGHT = {
    "mass and inertia of moving": "give it an inertial, or geoms with mass",
    "A + B >= C": "no principal moment of inertia can be greater than the other two together",
    "axis too small": 'give an axis such as "0 0 1"',
    "opening file": "put the file there",
}
"""What would be right, by a part of what MuJoCo says."""


def read_mjcf(file: Path, *, meshes: bool = True) -> Robot:
    """Return the robot of an MJCF.

    Args:
        file: the file, beside which MuJoCo finds what it names.
        meshes: whether to take meshes along for drawing.

    Raises:
        InputError: MuJoCo refuses the file, or it is not installed.
    """
    mj = engine("view")
    try:
        with without_warnings(mj):
            spec = mj.MjSpec.from_file(str(file))
            model = spec.compile()
    except Exception as error:  # ValueError and others
        said = " ".join(str(error).split()).removeprefix("XML Error: ").removeprefix("Error: ")
        right = next((text for part, text in RIGHT.items() if part in said), "mend the file: MuJoCo must take it")
        raise InputError(said[:1].lower() + said[1:], where=str(file), right=right) from None
    for what in ("body_mass", "body_inertia", "body_ipos", "body_pos", "jnt_pos", "geom_pos", "site_pos"):
        if not np.isfinite(getattr(model, what)).all() or not np.isfinite(model.opt.gravity).all():
            raise InputError("has numbers that are infinite or none", where=str(file), right="mend its numbers")
    return _Model(mj, spec, model, file, meshes=meshes).robot()


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
            self.spec.modelname,
            "body",
            WORLD,
            bodies,
            links,
            frames,
            model.opt.gravity.copy(),
            self._loops(),
            self._left_out(),
        )

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
        if kind != HINGE:
            return Link(called, {"free": "floating", "slide": "prismatic"}.get(kind, kind), parent, name, pose)
        zero = float(model.qpos0[model.jnt_qposadr[j]])
        low, high = model.jnt_range[j] - zero
        works = [one for one in self.spec.numerics if one.name == f"{called}.working_stroke"]
        return Link(
            called,
            HINGE,
            parent,
            name,
            pose,
            model.jnt_axis[j].copy(),
            model.jnt_pos[j].copy(),
            (float(low), float(high)) if model.jnt_limited[j] else None,
            float(works[0].data[0]) if works else None,
            float(model.dof_armature[model.jnt_dofadr[j]]),
        )

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
        return self._mesh(int(model.geom_dataid[k]), pose) if kind == "mesh" and self.meshes else None

    def _mesh(self, m: int, pose: Pose) -> Look:
        """Return a mesh in the frame of its file where it has one that others read; else as MuJoCo has it."""
        model, described = self.model, self.spec.mesh(self.model.mesh(m).name)
        moved = np.any(np.array(described.refpos)) or not np.allclose(described.refquat, (1.0, 0.0, 0.0, 0.0))
        path = self.file.parent / self.spec.meshdir / described.file
        if described.file and not moved and path.is_file() and path.suffix.lower() in {".stl", ".obj"}:
            inner = Pose(self._axes(model.mesh_quat[m]), model.mesh_pos[m].copy())
            return Look("mesh", pose.then(inner.back()), file=path, scale=tuple(map(float, described.scale)))
        corners = model.mesh_vert[model.mesh_vertadr[m] : model.mesh_vertadr[m] + model.mesh_vertnum[m]]
        faces = model.mesh_face[model.mesh_faceadr[m] : model.mesh_faceadr[m] + model.mesh_facenum[m]]
        rows = np.zeros(len(faces), [("numbers", "<f4", (4, 3)), ("more", "<u2")])
        rows["numbers"][:, 1:] = corners[faces]
        content = b"\0" * 80 + len(faces).to_bytes(4, "little") + rows.tobytes()
        name = Path(f"{model.mesh(m).name or f'mesh-{m}'}.stl")
        return Look("mesh", pose, file=name, content=content)

    def _loops(self) -> list[tuple[str, set[str]]]:
        model, found = self.model, []
        for k in range(model.neq):
            kind = self.mj.mjtEq(int(model.eq_type[k])).name.removeprefix("mjEQ_").lower()
            ids = [int(model.eq_obj1id[k]), int(model.eq_obj2id[k])]
            if kind == "joint":
                tied = {self.names[model.jnt_bodyid[i]] for i in ids if i >= 0}
            elif model.eq_objtype[k] == self.mj.mjtObj.mjOBJ_SITE:
                tied = {self.names[model.site_bodyid[i]] for i in ids}
            elif kind in {"connect", "weld"}:
                tied = {self.names[i] for i in ids if i >= 0}
            else:
                continue
            found.append((f"{model.equality(k).name or kind}", tied))
        return found

    def _left_out(self) -> list[str]:
        model = self.model
        touching = bool(np.any(model.geom_contype) or np.any(model.geom_conaffinity))
        counts = {
            "collision geometry": touching,
            "actuators": model.nu,
            "tendons": model.ntendon,
            "springs of joints": np.any(model.jnt_stiffness),
            "damping and friction of joints": np.any(model.dof_damping) or np.any(model.dof_frictionloss),
            "compensation of gravity": np.any(model.body_gravcomp),
        }
        return [text for text, count in counts.items() if count]
