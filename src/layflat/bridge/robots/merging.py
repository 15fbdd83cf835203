"""Bodies that move as one, merged into one, as long as each of them can be a body."""

from collections.abc import Mapping
from dataclasses import replace
from typing import NoReturn

import numpy as np

from layflat.bridge.robots.robot import Body, Inertial, Link, Look, Pose, Robot
from layflat.errors import InputError
from layflat.physics.arms.bodies import lumped
from layflat.physics.arms.chain.description import ROUNDING, impossible

NOTHING = 1e-12  # moment of inertia that counts as none, as in descriptions, kg m2


def merged(robot: Robot, joint: Link, members: Mapping[str, Pose]) -> tuple[Inertial, list[Look]]:
    """Return the mass of all that a joint turns as one, and what it is drawn by, in the joint's frame.

    Args:
        robot: whose bodies they are.
        joint: the joint.
        members: where the bodies lie in its frame, by name.

    Raises:
        InputError: a body has no mass, or one that can't be.
    """
    bodies = {name: robot.bodies[name] for name in members}
    for body in bodies.values():
        _check(robot, body)
    weighing = [body.inertial.seen_from(members[name]) for name, body in bodies.items() if body.inertial]
    whole = Inertial(*lumped(weighing)) if weighing else Inertial(0.0, np.zeros(3), np.zeros((3, 3)))
    others = [name for name in bodies if name != joint.child]
    also = f" (with {', '.join(others)})" if others else ""
    if whole.mass <= 0.0:
        what = f"has no {'mass' if weighing else 'inertial'}{also}, and the joint {joint.name!r} turns it"
        _refuse(robot, joint.child, what, "give it mass and inertia")
    rows, columns = (0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)
    wrong = impossible(tuple(whole.inertia[rows, columns].tolist()))
    if wrong:
        _refuse(robot, joint.child, f"{also} {wrong}".strip(), "give it the inertia of a body")
    looks = [replace(one, pose=members[name].then(one.pose)) for name, body in bodies.items() for one in body.looks]
    return whole, looks


def _check(robot: Robot, body: Body) -> None:
    """Refuse masses that can't be; a body that is merged into others may be a point."""
    if body.inertial is None:
        return
    if body.inertial.mass < 0.0:
        _refuse(robot, body.name, f"has a mass of {body.inertial.mass:g} kg", "give one above 0")
    least, middle, greatest = np.linalg.eigvalsh(body.inertial.inertia)
    moments = f"principal moments of inertia {least:.4g}, {middle:.4g} and {greatest:.4g} kg m2"
    room = max(ROUNDING * abs(greatest), NOTHING)
    if least < -room:
        _refuse(robot, body.name, f"has {moments}", "none can be negative")
    if greatest > least + middle + room:
        _refuse(robot, body.name, f"has {moments}", "none can be greater than the other two together")


def _refuse(robot: Robot, body: str, what: str, right: str) -> NoReturn:
    raise InputError(what, where=f"{robot.file}: {robot.noun} {body!r}", right=right)
