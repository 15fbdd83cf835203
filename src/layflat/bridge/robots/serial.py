"""Extraction of a serial chain of joints from a robot: fixed bodies are merged, other joints held."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NoReturn

import numpy as np

from layflat.arrays import Array
from layflat.bridge.robots.held import HeldJoints
from layflat.bridge.robots.robot import (
    FIXED_JOINT,
    HINGE_JOINT,
    Inertial,
    Pose,
    Robot,
    RobotBody,
    RobotLink,
    VisualShape,
    translation_pose,
    unit_vector,
)
from layflat.description.wrong import did_you_mean
from layflat.errors import InputError
from layflat.physics.arms.bodies import lump_bodies
from layflat.physics.arms.chain.description import (
    MIN_DIRECTION_LENGTH,
    TRIANGLE_INEQUALITY_TOLERANCE,
    describe_inertia_defect,
)
from layflat.physics.arms.kind import MAX_JOINTS

ZERO_INERTIA = 1e-12  # moment of inertia that counts as zero, kg m2
TOOL_NAMES = ("tool", "tip", "tcp", "tool0")
"""Default names of the tool's frame, in order of precedence."""
PAYLOAD = "payload"  # a body of this name at the tool is the payload
POINT_INERTIA_RATIO = 1e-9  # inertia over mass x (1 m)^2 up to which a body counts as a point


def merge_members(robot: Robot, joint: RobotLink, members: Mapping[str, Pose]) -> tuple[Inertial, list[VisualShape]]:
    """Return mass and shapes of all bodies that move with a joint as one, in the joint's frame.

    Args:
        robot: the robot.
        joint: the joint.
        members: poses of the bodies in its frame, by name.

    Raises:
        InputError: they have no mass together, or a body or their sum has an impossible mass or inertia.
    """
    bodies = {name: robot.bodies[name] for name in members}
    for body in bodies.values():
        _check_masses(robot, body)
    weighing = [body.inertial.in_parent_frame(members[name]) for name, body in bodies.items() if body.inertial]
    whole = Inertial(*lump_bodies(weighing)) if weighing else Inertial(0.0, np.zeros(3), np.zeros((3, 3)))
    others = [name for name in bodies if name != joint.child]
    also = f" (with {', '.join(others)})" if others else ""
    if whole.mass <= 0.0:
        what = f"has no {'mass' if weighing else 'inertial'}{also}, and the joint {joint.name!r} turns it"
        _refuse(robot, joint.child, what, "give it mass and inertia")
    rows, columns = (0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)
    wrong = describe_inertia_defect(tuple(whole.inertia[rows, columns].tolist()))
    if wrong:
        _refuse(robot, joint.child, f"{also} {wrong}".strip(), "give it the inertia of a body")
    looks = [replace(look, pose=members[name].then(look.pose)) for name, body in bodies.items() for look in body.looks]
    return whole, looks


def _check_masses(robot: Robot, body: RobotBody) -> None:
    """Raise InputError for impossible masses; a body that is merged into others may be a point."""
    if body.inertial is None:
        return
    if body.inertial.mass < 0.0:
        _refuse(robot, body.name, f"has a mass of {body.inertial.mass:g} kg", "give one above 0")
    lower, middle, upper = np.linalg.eigvalsh(body.inertial.inertia)
    moments = f"principal moments of inertia {lower:.4g}, {middle:.4g} and {upper:.4g} kg m2"
    tolerance = max(TRIANGLE_INEQUALITY_TOLERANCE * abs(upper), ZERO_INERTIA)
    if lower < -tolerance:
        _refuse(robot, body.name, f"has {moments}", "none can be negative")
    if upper > lower + middle + tolerance:
        _refuse(robot, body.name, f"has {moments}", "none can be greater than the other two together")


def _refuse(robot: Robot, body: str, what: str, right: str) -> NoReturn:
    raise InputError(what, where=f"{robot.file}: {robot.noun} {body!r}", right=right)


@dataclass(frozen=True)
class ChainStage:
    """Joint of a chain, with the bodies that it moves up to the next joint."""

    joint: RobotLink
    pose: Pose  # of its frame, whose origin is on the joint's axis, in the frame before, at zero
    axis: Array  # of length 1, (3,)
    inertial: Inertial
    looks: list[VisualShape]  # in its frame


@dataclass(frozen=True)
class SerialChain:
    """A chain of joints from base to tool."""

    robot: Robot
    stages: tuple[ChainStage, ...]
    tool: Pose  # in the frame of the last stage
    tool_name: str
    payload: float  # kg
    notes: tuple[str, ...]  # on parts that were omitted or changed


