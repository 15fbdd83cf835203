"""Import of robots from URDF, whose errors name the link or joint."""

from collections.abc import Iterable
from math import isfinite
from pathlib import Path
from typing import NoReturn
from xml.etree.ElementTree import Element

import numpy as np

from layflat.arrays import Array
from layflat.bridge.pieces import JOINT_BODY_NAME
from layflat.bridge.robots.robot import (
    FIXED_JOINT,
    HINGE_JOINT,
    SLIDE_JOINT,
    Inertial,
    Mimic,
    Pose,
    Robot,
    RobotBody,
    RobotLink,
    VisualShape,
    translation_pose,
)
from layflat.description.wrong import did_you_mean
from layflat.errors import InputError
from layflat.physics.arms.bodies import angles_from_rotation, inertia_matrix, rotation_about_axis, rotation_from_angles

KINDS = {"revolute": HINGE_JOINT, "continuous": HINGE_JOINT, "fixed": FIXED_JOINT, "prismatic": SLIDE_JOINT}
UNSUPPORTED_TYPES = ("floating", "planar")
MAX_RADIANS = 7.0  # rad, just over a full turn: larger angles get a note, since they may be in degrees
INERTIA_KEYS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


def read_urdf(file: Path, root: Element, *, meshes: bool = True) -> Robot:
    """Return the robot of a URDF.

    Args:
        file: file of the URDF.
        root: its XML tree.
        meshes: whether to import meshes for drawing.

    Raises:
        InputError: the URDF is wrong; the message names the link or joint.
    """
    return _Reader(file, meshes=meshes).robot(root)


