"""Trajectories of a machine's arm planned from motion files, and the loads of their segments."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.errors import InputError
from layflat.machine import Machine, load, parameters
from layflat.motion.belt import BeltMotion, ReachExit, follow_belt
from layflat.motion.curve import Curve, LineCurve, Point, SplineCurve, arc_through
from layflat.motion.dynamics import hose_torques
from layflat.motion.file import (
    ArcPart,
    BeltPart,
    JointPart,
    LinePart,
    MotionDescription,
    SegmentPart,
    ViaPart,
    WaitPart,
    make_motion,
)
from layflat.motion.jerk_limited import plan_jerk_limited
from layflat.motion.kinematics import tip_motion, tip_position
from layflat.motion.limits import JointCapabilities, joint_capabilities
from layflat.motion.optimal import plan_time_optimal
from layflat.motion.path import JointLine, JointPath, JointSpline
from layflat.motion.scenario import Scenario
from layflat.motion.signal_values import Angles, Value
from layflat.motion.tip_path import tip_path
from layflat.motion.trajectory import MotionSequence, RestMotion, Trajectory
from layflat.plot.tables import html_table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SEGMENT_SAMPLES = 401  # instants of a segment at which loads are evaluated
SEGMENT_COLUMNS = ("segment", "from (s)", "duration (s)", "peak tip speed (m/s)", "peak torque share (joint)")


class SegmentPeaks(NamedTuple):
    """Peaks of a segment: tip speed and joint torque."""

    tip_speed: float  # m/s
    torque: float  # greatest fraction of the torque of a joint's hoses
    joint: str  # with this torque


@dataclass(frozen=True)
class Segment:
    """Segment of a planned motion, from rest to rest."""

    kind: str
    motion: Trajectory

    @property
    def reach_exit(self) -> ReachExit | None:
        """Time and position at which the target on a belt leaves the arm's reach; None if it does not."""
        return self.motion.reach_exit if isinstance(self.motion, BeltMotion) else None


@dataclass(frozen=True)
class MotionPlan:
    """Planned motion of a machine's arm with a payload (kg)."""

    machine: Machine
    payload: float
    segments: tuple[Segment, ...]

    @cached_property
    def trajectory(self) -> MotionSequence:
        """Motion of all segments."""
        return MotionSequence.join(*(segment.motion for segment in self.segments))

    @cached_property
    def capabilities(self) -> JointCapabilities:
        """Capabilities of the joints."""
        return joint_capabilities(self.machine)

    def torques(self, motion: Trajectory, times: Array) -> Array:
        """Return the torques that the hoses have to exert in a motion at times (s), (instants, joints), N m."""
        return hose_torques(self.machine, self.capabilities, motion.states(times), self.payload)

    def segment_peaks(self, segment: Segment) -> SegmentPeaks:
        """Return the peaks of tip speed and of the joints' torques, each at its own instant, in a segment."""
        times = np.linspace(0.0, segment.motion.duration, SEGMENT_SAMPLES)
        speed, _ = tip_motion(self.machine, *segment.motion.states(times))
        fraction = self.capabilities.torque_fractions(self.torques(segment.motion, times))
        name = list(self.machine.joints)[int(fraction.max(axis=0).argmax())]
        return SegmentPeaks(float(np.linalg.norm(speed, axis=1).max()), float(fraction.max()), name)

    @property
    def scenario(self) -> Scenario:
        """Scenario in which the machine follows the motion: angles, velocities and accelerations at control cycles."""
        cycle = self.machine.cycle
        q, v, a = self.trajectory.rows(cycle)
        return Scenario(
            demand=q, demand_velocity=v, demand_acceleration=a, duration=cycle * len(q), payload=self.payload
        )

    def plot(self) -> "Figure":
        """Draw the tip's path, and angles, velocities and torques of the joints with their limits."""
        from layflat.motion.picture import draw_motion  # noqa: PLC0415  # takes long to import
        from layflat.plot.style import add_caption  # noqa: PLC0415

        exits = [np.array(segment.reach_exit.position) for segment in self.segments if segment.reach_exit is not None]
        caption = f"{self._title}; numbers are those of the segments"
        return add_caption(draw_motion(self.machine, self.trajectory, self.payload, exits), caption)

    def _repr_html_(self) -> str:
        return html_table(self._title, SEGMENT_COLUMNS, self.segment_rows())

    @property
    def _title(self) -> str:
        return f"{self.machine.name}: motion of {self.trajectory.duration:.3f} s with a payload of {self.payload:g} kg"

    def segment_rows(self) -> list[list[str]]:
        """Return the texts of `SEGMENT_COLUMNS` for each segment."""
        rows = []
        for number, (begin, segment) in enumerate(zip(self.trajectory.start_times, self.segments, strict=True), 1):
            peaks = self.segment_peaks(segment)
            times = f"{begin:.3f}", f"{segment.motion.duration:.3f}"
            rows.append(
                [f"{number} {segment.kind}", *times, f"{peaks.tip_speed:.2f}", f"{peaks.torque:.0%} ({peaks.joint})"]
            )
        return rows


