"""Joints of a robot that are not the arm's own, held still where the file draws them; an arm on one of its bodies."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from layflat.bridge.robots.robot import FIXED, SLIDE, STANDARD, Link, Pose, Robot, at
from layflat.description.hints import did_you_mean
from layflat.errors import InputError

ROOM = 1e-9  # by which a position may be out of a joint's limits, rad or m


class HeldJoints:
    """Joints that hang on the arm's links and are held still.

    Args:
        robot: whose joints they are.
        moving: the arm's own joints, which turn.
    """

    def __init__(self, robot: Robot, moving: Sequence[Link]) -> None:
        self._joints = {link.name: link for link in robot.links}
        self._moving = {link.name for link in moving}
        self._held: list[Link] = []

    def hold(self, link: Link) -> Pose:
        """Hold a joint; return the pose of the body that it carries, in the frame of the one that carries it."""
        self._held.append(link)
        return link.displaced(self._position(link) - link.zero)

    def notes(self) -> list[str]:
        """Return a line each on joints held still, on those that can't be there, and on those that would follow."""
        positions = {link.name: self._position(link) for link in self._held}
        notes = []
        at_zero = [name for name, position in positions.items() if position == 0.0]
        if at_zero:
            notes.append(f"joints held still at zero: {', '.join(at_zero)}")
        elsewhere = [_place(link, positions[link.name]) for link in self._held if positions[link.name] != 0.0]
        if elsewhere:
            notes.append(f"joints held still: {', '.join(elsewhere)}")
        beyond = [_limits(link) for link in self._held if _is_beyond(link, positions[link.name])]
        if beyond:
            notes.append(f"their own limits do not let them be there: {', '.join(beyond)}")
        followers = [
            f"{link.name} follows {link.mimic.joint}"
            for link in self._held
            if link.mimic is not None and link.mimic.joint in self._moving
        ]
        if followers:
            notes.append(f"in the robot {', '.join(followers)}; here it is held still, and its mass with it")
        return notes

    def _position(self, link: Link, followed: tuple[str, ...] = ()) -> float:
        """Return a joint's position while the arm's own joints are at zero: its zero, or what it mimics."""
        if link.mimic is None:
            return link.zero
        leader = self._joints.get(link.mimic.joint)
        still = leader is None or leader.name in self._moving or leader.name in followed
        lead = 0.0 if still or leader is None else self._position(leader, (*followed, link.name))
        return link.mimic.multiplier * lead + link.mimic.offset


def _unit(link: Link) -> str:
    return "m" if link.kind == SLIDE else "rad"


def _place(link: Link, position: float) -> str:
    return f"{link.name} at {position:.4g} {_unit(link)}"


def _limits(link: Link) -> str:
    assert link.limits is not None
    lower, upper = link.limits
    return f"{link.name} ({lower:g} to {upper:g} {_unit(link)})"


def _is_beyond(link: Link, position: float) -> bool:
    if link.limits is None or link.limits[0] >= link.limits[1]:
        return False
    return not link.limits[0] - ROOM <= position <= link.limits[1] + ROOM


def stand_on(robot: Robot, body: str) -> Robot:
    """Return what stands on a body, which becomes the base; gravity is turned into its frame.

    Args:
        robot: as read from a file.
        body: name of the body; joints between it and the robot's own base are held where the file draws them.

    Raises:
        InputError: there is no such body.
    """
    if body not in robot.bodies:
        right = did_you_mean(body, robot.bodies, f"{robot.noun}s are {{}}")
        raise InputError(f"there is no {robot.noun} {body!r}", where="--from", right=right)
    held, pose = HeldJoints(robot, []), at((0.0, 0.0, 0.0))
    for link in robot.to(body):
        pose = pose.then(link.pose if link.kind == FIXED else held.hold(link))
    standing = set(robot.behind(body))
    gravity = np.array(STANDARD if robot.gravity is None else robot.gravity, float)
    return replace(
        robot,
        base=body,
        bodies={name: own for name, own in robot.bodies.items() if name in standing},
        links=[link for link in robot.links if link.parent in standing],
        frames={name: frame for name, frame in robot.frames.items() if frame[0] in standing},
        gravity=pose.axes.T @ gravity,
        loops=[
            (name, {one if one in standing else body for one in tied})
            for name, tied in robot.loops
            if not standing.isdisjoint(tied)
        ],
        notes=[*robot.notes, *held.notes()],
    )
