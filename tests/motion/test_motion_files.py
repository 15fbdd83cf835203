"""Motions from files: what they make of an arm's angles, and what is wrong, in one line."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from layflat.errors import InputError, MachineError
from layflat.machine import Machine, load
from layflat.motion.demand_file import read_demand, write_demand
from layflat.motion.file import MOTION_LIBRARY, read_motion
from layflat.motion.kinematics import tip_position
from layflat.motion.picture import reach_outlines
from layflat.motion.plan import MotionPlan, plan_motion
from layflat.motion.planar import PlanarReach
from layflat.sim import rollout

ARM, SMALL = load("paper-arm-tracking"), load("paper-small-joint-fast")
HEAD = 'name = "mine"\ntitle = "of a test"\nstart = ["0 deg", "0 deg"]\n'


def planned(text: str, folder: Path, machine: Machine = ARM, head: str = HEAD) -> MotionPlan:
    path = folder / "mine.toml"
    path.write_text(head + text, encoding="utf-8")
    return plan_motion(machine, read_motion(path))


@pytest.fixture(scope="module")
def tour() -> MotionPlan:
    return plan_motion(ARM, read_motion("tour"))


def test_every_built_in_motion_can_be_done() -> None:
    for name in MOTION_LIBRARY.names:
        motion = read_motion(name)
        machine = {2: ARM, 4: load("picking-arm")}[len(motion.start)]
        assert plan_motion(machine, motion).trajectory.duration > 0.0


def test_the_file_of_the_page_can_be_done(tmp_path: Path) -> None:
    page = (Path(__file__).parents[2] / "docs" / "motion.md").read_text(encoding="utf-8")
    text = page.partition("```toml\n")[2].partition("```")[0]
    plan = planned(text, tmp_path, head="")
    assert [segment.kind for segment in plan.segments] == ["line", "belt"]
    assert all(segment.reach_exit is None for segment in plan.segments)


def test_segments_end_where_they_are_told_to(tour: MotionPlan) -> None:
    file = read_motion("tour")
    ends = dict(zip(range(1, 8), tour.trajectory.angles_at(tour.trajectory.start_times)[1:], strict=False))
    for number, part in enumerate(file.segment[:6], 1):
        tip = tip_position(ARM, ends[number])
        to: Any = {"line": "to", "arc": "to", "via": "points"}.get(part.kind)
        if to is not None:
            expected = np.atleast_2d(getattr(part, to))[-1]
            assert_allclose(tip, expected, atol=1e-9)
    assert_allclose(np.degrees(ends[5]), [20.0, -20.0], atol=1e-9)
    assert_allclose(ends[3], ends[2])
    assert [segment.kind for segment in tour.segments] == [part.kind for part in file.segment]


def test_what_is_asked_stays_below_what_is_there(tour: MotionPlan) -> None:
    line, arc, wait, via, *_ = (tour.segment_peaks(segment) for segment in tour.segments)
    assert line.tip_speed == pytest.approx(0.4, rel=1e-3)
    assert arc.tip_speed == pytest.approx(0.6, rel=5e-3)
    assert wait.tip_speed == 0.0
    assert via.torque == pytest.approx(0.65, abs=0.02)  # all but the reserve
    assert via.joint in ARM.joints


def test_an_arm_follows_its_file(tour: MotionPlan, tmp_path: Path) -> None:
    """The tracking controller, by the demand file and its rates, is closer than by the angles alone."""
    q, v, a = tour.trajectory.rows(ARM.cycle)
    path = write_demand(ARM, tour.trajectory.times(ARM.cycle), q, tmp_path / "d.csv", velocity=v, acceleration=a)
    read = read_demand(ARM, path, ARM.cycle)
    duration = len(read.angles) * ARM.cycle
    run = rollout(
        ARM, read.angles, demand_velocity=read.velocities, demand_acceleration=read.accelerations, duration=duration
    )
    tips = [tip_position(ARM, run[name].to_numpy()) for name in ("angle", "demand")]
    assert np.sqrt(np.mean(np.sum((tips[0] - tips[1]) ** 2, axis=1))) < 3e-3


def test_a_payload_and_a_reserve_slow_the_arm_down(tmp_path: Path) -> None:
    segment = '[[segment]]\nkind = "joint"\nto = ["40 deg", "20 deg"]\ntime_optimal = true\n'
    usual, heavy, careful = (
        planned(more + segment, tmp_path).trajectory.duration for more in ("", 'payload = "4 kg"\n', "reserve = 0.7\n")
    )
    assert usual < heavy
    assert usual < careful


def test_one_joint_goes_by_angles(tmp_path: Path) -> None:
    text = (
        '[[segment]]\nkind = "joint"\nto = ["40 deg"]\ntime_optimal = true\n'
        '[[segment]]\nkind = "via"\nangles = [["10 deg"], ["20 deg"]]\nspeed = "0.3 m/s"\n'
    )
    plan = planned(text, tmp_path, SMALL, HEAD.replace('"0 deg", "0 deg"', '"-40 deg"'))
    assert_allclose(np.degrees(plan.trajectory.angles_at([0.0, 99.0])), [[-40.0], [20.0]], atol=1e-9)
    assert plan.segment_peaks(plan.segments[1]).tip_speed == pytest.approx(0.3, rel=1e-3)
    assert len(plan.plot().axes) == 4
    (arc,) = reach_outlines(SMALL)
    assert_allclose(np.linalg.norm(arc, axis=1), 0.4)


IN_SPACE = """
name = "mine"
title = "of a test"
start = ["0 deg", "20 deg", "-20 deg", "0 deg"]
[[segment]]
kind = "line"
to = ["650 mm", "200 mm", "350 mm"]
speed = "0.4 m/s"
time_optimal = true
[[segment]]
kind = "arc"
through = ["650 mm", "0 mm", "450 mm"]
to = ["650 mm", "-200 mm", "350 mm"]
time_optimal = true
[[segment]]
kind = "belt"
direction = "0 deg"
speeds = [["0 s", "0.4 m/s"], ["1.2 s", "0 m/s"]]
acceleration = "4 m/s^2"
"""


def test_an_arm_in_space_goes_where_it_is_told_to(tmp_path: Path) -> None:
    plan = planned("", tmp_path, load("picking-arm"), head=IN_SPACE)
    at = plan.trajectory.angles_at(plan.trajectory.start_times)
    assert_allclose(tip_position(plan.machine, at[1:]), [(0.65, 0.2, 0.35), (0.65, -0.2, 0.35)], atol=1e-9)
    assert plan.segment_peaks(plan.segments[0]).tip_speed == pytest.approx(0.4, rel=1e-2)
    left = plan.segments[2].reach_exit
    assert left is not None
    assert left.position[2] == pytest.approx(0.35)
    views = [axes.get_ylabel() for axes in plan.plot().axes]
    assert views.count("y (m)") == views.count("z (m)") == 1
    assert len(views) == 14


@pytest.mark.parametrize("machine", [ARM, load("paper-arm-fast")])
def test_outlines_are_the_edge_of_the_reach(machine: Machine) -> None:
    reach = PlanarReach(machine, margin=0.0)
    (outline,) = reach_outlines(machine)
    for x, y in outline.tolist():
        assert reach.distance_outside(x, y) < 1e-6
        assert min(arc.distance(x, y) for arc in reach._arcs) < 1e-6


LINE = '[[segment]]\nkind = "line"\nto = ["0.5 m", "0.3 m"]\n'
BELT = '[[segment]]\nkind = "belt"\ndirection = "90 deg"\nacceleration = "90 m/s^2"\n'


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            LINE.replace('"0.3 m"', '"0.3 m", "1 m"'),
            r"segment 1 \(line\): gives a point with 3 coordinates; give 2: x, y",
        ),
        (LINE + 'to_ = "x"\n', r"segment 1: to_: unknown key; did you mean 'to'\?"),
        (LINE.replace("line", "lin"), r"segment 1: kind: 'lin' is not a known kind; did you mean .line"),
        (LINE + 'speed = "0.3 deg"\n', r"segment 1: speed: '0.3 deg' is not a speed; give a speed such as"),
        (LINE.replace('"0.3 m"', ""), r"segment 1: to: has 1 values; give at least 2"),
        (LINE + 'time_optimal = true\njerk = "9 m/s^3"\n', r"segment 1: has a jerk, and is time_optimal, .*leave out"),
        (LINE + '[[segment]]\nkind = "via"\n', r"segment 2: needs points or angles; give one of them"),
        (LINE.replace("0.5 m", "0.9 m"), r"segment 1 \(line\): leaves the arm's reach 0.\d+ m along"),
        ('[[segment]]\nkind = "joint"\nto = ["5 deg"]\n', r"segment 1 \(joint\): has 1 angles; give 2: large, small"),
        ('[[segment]]\nkind = "joint"\nto = ["5 deg", "61 deg"]\n', r"\(joint\): 61 deg is outside the working stroke"),
        (
            BELT + 'speeds = [["0 s", "3 m/s"], ["0.1 s", "0 m/s"]]\n',
            r"segment 1 \(belt\): asks joint '\w+' for \d+% of",
        ),
        ("", "segment: is missing; `layflat motion show tour` shows a complete motion"),
    ],
)
def test_what_is_wrong_in_a_file_is_said_in_one_line(text: str, expected: str, tmp_path: Path) -> None:
    with pytest.raises((InputError, MachineError), match=expected) as caught:
        planned(text, tmp_path)
    assert str(caught.value).startswith(f"{tmp_path / 'mine.toml'}: ")
    assert "\n" not in str(caught.value)


def test_a_start_beyond_the_stroke(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"mine.toml: start: 70 deg is outside the working stroke of joint 'small'"):
        planned(LINE, tmp_path, head=HEAD.replace('"0 deg"]', '"70 deg"]'))
