"""Joints of a robot outside the chain, held at the position of the file; a robot rebased on another body."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from layflat.bridge.robots.robot import (
    DEFAULT_GRAVITY,
    FIXED_JOINT,
    SLIDE_JOINT,
    Pose,
    Robot,
    RobotLink,
    translation_pose,
)
from layflat.description.wrong import did_you_mean
from layflat.errors import InputError

LIMIT_TOLERANCE = 1e-9  # tolerance of a joint's limits, rad or m


class HeldJoints:
    """Joints on the arm's links that are held still.

    Args:
        robot: the robot.
        moving: joints of the chain.
    """

    def __init__(self, robot: Robot, moving: Sequence[RobotLink]) -> None:
        self._joints = {link.name: link for link in robot.links}
        self._moving = {link.name for link in moving}
        self._held: list[RobotLink] = []

    def hold(self, link: RobotLink) -> Pose:
        """Hold a joint; return the pose of its child body in the frame of its parent."""
        self._held.append(link)
        return link.displaced(self._position(link) - link.zero)

    def notes(self) -> list[str]:
        """Return notes on joints that are held, on those outside their limits, and on those that mimic moving ones."""
        positions = {link.name: self._position(link) for link in self._held}
        notes = []
        at_zero = [name for name, position in positions.items() if position == 0.0]
        if at_zero:
            notes.append(f"joints held still at zero: {', '.join(at_zero)}")
        elsewhere = [
            _describe_position(link, positions[link.name]) for link in self._held if positions[link.name] != 0.0
        ]
        if elsewhere:
            notes.append(f"joints held still: {', '.join(elsewhere)}")
        beyond = [_describe_limits(link) for link in self._held if _is_beyond(link, positions[link.name])]
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

    def _position(self, link: RobotLink, followed: tuple[str, ...] = ()) -> float:
        """Return a joint's position: its zero, or by the joint it mimics, which counts as 0 if moving or unknown."""
        if link.mimic is None:
            return link.zero
        leader = self._joints.get(link.mimic.joint)
        still = leader is None or leader.name in self._moving or leader.name in followed
        leading = 0.0 if still or leader is None else self._position(leader, (*followed, link.name))
        return link.mimic.multiplier * leading + link.mimic.offset


def _unit(link: RobotLink) -> str:
    return "m" if link.kind == SLIDE_JOINT else "rad"


def _describe_position(link: RobotLink, position: float) -> str:
    return f"{link.name} at {position:.4g} {_unit(link)}"


def _describe_limits(link: RobotLink) -> str:
    """Return name and limits of a joint that has them, as text."""
    assert link.limits is not None
    lower, upper = link.limits
    return f"{link.name} ({lower:g} to {upper:g} {_unit(link)})"


def _is_beyond(link: RobotLink, position: float) -> bool:
    """Return whether a position is outside a joint's limits; False if it has none, or an empty range."""
    if link.limits is None or link.limits[0] >= link.limits[1]:
        return False
    return not link.limits[0] - LIMIT_TOLERANCE <= position <= link.limits[1] + LIMIT_TOLERANCE


def rebase_robot(robot: Robot, body: str) -> Robot:
    """Return the part of a robot that is carried by a body, which becomes the base; gravity is in its frame.

    Args:
        robot: the robot.
        body: name of the new base; joints between it and the old base are held at the position of the file.

    Raises:
        InputError: there is no such body.
    """
    if body not in robot.bodies:
        right = did_you_mean(body, robot.bodies, f"{robot.noun}s are {{}}")
        raise InputError(f"there is no {robot.noun} {body!r}", where="base", right=right)
    held, pose = HeldJoints(robot, []), translation_pose((0.0, 0.0, 0.0))
    for link in robot.links_to(body):
        pose = pose.then(link.pose if link.kind == FIXED_JOINT else held.hold(link))
    standing = set(robot.subtree(body))
    gravity = np.array(DEFAULT_GRAVITY if robot.gravity is None else robot.gravity, float)
    return replace(
        robot,
        base=body,
        bodies={name: carried for name, carried in robot.bodies.items() if name in standing},
        links=[link for link in robot.links if link.parent in standing],
        frames={name: frame for name, frame in robot.frames.items() if frame[0] in standing},
        gravity=pose.axes.T @ gravity,
        loops=[
            (name, {end if end in standing else body for end in tied})
            for name, tied in robot.loops
            if not standing.isdisjoint(tied)
        ],
        notes=[*robot.notes, *held.notes()],
    )