class _Reader:
    """Reader of one URDF, with notes on doubtful values."""

    def __init__(self, file: Path, *, meshes: bool) -> None:
        self.file, self.meshes = file, meshes
        self.notes: list[str] = []

    def robot(self, root: Element) -> Robot:
        """Return the robot of a URDF; raise InputError if names occur twice or its joints are not a tree."""
        bodies: dict[str, RobotBody] = {}
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
        gravity, left_out = self._gravity(root), self._omitted_elements(root)
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

    def _omitted_elements(self, root: Element) -> list[str]:
        """Return, in words, the sorts of elements of the file that a description of an arm can't hold."""
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

    def _base(self, bodies: dict[str, RobotBody], links: list[RobotLink]) -> str:
        """Return the only link without a joint above it; raise InputError for closed chains and several bases."""
        over: dict[str, RobotLink] = {}
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

    def _body(self, element: Element) -> RobotBody:
        """Return a link as a body, with inertial and visual shapes; visuals of our own joint bodies are left out."""
        name = element.get("name") or ""
        where = f"link {name!r}"
        if not name:
            self._refuse("link", "has no name", 'give it one: <link name="upper_arm">')
        inertial, drawn = element.find("inertial"), element.findall("visual")
        looks = [
            self._visual_shape(one, name) for one in drawn if not (one.get("name") or "").endswith(JOINT_BODY_NAME)
        ]
        solid = bool(drawn) or element.find("collision") is not None
        return RobotBody(
            name,
            None if inertial is None else self._inertial(inertial, where),
            [look for look in looks if look is not None],
            solid,
        )

    def _inertial(self, element: Element, where: str) -> Inertial:
        """Return the inertial of a link, in the link's frame (kg, m, kg m2); refuse one without mass or inertia."""
        mass, inertia = element.find("mass"), element.find("inertia")
        if mass is None or inertia is None:
            lacking = "mass" if mass is None else "inertia"
            self._refuse(where, f"has an inertial without {lacking}", f"give <{lacking}> in it")
        (kilograms,) = self._numbers(mass, "value", 1, f"{where}: mass", None)
        six = [self._numbers(inertia, key, 1, f"{where}: inertia", (0.0,))[0] for key in INERTIA_KEYS]
        pose = self._origin(element, where)
        return Inertial(kilograms, pose.position, pose.axes @ inertia_matrix(six) @ pose.axes.T)

    def _link(self, element: Element, bodies: Iterable[str]) -> RobotLink:
        """Return a joint as the connection of two links; unknown types are refused, floating and planar kept."""
        name = element.get("name") or ""
        where, kind = f"joint {name!r}", element.get("type") or ""
        if not name:
            self._refuse("joint", "has no name", 'give it one: <joint name="elbow" type="revolute">')
        if kind not in KINDS and kind not in UNSUPPORTED_TYPES:
            right = did_you_mean(kind, [*KINDS, *UNSUPPORTED_TYPES], "types are {}")
            self._refuse(where, f"has the unknown type {kind!r}", right)
        ends = []
        for end in ("parent", "child"):
            named = (element.find(end) if element.find(end) is not None else Element(end)).get("link") or ""  # type: ignore[union-attr]
            if named not in bodies:
                right = did_you_mean(named, bodies, "links are {}")
                self._refuse(where, f"has the {end} {named!r}, which is not there", right)
            ends.append(named)
        axis, dynamics = element.find("axis"), element.find("dynamics")
        moves = KINDS.get(kind) in {HINGE_JOINT, SLIDE_JOINT}
        return RobotLink(
            name,
            KINDS.get(kind, kind),
            ends[0],
            ends[1],
            self._origin(element, where),
            np.array(self._numbers(axis, "xyz", 3, f"{where}: axis", None)) if axis is not None and moves else None,
            limits=self._limits(element, "limit", ("lower", "upper"), where)
            if kind in {"revolute", SLIDE_JOINT}
            else None,
            soft_limits=self._soft_limits(element, where),
            armature=0.0 if dynamics is None else self._armature(dynamics, where),
            mimic=self._mimic(element, where),
        )

    def _limits(self, element: Element, tag: str, keys: tuple[str, str], where: str) -> tuple[float, float] | None:
        """Return lower and upper of an element below a joint, rad or m, 0 where missing; None without the element."""
        limit = element.find(tag)
        if limit is None:
            return None
        lower, upper = (self._numbers(limit, key, 1, f"{where}: {tag}", (0.0,))[0] for key in keys)
        return lower, upper

    def _soft_limits(self, element: Element, where: str) -> tuple[float, float] | None:
        """Return soft limits, rad or m; None without any, or where they are equal or, with a note, reversed."""
        limits = self._limits(element, "safety_controller", ("soft_lower_limit", "soft_upper_limit"), where)
        if limits is not None and limits[0] > limits[1]:
            self._note(where, f"soft limits from {limits[0]:g} to {limits[1]:g}, the wrong way round: left out")
        return limits if limits is not None and limits[0] < limits[1] else None

    def _armature(self, dynamics: Element, where: str) -> float:
        """Return the armature, an attribute of layflat's exports that URDF lacks, kg m2; refuse one below 0."""
        (armature,) = self._numbers(dynamics, "armature", 1, f"{where}: dynamics", (0.0,))
        if armature < 0.0:
            self._refuse(f"{where}: dynamics", f"has the armature {armature:g} kg m2", "give one of 0 or more")
        return armature

    def _mimic(self, element: Element, where: str) -> Mimic | None:
        """Return the joint that a joint follows, with multiplier and offset (rad or m); None if it moves by itself."""
        mimic = element.find("mimic")
        if mimic is None:
            return None
        (multiplier,) = self._numbers(mimic, "multiplier", 1, f"{where}: mimic", (1.0,))
        (offset,) = self._numbers(mimic, "offset", 1, f"{where}: mimic", (0.0,))
        return Mimic(mimic.get("joint") or "another", multiplier, offset)

    def _visual_shape(self, element: Element, body: str) -> VisualShape | None:
        """Return a visual as a shape, m; None for a mesh that is left out, or a size of zero; refuse others."""
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
            return VisualShape("mesh", pose, named=self._file_name(shape, where), scale=scale, body=body)
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
        return VisualShape(kind, pose, tuple(size)) if min(size) > 0.0 else None

    def _file_name(self, shape: Element, where: str) -> str:
        """Return the file name of a mesh as the URDF gives it; raise InputError if it is missing."""
        name = (shape.get("filename") or "").strip()
        if not name:
            self._refuse(where, "has a mesh without filename", 'give <mesh filename="meshes/link.stl"/>')
        return name

    def _scale(self, shape: Element, where: str) -> tuple[float, ...]:
        """Return the scale of a mesh along x, y and z; one number holds for all, and 1 where it is missing."""
        if len((shape.get("scale") or "").split()) == 1:
            return self._numbers(shape, "scale", 1, where, None) * 3
        return self._numbers(shape, "scale", 3, where, (1.0, 1.0, 1.0))

    def _origin(self, element: Element, where: str) -> Pose:
        """Return the pose of an element, the identity without origin; note angles that are probably in degrees.

        An orientation as `quat_xyzw` is refused.
        """
        origin = element.find("origin")
        if origin is None:
            return translation_pose((0.0, 0.0, 0.0))
        if origin.get("quat_xyzw") is not None:
            what = "has an orientation as quat_xyzw, which most readers skip without a word"
            self._refuse(f"{where}: origin", what, f'give rpy="{self._rpy(origin, where)}" in its place')
        turn = self._numbers(origin, "rpy", 3, f"{where}: origin", (0.0, 0.0, 0.0))
        place = self._numbers(origin, "xyz", 3, f"{where}: origin", (0.0, 0.0, 0.0))
        if max(map(abs, turn)) > MAX_RADIANS:
            angles = f'rpy="{origin.get("rpy")}"'
            self._note(where, f"{angles} is read in rad, as URDF has it: more than a full turn; are they degrees?")
        return Pose(rotation_from_angles(turn), np.array(place))

    def _rpy(self, origin: Element, where: str) -> str:
        """Return the roll, pitch and yaw angles of an orientation in a quaternion, as text."""
        x, y, z, w = self._numbers(origin, "quat_xyzw", 4, f"{where}: origin", None)
        angle, axis = 2.0 * np.arctan2(np.hypot(np.hypot(x, y), z), w), np.array([x, y, z])
        axes = rotation_about_axis(axis / np.linalg.norm(axis), angle) if axis.any() else np.eye(3)
        return " ".join(f"{value + 0.0:.9g}" for value in angles_from_rotation(axes))

    def _numbers(
        self, element: Element, key: str, count: int, where: str, otherwise: tuple[float, ...] | None
    ) -> tuple[float, ...]:
        """Return the numbers of an attribute, or a default where it is missing.

        Args:
            element: element that has the attribute.
            key: name of the attribute.
            count: count of numbers that it must have.
            where: place in messages.
            otherwise: value of a missing attribute; None if it is required.

        Raises:
            InputError: the attribute is required, or is not that many finite numbers.
        """
        text = element.get(key)
        if text is None and otherwise is not None:
            return otherwise
        example = " ".join(["0.1", "0", "0.2"][:count])
        try:
            values = tuple(map(float, (text or "").split()))
        except ValueError:
            values = ()
        if len(values) != count or not all(map(isfinite, values)):
            expected = "a number" if count == 1 else f"{count} numbers"
            self._refuse(where, f"{key} is {text!r}, not {expected}", f'give {key}="{example}"')
        return values

    def _note(self, where: str, what: str) -> None:
        self.notes.append(f"{where}: {what}")

    def _refuse(self, where: str, what: str, right: str) -> NoReturn:
        raise InputError(what, where=f"{self.file}: {where}" if where else str(self.file), right=right)


def _is_some(text: str | None) -> bool:
    """Return whether an attribute exists and is not zero; a text that is no number counts as not zero."""
    try:
        return text is not None and float(text) != 0.0
    except ValueError:
        return True
