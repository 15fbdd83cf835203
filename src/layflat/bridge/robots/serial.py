"""From a robot to the chain of joints in it that is an arm: what is fixed is merged, what is not chosen held still."""

from dataclasses import dataclass
from typing import NoReturn

import numpy as np

from layflat.arrays import Array
from layflat.bridge.robots.held import HeldJoints
from layflat.bridge.robots.merging import merged
from layflat.bridge.robots.robot import FIXED, HINGE, Inertial, Link, Look, Pose, Robot, at, unit_vector
from layflat.description.hints import did_you_mean
from layflat.errors import InputError
from layflat.physics.arms.chain.description import NO_WAY
from layflat.physics.arms.kind import MOST

TOOLS = ("tool", "tip", "tcp", "tool0")
"""What the frame of a tool is called, where nobody says which it is; the first is taken that is there."""

PAYLOAD = "payload"  # a body of this name at the tool is what the arm carries
SMALL = 1e-9  # as a share of mass x (1 m)^2: inertia of a point


@dataclass(frozen=True)
class Stage:
    """A joint and all that it turns up to the next one."""

    joint: Link
    place: Pose  # of its frame, whose origin lies on the joint's axis, in the one before, at zero
    axis: Array  # of length 1, (3,)
    inertial: Inertial
    looks: list[Look]  # in its frame


@dataclass(frozen=True)
class Serial:
    """A chain of joints from base to tool."""

    robot: Robot
    stages: tuple[Stage, ...]
    tool: Pose  # in the frame of the last stage
    tool_name: str
    payload: float  # kg
    notes: tuple[str, ...]  # what became of the rest


def serial(robot: Robot, *, to: str = "", tool: str = "") -> Serial:
    """Return the chain of joints that ends at a body, or the only one that there is.

    Args:
        robot: as read from a file.
        to: name of the body that the chain ends at; default: where it ends by itself.
        tool: name of the body or frame where the payload is; default: one that is called so, or the chain's end.

    Raises:
        InputError: it is no open chain of up to seven hinges, a body has no mass or one that can't be, or a name is not
            known.
    """
    return _Chooser(robot).serial(to, tool)


