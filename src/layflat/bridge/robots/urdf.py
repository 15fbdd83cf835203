"""Robots from URDF, read by its own rules, so that whatever is wrong has a name."""

from collections.abc import Iterable
from math import isfinite
from pathlib import Path
from typing import NoReturn
from xml.etree.ElementTree import Element

import numpy as np

from layflat.bridge.pieces import BODY
from layflat.bridge.robots.mesh_files import find_mesh
from layflat.bridge.robots.robot import FIXED, HINGE, Body, Inertial, Link, Look, Pose, Robot, at
from layflat.description.hints import did_you_mean
from layflat.errors import InputError
from layflat.physics.arms.bodies import moments, turned_by

KINDS = {"revolute": HINGE, "continuous": HINGE, "fixed": FIXED}
OTHERS = ("prismatic", "floating", "planar")
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
        base = self._base(bodies, links)
        left_out = {
            "transmission": "transmissions",
            "gazebo": "elements for Gazebo",
            "ros2_control": "for ros2_control",
        }
        found = [text for tag, text in left_out.items() if root.find(tag) is not None]
        if any(element.find("collision") is not None for element in root.findall("link")):
            found.insert(0, "collision geometry")
        name, told = root.get("name") or self.file.stem, root.find("mujoco/option")
        gravity = None if told is None else np.array(self._numbers(told, "gravity", 3, "mujoco/option", None))
        return Robot(self.file, name, "link", base, bodies, links, {}, gravity, left_out=found)

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
        rooted = [name for name in free if any(link.parent == name for link in links)] or free[:1]
        if len(rooted) > 1:
            self._refuse("", f"has several bases: {', '.join(rooted)}", "join them by fixed joints")
        reached = {rooted[0]}
        for _ in links:
            reached |= {link.child for link in links if link.parent in reached}
        cut = [name for name in bodies if name not in reached and name not in free]
        if cut:
            self._refuse(f"link {cut[0]!r}", "hangs on itself: a closed chain", "an arm here is an open chain")
        return rooted[0]

    def _body(self, element: Element) -> Body:
        name = element.get("name") or ""
        where = f"link {name!r}"
        if not name:
            self._refuse("link", "has no name", 'give it one: <link name="upper_arm">')
        inertial, drawn = element.find("inertial"), element.findall("visual")
        looks = [self._look(one, where) for one in drawn if not (one.get("name") or "").endswith(BODY)]
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
        axis, mimic = element.find("axis"), element.find("mimic")
        hinge = KINDS.get(kind) == HINGE
        return Link(
            name,
            KINDS.get(kind, kind),
            ends[0],
            ends[1],
            self._origin(element, where),
            np.array(self._numbers(axis, "xyz", 3, f"{where}: axis", None)) if axis is not None and hinge else None,
            limits=self._limits(element, where) if kind == "revolute" else None,
            works=self._works(element, where),
            mimics="" if mimic is None else mimic.get("joint") or "another",
        )

    def _limits(self, element: Element, where: str) -> tuple[float, float] | None:
        limit = element.find("limit")
        if limit is None:
            return None
        low, high = (self._numbers(limit, key, 1, f"{where}: limit", (0.0,))[0] for key in ("lower", "upper"))
        if low >= high:
            self._refuse(where, f"has limits from {low:g} to {high:g} rad", "give upper more than lower")
        return low, high

    def _works(self, element: Element, where: str) -> float | None:
        soft = element.find("safety_controller")
        keys = ("soft_lower_limit", "soft_upper_limit")
        if soft is None or any(soft.get(key) is None for key in keys):
            return None
        low, high = (self._numbers(soft, key, 1, f"{where}: safety_controller", None)[0] for key in keys)
        return high - low if high > low else None

    def _look(self, element: Element, where: str) -> Look | None:
        geometry = element.find("geometry")
        shape = None if geometry is None or not len(geometry) else geometry[0]
        if shape is None:
            self._refuse(where, "has a visual without geometry", "give a box, cylinder, sphere or mesh")
        pose, kind = self._origin(element, where), shape.tag
        if kind == "mesh":
            if not self.meshes:
                return None
            scale = self._scale(shape, f"{where}: mesh")
            return Look("mesh", pose, file=find_mesh(shape.get("filename") or "", self.file, where), scale=scale)
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

    def _scale(self, shape: Element, where: str) -> tuple[float, ...]:
        if len((shape.get("scale") or "").split()) == 1:
            return self._numbers(shape, "scale", 1, where, None) * 3
        return self._numbers(shape, "scale", 3, where, (1.0, 1.0, 1.0))

    def _origin(self, element: Element, where: str) -> Pose:
        origin = element.find("origin")
        if origin is None:
            return at((0.0, 0.0, 0.0))
        turn = self._numbers(origin, "rpy", 3, f"{where}: origin", (0.0, 0.0, 0.0))
        place = self._numbers(origin, "xyz", 3, f"{where}: origin", (0.0, 0.0, 0.0))
        return Pose(turned_by(turn), np.array(place))

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

    def _refuse(self, where: str, what: str, right: str) -> NoReturn:
        raise InputError(what, where=f"{self.file}: {where}" if where else str(self.file), right=right)
