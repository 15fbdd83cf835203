"""Part of a robot that stands on one of its bodies, such as an arm on a lift; what is before it is held still."""

from dataclasses import replace

import numpy as np

from layflat.bridge.robots.describe import STANDARD
from layflat.bridge.robots.held import HeldJoints
from layflat.bridge.robots.robot import FIXED, Robot, at
from layflat.description.hints import did_you_mean
from layflat.errors import InputError


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