class _Chooser:
    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.noun = robot.noun

    def serial(self, to: str, tool: str) -> Serial:
        way = self._way_to(to) if to else self._only_way()
        joints = [link for link in way if link.kind != FIXED]
        self._check(joints, to)
        ends = [*joints[1:], None]
        held = HeldJoints(self.robot, joints)
        stages, before = [], self._base(way, joints[0])
        last: dict[str, Pose] = {}
        payload, weightless, clusters = 0.0, list[str](), list[set[str]]()
        for joint, after in zip(joints, ends, strict=True):
            members = self._cluster(joint, after, held)
            clusters.append(set(members))
            carried = members.pop(PAYLOAD, None) if after is None and self._is_payload(joint) else None
            payload = self._mass(PAYLOAD) if carried is not None else 0.0
            stages.append(
                Stage(
                    joint,
                    before.then(joint.pose).then(at(joint.anchor)),
                    self._axis(joint),
                    *merged(self.robot, joint, members),
                )
            )
            weightless += [name for name in members if self._weighs_nothing(name)]
            last = members if carried is None else {**members, PAYLOAD: carried}
            before = Pose(np.eye(3), np.zeros(3)) if after is None else members[after.parent]
        self._check_loops(clusters)
        name, pose = self._tool(tool, to, last)
        return Serial(self.robot, tuple(stages), pose, name, payload, self._notes(held, weightless))

    def _base(self, way: list[Link], first: Link) -> Pose:
        pose = at((0.0, 0.0, 0.0))
        for link in way[: way.index(first)]:
            pose = pose.then(link.pose)
        return pose

    def _way_to(self, to: str) -> list[Link]:
        robot = self.robot
        if to not in robot.bodies:
            right = did_you_mean(to, robot.bodies, f"{self.noun}s are {{}}")
            self._refuse("--to", f"there is no {self.noun} {to!r}", right)
        return robot.to(to)

    def _only_way(self) -> list[Link]:
        """Return the links of the only chain of joints; refuse a robot that has several."""
        robot, body = self.robot, self.robot.base
        way: list[Link] = []
        while True:
            found = self._next_joints(body)
            if not found:
                return way
            if len(found) > 1:
                moving = [link for link in way if link.kind != FIXED]
                if moving:  # no choice of an end helps where the way to all of them is none
                    self._check(moving, "")
                names = " and ".join(repr(link.name) for link in found[:2])
                ends = [list(robot.behind(link.child))[-1] for link in found]
                here = [body] if way else []
                right = f"choose where the arm ends: {', or '.join(f'--to {one}' for one in [*here, *ends][:3])}"
                self._refuse(f"{self.noun} {body!r}", f"carries several moving joints, such as {names}", right)
            way = robot.to(found[0].child)
            body = found[0].child

    def _next_joints(self, body: str) -> list[Link]:
        found = []
        for link in self.robot.on(body):
            found += self._next_joints(link.child) if link.kind == FIXED else [link]
        return found

    def _check(self, joints: list[Link], to: str) -> None:
        if not joints:
            self._refuse(
                "", "has no joint that moves", "give a robot with joints that turn" + (to and ", or another --to")
            )
        for link in joints:
            if link.kind != HINGE:
                right = "joints of hose turn about an axis"
                if link is not joints[0]:
                    right += f"; to end the arm before it: --to {link.parent}"
                elif link.kind in {"floating", "planar"}:
                    right = f"the base of an arm stands still: --from {link.child}"
                else:
                    right += f"; for the arm that stands on it: --from {link.child}"
                self._refuse(f"joint {link.name!r}", f"is {link.kind}", right)
            if link.axis is None or float(np.abs(link.axis).max()) < NO_WAY**0.5:
                what = "has no axis" if link.axis is None else "has an axis without direction"
                self._refuse(f"joint {link.name!r}", what, 'give one such as <axis xyz="0 0 1"/>')
            if link.mimic is not None:
                what = f"mimics {link.mimic.joint!r}"
                self._refuse(f"joint {link.name!r}", what, "joints here move by themselves: drop <mimic>")
        if len(joints) > MOST:
            right = f"an arm has {MOST} at most; end it earlier, for example --to {joints[MOST - 1].child}"
            self._refuse("", f"has {len(joints)} joints from {joints[0].name!r} to {joints[-1].name!r}", right)

    def _check_loops(self, clusters: list[set[str]]) -> None:
        """Refuse constraints between bodies that the arm's joints move against each other."""
        for name, tied in self.robot.loops:
            movers = {next((i for i, bodies in enumerate(clusters) if body in bodies), None) for body in tied}
            if len(movers) > 1:
                what = f"the equality constraint {name!r} ties {' and '.join(sorted(tied))}: a closed chain"
                self._refuse("", what, "an arm here is an open chain; take the constraint away")

    def _cluster(self, joint: Link, after: Link | None, held: HeldJoints) -> dict[str, Pose]:
        """Return bodies that move with a joint alone, and where they lie in its frame; hold the joints among them."""
        found: dict[str, Pose] = {}

        def add(name: str, pose: Pose) -> None:
            found[name] = pose
            for link in self.robot.on(name):
                if after is not None and link.name == after.name and link.child == after.child:
                    continue
                add(link.child, pose.then(link.pose if link.kind == FIXED else held.hold(link)))

        add(joint.child, at(-joint.anchor))
        return found

    def _axis(self, joint: Link) -> Array:
        return unit_vector(np.array(joint.axis, float))

    def _is_payload(self, joint: Link) -> bool:
        body = self.robot.bodies.get(PAYLOAD)
        if body is None or body.inertial is None or joint.child == PAYLOAD:
            return False
        return bool(np.abs(body.inertial.inertia).max() <= SMALL * max(body.inertial.mass, SMALL))

    def _mass(self, name: str) -> float:
        inertial = self.robot.bodies[name].inertial
        return 0.0 if inertial is None else inertial.mass

    def _weighs_nothing(self, name: str) -> bool:
        body = self.robot.bodies[name]
        return body.solid and self._mass(name) == 0.0

    def _tool(self, tool: str, to: str, last: dict[str, Pose]) -> tuple[str, Pose]:
        """Return name and pose of the tool's frame, on what the last joint turns."""
        known = dict(last)
        known |= {name: last[body].then(pose) for name, (body, pose) in self.robot.frames.items() if body in last}
        if tool:
            if tool not in known:
                right = did_you_mean(tool, known, "frames that the last joint turns are {}")
                self._refuse("--tool", f"{tool!r} is no frame that the last joint turns", right)
            return tool, known[tool]
        called = [name for name in TOOLS if name in known]
        ends = [name for name in last if not self.robot.on(name)]
        chosen = [to] if to in known else called[:1] or (ends if len(ends) == 1 else list(last)[:1])
        return chosen[0], known[chosen[0]]

    def _notes(self, held: HeldJoints, weightless: list[str]) -> tuple[str, ...]:
        notes = [*self.robot.notes, *held.notes()]
        if weightless:
            notes.append(f"{self.noun}s that have a shape and weigh nothing: {', '.join(weightless)}")
        if self.robot.left_out:
            notes.append(f"left out: {', '.join(self.robot.left_out)}")
        return tuple(notes)

    def _refuse(self, where: str, what: str, right: str) -> NoReturn:
        place = where if where.startswith("--") else f"{self.robot.file}: {where}".removesuffix(": ")
        raise InputError(what, where=place, right=right)
