"""Strokes of joints of hose that take the place of a robot's own."""

from collections.abc import Mapping
from math import degrees
from typing import NamedTuple

from layflat.bridge.robots.robot import Link
from layflat.bridge.robots.serial import Serial
from layflat.description.hints import did_you_mean
from layflat.errors import InputError
from layflat.machine.parts import Joint

ROOM = 1e-9  # rad
MIN_STROKE = 1e-4  # within which no joint turns, rad


class Turning(NamedTuple):
    """Range of a joint of hose in place of a robot's."""

    middle: float  # position of the robot's joint in mid-stroke, rad
    mechanical: float  # strokes, rad
    works: float
    asked: float  # stroke about that middle that the robot's limits allow, rad
    limits: tuple[float, float]  # of the robot's joint, rad


def strokes(chain: Serial, hoses: Mapping[str, Joint], given: Mapping[str, tuple[float, float]]) -> list[Turning]:
    """Return how far the joints of a chain turn: as the robot's do, or as far as hoses reach, about the same middle.

    The middle is that of the range in which the robot's joint works: of its soft limits where the file has such, else
    of its limits.

    Args:
        chain: the robot's joints.
        hoses: joints of hose that take their place, by name.
        given: limits in place of those of the robot, by name of the joint, rad.

    Raises:
        InputError: a joint has no limits, limits are given that hoses do not reach, or of an unknown joint.
    """
    names = [stage.joint.name for stage in chain.stages]
    for name in given:
        if name not in names:
            raise InputError(f"unknown joint {name!r}", where="--stroke", right=did_you_mean(name, names, "give {}"))
    found = []
    for name, stage in zip(names, chain.stages, strict=True):
        stops = hoses[name].stops
        most, margin = stops.mechanical_stroke, stops.mechanical_stroke - stops.working_stroke
        lower, upper = given[name] if name in given else _limits(chain, stage.joint, most)
        if name in given and upper - lower > most + ROOM:
            raise InputError(
                f"{degrees(upper - lower):.4g} deg of joint {name!r} are more than its hoses turn",
                where="--stroke",
                right=f"give {degrees(most):.4g} deg at most, or other --joints",
            )
        soft = None if name in given else _soft_limits(stage.joint, (lower, upper))
        middle = 0.5 * (lower + upper) if soft is None else 0.5 * (soft[0] + soft[1])
        stroke = upper - lower if soft is None else 2.0 * min(middle - lower, upper - middle)
        mechanical = min(stroke, most)
        usual = mechanical - margin if mechanical > 2.0 * margin else mechanical * stops.working_stroke / most
        if soft is not None:  # where hoses reach less far, they keep their distance from the stops
            usual = min(soft[1] - soft[0], mechanical if mechanical == stroke else usual)
        usual = min(usual, stops.working_stroke)
        found.append(Turning(middle, mechanical, usual, stroke, (lower, upper)))
    return found


def _limits(chain: Serial, joint: Link, most: float) -> tuple[float, float]:
    """Return a joint's own limits; refuse those within which nothing can turn."""
    if joint.limits is None:
        what = f"joint {joint.name!r} turns without limits"
    elif not joint.limits[1] - joint.limits[0] > MIN_STROKE:
        what = f"joint {joint.name!r} has limits from {joint.limits[0]:g} to {joint.limits[1]:g} rad"
    else:
        return joint.limits
    reach = f"hoses turn {degrees(most):.4g} deg at most"
    right = f'{reach}: give --stroke "{joint.name}=-40 deg, 40 deg"'
    raise InputError(what, where=str(chain.robot.file), right=right)


def _soft_limits(joint: Link, limits: tuple[float, float]) -> tuple[float, float] | None:
    """Return what of a joint's soft limits lies within its limits, if anything does."""
    if joint.soft_limits is None:
        return None
    lower, upper = max(joint.soft_limits[0], limits[0]), min(joint.soft_limits[1], limits[1])
    return (lower, upper) if upper - lower > MIN_STROKE else None
