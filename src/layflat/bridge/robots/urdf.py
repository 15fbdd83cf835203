"""Robots from URDF, read by its own rules, so that whatever is wrong has a name."""

from collections.abc import Iterable
from math import isfinite
from pathlib import Path
from typing import NoReturn
from xml.etree.ElementTree import Element

import numpy as np

from layflat.arrays import Array
from layflat.bridge.pieces import BODY
from layflat.bridge.robots.robot import FIXED, HINGE, SLIDE, Body, Inertial, Link, Look, Mimic, Pose, Robot, at
from layflat.description.hints import did_you_mean
from layflat.errors import InputError
from layflat.physics.arms.bodies import about, moments, turn_of, turned_by

KINDS = {"revolute": HINGE, "continuous": HINGE, "fixed": FIXED, "prismatic": SLIDE}
OTHERS = ("floating", "planar")
TURN = 7.0  # angle from which on it is said that one is in radians, rad: just over a full turn
SIX = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


def read_urdf(file: Path, root: Element, *, meshes: bool = True) -> Robot:
    """Return the robot of a URDF.

    Args:
        file: where it was read.
        root: its tree.
        meshes: whether to look for the meshes that it is drawn by.

    Raises:
        InputError: naming the link or joint, and what would be right.
    """
    return _Reader(file, meshes=meshes).robot(root)


