"""How far joints of hose turn in place of a robot's own."""

from collections.abc import Mapping
from math import degrees
from typing import NamedTuple

from layflat.bridge.robots.serial import Serial
from layflat.description.hints import did_you_mean
from layflat.errors import InputError
from layflat.machine.parts import Joint

ROOM = 1e-9  # rad


class Turning(NamedTuple):
    """How far a joint turns."""

    middle: float  # angle of the robot's joint in mid-stroke, rad
    mechanical: float  # strokes, rad
    works: float
    asked: float  # mechanical stroke of the robot's joint, rad


def strokes(chain: Serial, hoses: Mapping[str, Joint], given: Mapping[str, tuple[float, float]]) -> list[Turning]:
    """Return how far the joints of a chain turn: as the robot's do, or as far as hoses reach, about the same middle.

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
        stops, limits = hoses[name].stops, given.get(name, stage.joint.limits)
        most = stops.mechanical_stroke
        if limits is None:
            raise InputError(
                f"joint {name!r} turns without limits",
                where=str(chain.robot.file),
                right=f'hoses turn {degrees(most):.4g} deg at most: give --stroke "{name}=-40 deg, 40 deg"',
            )
        low, high = limits
        if name in given and high - low > most + ROOM:
            raise InputError(
                f"{degrees(high - low):.4g} deg of joint {name!r} are more than its hoses turn",
                where="--stroke",
                right=f"give {degrees(most):.4g} deg at most, or other --joints",
            )
        mechanical = min(high - low, most)
        margin = most - stops.working_stroke
        usual = mechanical - margin if mechanical > 2.0 * margin else mechanical * stops.working_stroke / most
        own = stage.joint.works if name not in given else None
        if own is not None:  # where hoses reach less far, they keep their distance from the stops
            usual = min(own, mechanical if mechanical == high - low else usual)
        usual = min(usual, stops.working_stroke)
        found.append(Turning(0.5 * (low + high), mechanical, usual, high - low))
    return found
