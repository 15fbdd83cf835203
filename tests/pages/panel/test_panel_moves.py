"""What moves an arm: jogs stay inside the stroke and come to rest, courses go through their places."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.arrays import Array
from layflat.machine import load
from layflat.motion.path import half_strokes
from layflat.pages.panel.moves import ARRIVAL_TIMEOUT, JogMotion, SequenceMotion, SequenceStep

ARM = load("paper-arm-tracking")
HALF = half_strokes(ARM)


class Asked:
    """A session that only notes, of an arm that follows at once."""

    def __init__(self) -> None:
        self.angles: list[Array] = []
        self.velocities: list[Array] = []
        self.outputs = 0
        self.switched: list[tuple[str, bool, Array]] = []

    def ask(self, angles: Any, velocities: Any = None, *_: Any, **__: Any) -> None:
        self.angles.append(np.array(angles))
        self.velocities.append(np.zeros(2) if velocities is None else np.array(velocities))

    def switch(self, output: str, on: bool) -> None:
        self.outputs = on
        self.switched.append((output, on, self.angles[-1]))

    def __getitem__(self, name: str) -> Any:
        if name == "outputs":
            return self.outputs
        return self.angles[-1] if name == "averaged_angle" else self.velocities[-1]


@given(st.lists(st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.integers(1, 60)), min_size=1, max_size=6))
def test_a_jog_stays_inside_the_stroke_gathers_way_smoothly_and_rests_once_released(
    wishes: list[tuple[float, float, int]],
) -> None:
    jog, asked, now = JogMotion(ARM, np.zeros(2)), Asked(), 0.0
    for large, small, looks in [*wishes, (0.0, 0.0, 60)]:
        jog.demand_velocity = np.array([large, small])
        for _ in range(looks):
            jog.send_demand(asked, asked, now)  # type: ignore[arg-type]
            now += 0.02
    angles, velocities = np.array(asked.angles), np.array(asked.velocities)
    assert (np.abs(angles) <= HALF + 1e-12).all()
    assert np.abs(np.diff(angles, axis=0)).max() <= 1.0 * 0.02 + 1e-9
    assert not velocities[-1].any()
    assert jog.is_over


def test_a_jog_has_its_speed_after_a_quarter_of_a_second() -> None:
    jog, asked = JogMotion(ARM, np.zeros(2)), Asked()
    jog.demand_velocity = np.array([0.3, 0.0])
    for k in range(20):
        jog.send_demand(asked, asked, 0.02 * k)  # type: ignore[arg-type]
    assert asked.velocities[-1][0] == pytest.approx(0.3)
    assert not asked.velocities[0].any()


def test_a_course_goes_through_its_places_and_pauses() -> None:
    steps = [SequenceStep((0.4, -0.3), 0.5), SequenceStep((-0.2, 0.1))]
    course, asked, now = SequenceMotion(ARM, np.zeros(2), steps, 0.4), Asked(), 10.0
    while not course.is_over:
        course.send_demand(asked, asked, now)  # type: ignore[arg-type]
        now += 0.02
        assert now < 20.0
    angles = np.array(asked.angles)
    for step in steps:
        assert np.abs(angles - step.angles).max(axis=1).min() < 1e-9
    assert (np.abs(angles - steps[0].angles).max(axis=1) < 1e-9).any()
    assert angles[-1] == pytest.approx(steps[-1].angles)
    assert course.rounds == 1


def test_a_course_switches_outputs_where_it_has_come_to_a_place() -> None:
    grips = ARM.model_copy(update={"interface": ARM.interface.model_copy(update={"outputs": ("gripper",)})})
    closed, opened = frozenset({"gripper"}), frozenset[str]()
    places = [((0.2, 0.0), None), ((0.3, 0.1), closed), ((0.1, 0.1), closed), ((0.0, 0.0), opened)]
    course = SequenceMotion(grips, np.zeros(2), [SequenceStep(angles, 0.1, outputs) for angles, outputs in places], 0.5)
    asked, now = Asked(), 0.0
    while not course.is_over:
        course.send_demand(asked, asked, now)  # type: ignore[arg-type]
        now += 0.02
    (first, second) = asked.switched
    assert first[:2] == ("gripper", True)
    assert first[2] == pytest.approx((0.3, 0.1))
    assert second[:2] == ("gripper", False)
    assert second[2] == pytest.approx((0.0, 0.0))


def test_a_course_switches_nothing_where_it_has_not_come() -> None:
    grips = ARM.model_copy(update={"interface": ARM.interface.model_copy(update={"outputs": ("gripper",)})})
    course, asked, now = (
        SequenceMotion(grips, np.zeros(2), [SequenceStep((0.2, 0.2), 0.0, frozenset({"gripper"}))], 1.0),
        Asked(),
        0.0,
    )
    held = {"averaged_angle": np.zeros(2), "averaged_velocity": np.zeros(2), "outputs": 0}  # something holds the arm
    while not course.is_over:
        course.send_demand(asked, held, now)  # type: ignore[arg-type]
        now += 0.02
    assert asked.switched == []


def test_a_course_again_and_again_begins_anew_and_does_not_wait_for_ever() -> None:
    course, asked, now = SequenceMotion(ARM, np.zeros(2), [SequenceStep((0.2, 0.2))], 1.0, repeats=True), Asked(), 0.0
    held = {"averaged_angle": np.zeros(2), "averaged_velocity": np.zeros(2)}  # something holds the arm
    while course.rounds < 2:
        course.send_demand(asked, held, now)  # type: ignore[arg-type]
        now += 0.02
        assert now < 2 * ARRIVAL_TIMEOUT + 5.0
    assert not course.is_over