class _Reader:
    def __init__(self, file: Path, *, meshes: bool) -> None:
        self.file, self.meshes = file, meshes
        self.notes: list[str] = []

    def robot(self, root: Element) -> Robot:
        bodies: dict[str, Body] = {}
        for element in root.findall("link"):
            body = self._body(element)
            if body.name in bodies:
                self._refuse(f"link {body.name!r}", "stands there twice", "give each link a name of its own")
            bodies[body.name] = body
        if not bodies:
            self._refuse("", "has no links", "give a URDF with links and joints")
        links = [self._link(element, bodies) for element in root.findall("joint")]
        doubled = [link.name for i, link in enumerate(links) if link.name in {other.name for other in links[:i]}]
        if doubled:
            self._refuse(f"joint {doubled[0]!r}", "stands there twice", "give each joint a name of its own")
        base, name = self._base(bodies, links), root.get("name") or self.file.stem
        compiler = root.find("mujoco/compiler")
        folder = "" if compiler is None else compiler.get("meshdir") or ""
        gravity, left_out = self._gravity(root), self._left_out(root)
        return Robot(
            self.file,
            name,
            "link",
            base,
            bodies,
            links,
            {},
            gravity,
            [],
            left_out,
            notes=self.notes,
            mesh_folder=folder,
        )

    def _gravity(self, root: Element) -> Array | None:
        """Return the gravity of an element that MuJoCo reads, m/s2; without it the file has none."""
        option = root.find("mujoco/option[@gravity]")
        return None if option is None else np.array(self._numbers(option, "gravity", 3, "mujoco/option", None))

    def _left_out(self, root: Element) -> list[str]:
        joints = root.findall("joint/dynamics")
        elements = {
            "transmissions": root.find("transmission") is not None,
            "elements for Gazebo": root.find("gazebo") is not None,
            "for ros2_control": root.find("ros2_control") is not None,
        }
        rub = [key for key in ("damping", "friction") if any(_is_some(joint.get(key)) for joint in joints)]
        left_out = [text for text, is_there in elements.items() if is_there]
        if rub:
            left_out.append(f"{' and '.join(rub)} of joints")
        if root.find("link/collision") is not None:
            left_out.insert(0, "collision geometry")
        return left_out

    def _base(self, bodies: dict[str, Body], links: list[Link]) -> str:
        over: dict[str, Link] = {}
        for link in links:
            other = over.setdefault(link.child, link)
            if other is not link:
                self._refuse(
                    f"link {link.child!r}",
                    f"hangs on two joints, {other.name!r} and {link.name!r}: a closed chain",
                    "an arm here is an open chain; take one of both joints away",
                )
        free = [name for name in bodies if name not in over]
        if not free:
            self._refuse("", "has no base: its joints go round in a circle", "take the joint away that closes the loop")
        if len(free) > 1:
            self._refuse("", f"has several bases: {', '.join(free)}", "join them by fixed joints, or take others away")
        reached = set(free)
        for _ in links:
            reached |= {link.child for link in links if link.parent in reached}
        cut = [name for name in bodies if name not in reached and name not in free]
        if cut:
            self._refuse(f"link {cut[0]!r}", "hangs on itself: a closed chain", "an arm here is an open chain")
        return free[0]

    def _body(self, element: Element) -> Body:
        name = element.get("name") or ""
        where = f"link {name!r}"
        if not name:
            self._refuse("link", "has no name", 'give it one: <link name="upper_arm">')
        inertial, drawn = element.find("inertial"), element.findall("visual")
        looks = [self._look(one, name) for one in drawn if not (one.get("name") or "").endswith(BODY)]
        solid = bool(drawn) or element.find("collision") is not None
        return Body(
            name,
            None if inertial is None else self._inertial(inertial, where),
            [look for look in looks if look is not None],
            solid,
        )

    def _inertial(self, element: Element, where: str) -> Inertial:
        mass, inertia = element.find("mass"), element.find("inertia")
        if mass is None or inertia is None:
            lacking = "mass" if mass is None else "inertia"
            self._refuse(where, f"has an inertial without {lacking}", f"give <{lacking}> in it")
        (kilograms,) = self._numbers(mass, "value", 1, f"{where}: mass", None)
        six = [self._numbers(inertia, key, 1, f"{where}: inertia", (0.0,))[0] for key in SIX]
        pose = self._origin(element, where)
        return Inertial(kilograms, pose.place, pose.axes @ moments(six) @ pose.axes.T)

    def _link(self, element: Element, bodies: Iterable[str]) -> Link:
        name = element.get("name") or ""
        where, kind = f"joint {name!r}", element.get("type") or ""
        if not name:
            self._refuse("joint", "has no name", 'give it one: <joint name="elbow" type="revolute">')
        if kind not in KINDS and kind not in OTHERS:
            right = did_you_mean(kind, [*KINDS, *OTHERS], "types are {}")
            self._refuse(where, f"has the unknown type {kind!r}", right)
        ends = []
        for end in ("parent", "child"):
            named = (element.find(end) if element.find(end) is not None else Element(end)).get("link") or ""  # type: ignore[union-attr]
            if named not in bodies:
                right = did_you_mean(named, bodies, "links are {}")
                self._refuse(where, f"has the {end} {named!r}, which is not there", right)
            ends.append(named)
        axis, dynamics = element.find("axis"), element.find("dynamics")
        moves = KINDS.get(kind) in {HINGE, SLIDE}
        return Link(
            name,
            KINDS.get(kind, kind),
            ends[0],
            ends[1],
            self._origin(element, where),
            np.array(self._numbers(axis, "xyz", 3, f"{where}: axis", None)) if axis is not None and moves else None,
            limits=self._range(element, "limit", ("lower", "upper"), where) if kind in {"revolute", SLIDE} else None,
            soft_limits=self._soft_limits(element, where),
            armature=0.0 if dynamics is None else self._armature(dynamics, where),
            mimic=self._mimic(element, where),
        )

    def _range(self, element: Element, tag: str, keys: tuple[str, str], where: str) -> tuple[float, float] | None:
        limit = element.find(tag)
        if limit is None:
            return None
        lower, upper = (self._numbers(limit, key, 1, f"{where}: {tag}", (0.0,))[0] for key in keys)
        return lower, upper

    def _soft_limits(self, element: Element, where: str) -> tuple[float, float] | None:
        """Return soft limits; without any, or with equal ones, as where they are left out, a joint has none."""
        limits = self._range(element, "safety_controller", ("soft_lower_limit", "soft_upper_limit"), where)
        if limits is not None and limits[0] > limits[1]:
            self._note(where, f"soft limits from {limits[0]:g} to {limits[1]:g}, the wrong way round: left out")
        return limits if limits is not None and limits[0] < limits[1] else None

    def _armature(self, dynamics: Element, where: str) -> float:
        """Return what our own exports have beside what URDF knows."""
        (armature,) = self._numbers(dynamics, "armature", 1, f"{where}: dynamics", (0.0,))
        if armature < 0.0:
            self._refuse(f"{where}: dynamics", f"has the armature {armature:g} kg m2", "give one of 0 or more")
        return armature

    def _mimic(self, element: Element, where: str) -> Mimic | None:
        mimic = element.find("mimic")
        if mimic is None:
            return None
        (multiplier,) = self._numbers(mimic, "multiplier", 1, f"{where}: mimic", (1.0,))
        (offset,) = self._numbers(mimic, "offset", 1, f"{where}: mimic", (0.0,))
        return Mimic(mimic.get("joint") or "another", multiplier, offset)

    def _look(self, element: Element, body: str) -> Look | None:
        where = f"link {body!r}"
        geometry = element.find("geometry")
        shape = None if geometry is None or not len(geometry) else geometry[0]
        if shape is None:
            self._refuse(where, "has a visual without geometry", "give a box, cylinder, sphere or mesh")
        pose, kind = self._origin(element, where), shape.tag
        if kind == "mesh":
            if not self.meshes:
                return None
            scale = self._scale(shape, f"{where}: mesh")
            return Look("mesh", pose, named=self._file_name(shape, where), scale=scale, body=body)
        round_ones = {"sphere": (), "cylinder": ("length",), "capsule": ("length",)}
        place = f"{where}: {kind}"
        if kind == "box":
            size = [*self._numbers(shape, "size", 3, place, None)]
        elif kind in round_ones:
            (radius,) = self._numbers(shape, "radius", 1, place, None)
            size = [2.0 * radius, *(self._numbers(shape, key, 1, place, None)[0] for key in round_ones[kind])]
        else:
            self._refuse(where, f"has the unknown geometry {kind!r}", "give a box, cylinder, sphere or mesh")
        if min(size) < 0.0:
            self._refuse(place, f"has the size {min(size):g} m", "give sizes above 0")
        return Look(kind, pose, tuple(size)) if min(size) > 0.0 else None

    def _file_name(self, shape: Element, where: str) -> str:
        name = (shape.get("filename") or "").strip()
        if not name:
            self._refuse(where, "has a mesh without filename", 'give <mesh filename="meshes/link.stl"/>')
        return name

    def _scale(self, shape: Element, where: str) -> tuple[float, ...]:
        if len((shape.get("scale") or "").split()) == 1:
            return self._numbers(shape, "scale", 1, where, None) * 3
        return self._numbers(shape, "scale", 3, where, (1.0, 1.0, 1.0))

    def _origin(self, element: Element, where: str) -> Pose:
        origin = element.find("origin")
        if origin is None:
            return at((0.0, 0.0, 0.0))
        if origin.get("quat_xyzw") is not None:
            what = "has an orientation as quat_xyzw, which most readers skip without a word"
            self._refuse(f"{where}: origin", what, f'give rpy="{self._rpy(origin, where)}" in its place')
        turn = self._numbers(origin, "rpy", 3, f"{where}: origin", (0.0, 0.0, 0.0))
        place = self._numbers(origin, "xyz", 3, f"{where}: origin", (0.0, 0.0, 0.0))
        if max(map(abs, turn)) > TURN:
            angles = f'rpy="{origin.get("rpy")}"'
            self._note(where, f"{angles} is read in rad, as URDF has it: more than a full turn; are they degrees?")
        return Pose(turned_by(turn), np.array(place))

    def _rpy(self, origin: Element, where: str) -> str:
        """Return the angles that are the same as an orientation in a quaternion."""
        x, y, z, w = self._numbers(origin, "quat_xyzw", 4, f"{where}: origin", None)
        angle, way = 2.0 * np.arctan2(np.hypot(np.hypot(x, y), z), w), np.array([x, y, z])
        axes = about(way / np.linalg.norm(way), angle) if way.any() else np.eye(3)
        return " ".join(f"{value + 0.0:.9g}" for value in turn_of(axes))

    def _numbers(
        self, element: Element, key: str, count: int, where: str, otherwise: tuple[float, ...] | None
    ) -> tuple[float, ...]:
        text = element.get(key)
        if text is None and otherwise is not None:
            return otherwise
        example = " ".join(["0.1", "0", "0.2"][:count])
        try:
            found = tuple(map(float, (text or "").split()))
        except ValueError:
            found = ()
        if len(found) != count or not all(map(isfinite, found)):
            wanted = "a number" if count == 1 else f"{count} numbers"
            self._refuse(where, f"{key} is {text!r}, not {wanted}", f'give {key}="{example}"')
        return found

    def _note(self, where: str, what: str) -> None:
        self.notes.append(f"{where}: {what}")

    def _refuse(self, where: str, what: str, right: str) -> NoReturn:
        raise InputError(what, where=f"{self.file}: {where}" if where else str(self.file), right=right)


def _is_some(text: str | None) -> bool:
    """Return whether an attribute is there and not zero."""
    try:
        return text is not None and float(text) != 0.0
    except ValueError:
        return True