def plan_motion(
    machine: str | Path | Machine,
    motion: str | Path | MotionDescription | Sequence[Mapping[str, Any]],
    *,
    start: Angles | None = None,
    payload: Value | None = None,
) -> MotionPlan:
    """Plan a motion of a machine's arm, within what its hoses and valves can do.

    Args:
        machine: a description, its file, or the name of a built-in machine.
        motion: a built-in name, a file, a description, or segments with the keys of a file's, such as
            `[{"kind": "line", "to": ["500 mm", "200 mm"]}]`; numbers are in SI units.
        start: angles at which segments begin; a number is in rad; default: mid-stroke. A file has its own.
        payload: a number is in kg; default: that of the motion, or of the machine.

    Raises:
        InputError: naming the segment: it is wrong, or beyond the arm's reach or capabilities; or ruckig is not
            installed.

    Example:
        >>> import layflat as lf
        >>> line = {"kind": "line", "to": ["450 mm", "300 mm"], "speed": "0.5 m/s"}
        >>> plan = lf.plan_motion("paper-arm-tracking", [line])
        >>> plan.trajectory.duration  # s
        0.303
        >>> run = lf.rollout(plan.machine, scenario=plan.scenario)
    """
    described = load(machine)
    return _plan_segments(described, make_motion(described, motion, start, payload))


def _plan_segments(machine: Machine, motion: MotionDescription) -> MotionPlan:
    """Return the plan of all segments of a motion, each from the end of the one before."""
    payload = machine.arm.payload if motion.payload is None else motion.payload
    at = _check_configuration(machine, motion.start, f"{motion.origin}: start")
    plan, segments = MotionPlan(machine, payload, ()), []
    for number, part in enumerate(motion.segment, 1):
        where = f"{motion.origin}: segment {number} ({part.kind})"
        segment = Segment(part.kind, _plan_segment(machine, motion, part, at, payload, where))
        if part.kind == "belt":
            _check_capabilities(plan, segment, where)
        segments.append(segment)
        at = segment.motion.angles_at([segment.motion.duration])[0]
    return replace(plan, segments=tuple(segments))


def _plan_segment(
    machine: Machine, motion: MotionDescription, part: SegmentPart, at: Array, payload: float, where: str
) -> Trajectory:
    """Return the motion of a segment that begins in the configuration `at` (joints,), rad."""
    if isinstance(part, WaitPart):
        return RestMotion(part.duration, at)
    if isinstance(part, BeltPart):
        return follow_belt(machine, at, part.direction, part.speeds, part.acceleration, where)
    plan = plan_time_optimal if part.time_optimal else plan_jerk_limited
    path = _segment_path(machine, part, at, where)
    return plan(machine, path, payload=payload, tip=part.tip, reserve=motion.reserve)


def _segment_path(machine: Machine, part: LinePart | ArcPart | ViaPart | JointPart, at: Array, where: str) -> JointPath:
    """Return the path of a segment from a configuration `at`, rad; raise InputError if it leaves the arm's reach."""
    if isinstance(part, JointPart):
        return JointLine(at, _check_configuration(machine, part.to, where))
    if isinstance(part, ViaPart) and part.angles is not None:
        return JointSpline(
            machine, [at, *(_check_configuration(machine, angles, where) for angles in part.angles)], where
        )
    tip = tuple(tip_position(machine, at).tolist())
    curve: Curve
    if isinstance(part, LinePart):
        curve = LineCurve.from_points(tip, _check_point(part.to, tip, where), where)
    elif isinstance(part, ArcPart):
        curve = arc_through(tip, _check_point(part.through, tip, where), _check_point(part.to, tip, where), where)
    else:
        curve = SplineCurve([tip, *(_check_point(point, tip, where) for point in part.points or ())], where)
    return tip_path(machine, curve, at, where).check_reachable()


def _check_point(point: Point, tip: Point, where: str) -> Point:
    """Return a point; raise InputError if it does not have as many coordinates as the tip of the arm."""
    if len(point) != len(tip):
        what = f"gives a point with {len(point)} coordinates"
        raise InputError(what, where=where, right=f"give {len(tip)}: {', '.join('xyz'[: len(tip)])}")
    return point


def _check_configuration(machine: Machine, angles: Sequence[float], where: str) -> Array:
    """Return angles as an array; raise InputError unless there is one per joint, within its stroke."""
    if len(angles) != len(machine.joints):
        right = f"give {len(machine.joints)}: {', '.join(machine.joints)}"
        raise InputError(f"has {len(angles)} angles", where=where, right=right)
    checked = [parameters.check_inside_stroke(machine, *one, where) for one in zip(machine.joints, angles, strict=True)]
    return np.array(checked)


def _check_capabilities(plan: MotionPlan, segment: Segment, where: str) -> None:
    """Raise InputError if a segment exceeds speed or torque of a joint, as a belt can; others are planned within."""
    times = np.linspace(0.0, segment.motion.duration, SEGMENT_SAMPLES)
    speeds = np.abs(segment.motion.states(times).velocities) / plan.capabilities.speed
    shares = plan.capabilities.torque_fractions(plan.torques(segment.motion, times))
    for of, share in (("speed", speeds), ("torque", shares)):
        if share.max() > 1.0:
            k, joint = np.unravel_index(int(share.argmax()), share.shape)
            name = list(plan.machine.joints)[joint]
            what = f"asks joint {name!r} for {share.max():.0%} of its {of} at {times[k]:.3f} s"
            right = "give a lower speed or acceleration, or a path further from a stretched arm"
            raise InputError(what, where=where, right=right)