def extract_chain(robot: Robot, *, to: str = "", tool: str = "") -> SerialChain:
    """Return the chain of joints that ends at a body, or the only one that there is.

    Args:
        robot: as read from a file.
        to: name of the body that the chain ends at; default: the end of the only chain.
        tool: name of the body or frame of the payload; default: `to`, else one of `TOOL_NAMES`, or the chain's end.

    Raises:
        InputError: it is no open chain of up to seven hinges, a body has no mass or an impossible one, or a name is
            unknown.
    """
    return _ChainExtractor(robot).extract(to, tool)


class _ChainExtractor:
    """Extractor of a serial chain from a robot; its errors name file and joint."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.noun = robot.noun

    def extract(self, to: str, tool: str) -> SerialChain:
        """Return the serial chain that ends at a body and a tool frame.

        Bodies up to the next joint of the chain are merged; other joints are held as by `HeldJoints`.

        Args:
            to: last body of the chain, "" for the only one possible.
            tool: name of the frame of the tool, "" for the default one.
        """
        path = self._path_to(to) if to else self._only_path()
        joints = [link for link in path if link.kind != FIXED_JOINT]
        self._check_joints(joints, to)
        ends = [*joints[1:], None]
        held = HeldJoints(self.robot, joints)
        stages, before = [], self._base_pose(path, joints[0])
        last: dict[str, Pose] = {}
        payload, weightless, clusters = 0.0, list[str](), list[set[str]]()
        for joint, after in zip(joints, ends, strict=True):
            members = self._cluster(joint, after, held)
            clusters.append(set(members))
            carried = members.pop(PAYLOAD, None) if after is None and self._is_payload(joint) else None
            payload = self._mass(PAYLOAD) if carried is not None else 0.0
            stages.append(
                ChainStage(
                    joint,
                    before.then(joint.pose).then(translation_pose(joint.anchor)),
                    self._axis(joint),
                    *merge_members(self.robot, joint, members),
                )
            )
            weightless += [name for name in members if self._is_weightless(name)]
            last = members if carried is None else {**members, PAYLOAD: carried}
            before = Pose(np.eye(3), np.zeros(3)) if after is None else members[after.parent]
        self._check_loops(clusters)
        name, pose = self._tool(tool, to, last)
        return SerialChain(self.robot, tuple(stages), pose, name, payload, self._notes(held, weightless))

    def _base_pose(self, path: list[RobotLink], first: RobotLink) -> Pose:
        """Return the pose of the first moving joint's parent in the base, along fixed joints."""
        pose = translation_pose((0.0, 0.0, 0.0))
        for link in path[: path.index(first)]:
            pose = pose.then(link.pose)
        return pose

    def _path_to(self, to: str) -> list[RobotLink]:
        """Return the joints from the base to a body; raise InputError if there is no such body."""
        robot = self.robot
        if to not in robot.bodies:
            right = did_you_mean(to, robot.bodies, f"{self.noun}s are {{}}")
            raise InputError(f"there is no {self.noun} {to!r}", where="to", right=right)
        return robot.links_to(to)

    def _only_path(self) -> list[RobotLink]:
        """Return the links up to the last moving joint of the only chain; raise InputError if there are several."""
        robot, body = self.robot, self.robot.base
        path: list[RobotLink] = []
        while True:
            following = self._next_joints(body)
            if not following:
                return path
            if len(following) > 1:
                moving = [link for link in path if link.kind != FIXED_JOINT]
                if moving:  # no choice of an end helps where the common part is no arm
                    self._check_joints(moving, "")
                names = " and ".join(repr(link.name) for link in following[:2])
                ends = [list(robot.subtree(link.child))[-1] for link in following]
                here = [body] if path else []
                right = f"choose where the arm ends: {', or '.join(f'`to={one!r}`' for one in [*here, *ends][:3])}"
                self._refuse(f"{self.noun} {body!r}", f"carries several moving joints, such as {names}", right)
            path = robot.links_to(following[0].child)
            body = following[0].child

    def _next_joints(self, body: str) -> list[RobotLink]:
        """Return the moving joints next to a body, beyond fixed joints."""
        joints = []
        for link in self.robot.links_on(body):
            joints += self._next_joints(link.child) if link.kind == FIXED_JOINT else [link]
        return joints

    def _check_joints(self, joints: list[RobotLink], to: str) -> None:
        """Raise InputError unless the joints are 1 to `MAX_JOINTS` hinges, each with an axis and without mimic."""
        if not joints:
            self._refuse(
                "", "has no joint that moves", "give a robot with joints that turn" + (to and ", or another `to`")
            )
        for link in joints:
            if link.kind != HINGE_JOINT:
                right = "joints of hose turn about an axis"
                if link is not joints[0]:
                    right += f"; to end the arm before it: `to={link.parent!r}`"
                elif link.kind in {"floating", "planar"}:
                    right = f"the base of an arm stands still: `base={link.child!r}`"
                else:
                    right += f"; for the arm that stands on it: `base={link.child!r}`"
                self._refuse(f"joint {link.name!r}", f"is {link.kind}", right)
            if link.axis is None or float(np.abs(link.axis).max()) < MIN_DIRECTION_LENGTH**0.5:
                what = "has no axis" if link.axis is None else "has an axis without direction"
                self._refuse(f"joint {link.name!r}", what, 'give one such as <axis xyz="0 0 1"/>')
            if link.mimic is not None:
                what = f"mimics {link.mimic.joint!r}"
                self._refuse(f"joint {link.name!r}", what, "joints here move by themselves: drop <mimic>")
        if len(joints) > MAX_JOINTS:
            right = (
                f"an arm has {MAX_JOINTS} at most; end it earlier, for example `to={joints[MAX_JOINTS - 1].child!r}`"
            )
            self._refuse("", f"has {len(joints)} joints from {joints[0].name!r} to {joints[-1].name!r}", right)

    def _check_loops(self, clusters: list[set[str]]) -> None:
        """Raise InputError for constraints between bodies that the arm's joints move relative to each other."""
        for name, tied in self.robot.loops:
            movers = {next((i for i, bodies in enumerate(clusters) if body in bodies), None) for body in tied}
            if len(movers) > 1:
                what = f"the equality constraint {name!r} ties {' and '.join(sorted(tied))}: a closed chain"
                self._refuse("", what, "an arm here is an open chain; take the constraint away")

    def _cluster(self, joint: RobotLink, after: RobotLink | None, held: HeldJoints) -> dict[str, Pose]:
        """Return the poses, in a joint's frame, of the bodies that move with it as one; hold the joints among them."""
        poses: dict[str, Pose] = {}

        def add(name: str, pose: Pose) -> None:
            """Add a body at a pose, and the bodies on it up to the joint `after`."""
            poses[name] = pose
            for link in self.robot.links_on(name):
                if after is not None and link.name == after.name and link.child == after.child:
                    continue
                add(link.child, pose.then(link.pose if link.kind == FIXED_JOINT else held.hold(link)))

        add(joint.child, translation_pose(-joint.anchor))
        return poses

    def _axis(self, joint: RobotLink) -> Array:
        return unit_vector(np.array(joint.axis, float))

    def _is_payload(self, joint: RobotLink) -> bool:
        """Return whether the body `PAYLOAD` is nearly a point mass and not the joint's own link."""
        body = self.robot.bodies.get(PAYLOAD)
        if body is None or body.inertial is None or joint.child == PAYLOAD:
            return False
        return bool(
            np.abs(body.inertial.inertia).max() <= POINT_INERTIA_RATIO * max(body.inertial.mass, POINT_INERTIA_RATIO)
        )

    def _mass(self, name: str) -> float:
        """Return the mass of a body, kg; 0 if it has no inertial."""
        inertial = self.robot.bodies[name].inertial
        return 0.0 if inertial is None else inertial.mass

    def _is_weightless(self, name: str) -> bool:
        """Return whether a body has a shape but no mass."""
        body = self.robot.bodies[name]
        return body.solid and self._mass(name) == 0.0

    def _tool(self, tool: str, to: str, last: dict[str, Pose]) -> tuple[str, Pose]:
        """Return name and pose, in the last joint's frame, of the tool's frame; the default is that of `extract_chain`.

        Raises:
            InputError: the last joint moves no frame of this name.
        """
        frames = dict(last)
        frames |= {name: last[body].then(pose) for name, (body, pose) in self.robot.frames.items() if body in last}
        if tool:
            if tool not in frames:
                right = did_you_mean(tool, frames, "frames that the last joint turns are {}")
                raise InputError(f"{tool!r} is no frame that the last joint turns", where="tool", right=right)
            return tool, frames[tool]
        called = [name for name in TOOL_NAMES if name in frames]
        ends = [name for name in last if not self.robot.links_on(name)]
        chosen = [to] if to in frames else called[:1] or (ends if len(ends) == 1 else list(last)[:1])
        return chosen[0], frames[chosen[0]]

    def _notes(self, held: HeldJoints, weightless: list[str]) -> tuple[str, ...]:
        """Return the notes for a person: held joints, bodies without mass, and omitted elements."""
        notes = [*self.robot.notes, *held.notes()]
        if weightless:
            notes.append(f"{self.noun}s that have a shape and weigh nothing: {', '.join(weightless)}")
        if self.robot.omitted:
            notes.append(f"left out: {', '.join(self.robot.omitted)}")
        return tuple(notes)

    def _refuse(self, where: str, what: str, right: str) -> NoReturn:
        raise InputError(what, where=f"{self.robot.file}: {where}".removesuffix(": "), right=right)
