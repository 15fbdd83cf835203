"""From a motion file to the trajectory of a machine's arm, and what it asks of the joints."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.errors import InputError
from layflat.machine import Machine, parameters
from layflat.motion.belt import Followed, Left, follow_belt
from layflat.motion.curve import Curve, Line, Point, Spline, arc
from layflat.motion.dynamics import hose_torques
from layflat.motion.file import ArcPart, BeltPart, JointPart, LinePart, Motion, SegmentPart, ViaPart, WaitPart
from layflat.motion.gentle import jerk_limited
from layflat.motion.kinematics import tip_motion, tip_position
from layflat.motion.limits import Ability, abilities
from layflat.motion.optimal import time_optimal
from layflat.motion.path import JointLine, JointSpline, Path
from layflat.motion.tip_path import tip_path
from layflat.motion.trajectory import Chain, Rest, Trajectory

LOOKS = 401  # instants of a segment that are looked at


class Asked(NamedTuple):
    """What a segment asks of the arm."""

    tip_speed: float  # greatest, m/s
    torque: float  # greatest share of what a joint's hoses give
    joint: str  # the joint of which that is


@dataclass(frozen=True)
class Segment:
    """A part of a motion, from rest to rest."""

    kind: str
    motion: Trajectory

    @property
    def left(self) -> Left | None:
        """When and where the target of a belt left the arm's reach, if it did."""
        return self.motion.left if isinstance(self.motion, Followed) else None


@dataclass(frozen=True)
class Plan:
    """A motion of a machine's arm with a payload (kg)."""

    machine: Machine
    payload: float
    segments: tuple[Segment, ...]

    @cached_property
    def trajectory(self) -> Chain:
        """All of it."""
        return Chain.of(*(segment.motion for segment in self.segments))

    @cached_property
    def able(self) -> Ability:
        """What the joints can do."""
        return abilities(self.machine)

    def torques(self, motion: Trajectory, times: Array) -> Array:
        """Return what a motion asks of the hoses at times (s), (instants, joints), N m."""
        return hose_torques(self.machine, self.able, motion.states(times), self.payload)

    def asked(self, segment: Segment) -> Asked:
        """Return what a segment asks of the arm."""
        times = np.linspace(0.0, segment.motion.duration, LOOKS)
        speed, _ = tip_motion(self.machine, *segment.motion.states(times))
        share = self.able.share(self.torques(segment.motion, times))
        name = list(self.machine.joints)[int(share.max(axis=0).argmax())]
        return Asked(float(np.linalg.norm(speed, axis=1).max()), float(share.max()), name)


def plan_motion(machine: Machine, motion: Motion) -> Plan:
    """Plan a motion that a file describes, for the arm of a machine.

    Raises:
        InputError: naming the segment: it asks for what the arm can't reach or do; or ruckig is not installed.
    """
    payload = machine.arm.payload if motion.payload is None else motion.payload
    at = _posture(machine, motion.start, f"{motion.origin}: start")
    plan, segments = Plan(machine, payload, ()), []
    for number, part in enumerate(motion.segment, 1):
        where = f"{motion.origin}: segment {number} ({part.kind})"
        segment = Segment(part.kind, _trajectory(machine, motion, part, at, payload, where))
        if part.kind == "belt":
            _check_able(plan, segment, where)
        segments.append(segment)
        at = segment.motion.at([segment.motion.duration])[0]
    return replace(plan, segments=tuple(segments))


def _trajectory(
    machine: Machine, motion: Motion, part: SegmentPart, at: Array, payload: float, where: str
) -> Trajectory:
    """Return what a segment makes of the posture `at` (joints,), rad, in which it begins."""
    if isinstance(part, WaitPart):
        return Rest(part.duration, at)
    if isinstance(part, BeltPart):
        return follow_belt(machine, at, part.direction, part.speeds, part.acceleration, where)
    timed = time_optimal if part.time_optimal else jerk_limited
    path = _path(machine, part, at, where)
    return timed(machine, path, payload=payload, tip=part.tip, reserve=motion.reserve)


def _path(machine: Machine, part: LinePart | ArcPart | ViaPart | JointPart, at: Array, where: str) -> Path:
    if isinstance(part, JointPart):
        return JointLine(at, _posture(machine, part.to, where))
    if isinstance(part, ViaPart) and part.angles is not None:
        return JointSpline(machine, [at, *(_posture(machine, angles, where) for angles in part.angles)], where)
    tip = tuple(tip_position(machine, at).tolist())
    curve: Curve
    if isinstance(part, LinePart):
        curve = Line.to(tip, _point(part.to, tip, where), where)
    elif isinstance(part, ArcPart):
        curve = arc(tip, _point(part.through, tip, where), _point(part.to, tip, where), where)
    else:
        curve = Spline([tip, *(_point(point, tip, where) for point in part.points or ())], where)
    return tip_path(machine, curve, at, where).checked()


def _point(given: Point, tip: Point, where: str) -> Point:
    """Return a point of the tip; raise InputError if it has not as many coordinates as the tip of the arm."""
    if len(given) != len(tip):
        what = f"gives a point with {len(given)} coordinates"
        raise InputError(what, where=where, right=f"give {len(tip)}: {', '.join('xyz'[: len(tip)])}")
    return given


def _posture(machine: Machine, angles: Sequence[float], where: str) -> Array:
    """Return angles as an array; raise InputError if they are not one a joint, or outside of a stroke."""
    if len(angles) != len(machine.joints):
        right = f"give {len(machine.joints)}: {', '.join(machine.joints)}"
        raise InputError(f"has {len(angles)} angles", where=where, right=right)
    checked = [parameters.check_inside_stroke(machine, *one, where) for one in zip(machine.joints, angles, strict=True)]
    return np.array(checked)


def _check_able(plan: Plan, segment: Segment, where: str) -> None:
    """Refuse what the joints can't do; others than belts are planned by that."""
    times = np.linspace(0.0, segment.motion.duration, LOOKS)
    speeds = np.abs(segment.motion.states(times).velocities) / plan.able.speed
    shares = plan.able.share(plan.torques(segment.motion, times))
    for of, share in (("speed", speeds), ("torque", shares)):
        if share.max() > 1.0:
            k, joint = np.unravel_index(int(share.argmax()), share.shape)
            name = list(plan.machine.joints)[joint]
            what = f"asks joint {name!r} for {share.max():.0%} of its {of} at {times[k]:.3f} s"
            right = "give a lower speed or acceleration, or a way further from a stretched arm"
            raise InputError(what, where=where, right=right)
