"""What made-up joints lack."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from layflat.experiments.axis_one import STEP
from layflat.experiments.two_axis import END_TIME, HALF_STEP, LARGE_STEP_TIME, SMALL_STEP_TIME
from layflat.sim.metrics import SETTLING_BAND
from research.calibration import shortfall as s
from research.calibration.effort import CLAIM_EFFORT
from research.calibration.steps import RECORDED_TIME, InertiaSteps, PaperSteps, StepResponses
from research.calibration.steps import evaluate_responses as came_to

CYCLE = 0.005
RUNS = ("time", "swing", "late")
RATIOS, EARLIER = np.geomspace(1e-2, 1e-1, 11), np.geomspace(1e-2, 4e-2, 8)
Floats = NDArray[np.float64]
TIME = CYCLE * np.arange(round(RECORDED_TIME / CYCLE))


def arrives(after: float, swings: float = 0.0) -> Floats:
    """Errors of a joint that comes to its demand after so many seconds, and goes on swinging by so many degrees."""
    return np.where(after > TIME, -STEP, np.radians(swings) * np.sin(8.0 * TIME))


def unbraked(until: float) -> Floats:
    return np.where(TIME < 0.4, -STEP, np.radians(np.where(until > TIME, 4.0, 0.2)) * np.sin(8.0 * TIME))


def carried(limit: float, ratios: Floats = RATIOS, arrival: float = 1.0) -> StepResponses:
    """What comes of each inertia; one of its runs goes wrong by bad luck."""
    each = [
        [arrives(arrival, 0.0 if ratio <= limit else 3.0)] * (CLAIM_EFFORT.repeats - 1) + [arrives(2.5)]
        for ratio in ratios
    ]
    return came_to(np.concatenate(each)[None], ratios, CYCLE)


def alone(after: float, swings: float = 0.0) -> StepResponses:
    return came_to(arrives(after, swings)[None, None], np.zeros(1), CYCLE)


def all_of(**changes: Any) -> dict[str, Floats]:
    """What joints lack that do as the paper says, but for some changes."""
    right: dict[str, Any] = {
        "unbraked": np.array([[unbraked(4.0), unbraked(4.5)]]),
        "braked": alone(1.0),
        "carried_braked": carried(0.036),
        "carried_earlier": carried(0.018, EARLIER),
    }
    now = {**right, **changes}
    first = replace(now["carried_earlier"], **{key: getattr(now["carried_earlier"], key)[:, :1] for key in RUNS})
    fig_13 = PaperSteps(CYCLE, now["unbraked"], now["braked"], first)
    return s.compared(fig_13) | s.loaded(InertiaSteps(CYCLE, now["carried_braked"], now["carried_earlier"]))


def test_a_joint_has_settled_where_it_stays_for_a_second() -> None:
    assert s.settled(arrives(1.0), SETTLING_BAND, CYCLE) == pytest.approx(1.0)
    assert s.settled(arrives(0.0), SETTLING_BAND, CYCLE) == 0.0
    assert s.settled(arrives(1.0, 1.0), SETTLING_BAND, CYCLE) == np.inf
    assert s.settled(arrives(RECORDED_TIME - 0.9), SETTLING_BAND, CYCLE) == np.inf


def test_machines_that_do_what_the_paper_says_lack_nothing() -> None:
    found = all_of()
    assert {name: float(lack[0]) for name, lack in found.items() if lack[0] > 1e-9} == {}
    assert s.small_motions(np.array([0.5]))["earlier actuator opposes small motions too much"][0] == 0.0


@pytest.mark.parametrize(
    ("lacks", "changes"),
    [
        ("unbraked joint arrives too soon", {"unbraked": np.array([[unbraked(1.0)] * 2])}),
        ("unbraked joint arrives too late", {"unbraked": np.array([[unbraked(8.5)] * 2])}),
        ("unbraked joint swings on", {"unbraked": np.array([[unbraked(20.0)] * 2])}),
        ("unbraked joint overshoots", {"unbraked": np.array([[6.0 * unbraked(4.0)] * 2])}),
        ("earlier actuator settles too late", {"carried_earlier": carried(0.018, EARLIER, 3.0)}),
        ("braked joint settles too late", {"braked": alone(1.0, 2.0)}),
        ("limits are not as one to two", {"carried_braked": carried(0.0165)}),
        ("limits are not as one to two", {"carried_earlier": carried(0.09, EARLIER), "carried_braked": carried(0.09)}),
    ],
)
def test_what_a_machine_lacks_is_named(lacks: str, changes: dict[str, Any]) -> None:
    found = all_of(**changes)
    assert found[lacks][0] > 0.05


def test_an_earlier_actuator_that_is_nearly_late_with_the_least_inertia_has_nearly_no_limit() -> None:
    prompt, late = (all_of(carried_earlier=carried(0.018, EARLIER, after)) for after in (1.3, 1.45))
    assert prompt["limits are not as one to two"][0] == 0.0
    assert late["limits are not as one to two"][0] > 0.15


def test_limits_lack_less_the_nearer_they_are() -> None:
    by_limit = [all_of(carried_braked=carried(at))["limits are not as one to two"][0] for at in (0.036, 0.05, 0.08)]
    assert by_limit == sorted(by_limit)
    assert by_limit[0] < by_limit[2]


def arm(late: float = 0.8, pushed: float = 1.0) -> Floats:
    """Angles of an arm that makes both steps after so many seconds; the small joint's pushes the large one (deg)."""
    time = CYCLE * np.arange(round(END_TIME / CYCLE))
    large = np.where(time < LARGE_STEP_TIME + late, -HALF_STEP, HALF_STEP) + np.radians(pushed) * (
        (time > SMALL_STEP_TIME) & (time < SMALL_STEP_TIME + 0.3)
    )
    small = np.where(time < SMALL_STEP_TIME + late, -HALF_STEP, HALF_STEP) + np.radians(10.0) * (
        (time > LARGE_STEP_TIME) & (time < LARGE_STEP_TIME + 0.3)
    )
    return np.repeat(np.stack([large, small], axis=-1)[None, None], 2, axis=1)


def test_an_arm_settles_and_is_pushed_little() -> None:
    assert all(lack[0] == 0.0 for lack in s.two_axes(arm(), CYCLE).values())
    assert s.two_axes(arm(late=2.0), CYCLE)["arm settles too late"][0] > 0.5
    assert s.two_axes(arm(pushed=6.0), CYCLE)["large joint is pushed"][0] > 0.5
    assert s.two_axes(1.2 * arm(), CYCLE)["arm overshoots"][0] == pytest.approx(0.6)


def test_an_arm_comes_back_to_one_place() -> None:
    rests = np.radians([[[0.0, 0.1], [0.05, 0.2]], [[0.0, 0.1], [0.05, 0.46]]])
    assert s.comes_back(rests)["arm does not come back"] == pytest.approx([0.0, 1.0])


def test_a_long_term_integral_takes_over_all_of_a_drift() -> None:
    lacks = s.drift(np.array([1.0, 0.7, 1.2]))["long-term integral does not learn a drift"]
    assert lacks == pytest.approx([0.0, 2.2, 1.2])


def test_what_friction_holds_between_two_phases_is_short_of_its_goal() -> None:
    gains = {"far.error": 10.0, "far.pressure": 2e-5, "near.error": 10.0, "near.pressure": 1e-5}
    borders = {"near_below.error": 0.1, "close_below.error": np.array([0.1, 0.01])}
    values = {f"joint.small.gains.{key}": np.full(2, value) for key, value in (gains | borders).items()}
    lacks = s.held_short(values, {"small": 0.4e5})["joint is held short of its goal"]
    assert lacks == pytest.approx([0.0, np.log(1.2 * 0.4e5 / 0.1e5)])


def test_heights_and_gains_lie_within_what_the_paper_says() -> None:
    lacks = s.open_loop(np.array([[0.25, 0.07, 0.25], [0.28, 0.07, 0.25]]))["hysteresis is not the paper's"]
    assert lacks == pytest.approx([0.0, 0.65])
    assert s.spool(np.array([1.1, 1.0]))["a fast dither moves the spool as well"] == pytest.approx([0.0, 0.6])


def test_dither_shows_or_not() -> None:
    lacks = s.dither(np.array([[800.0, 700.0], [300.0, 700.0]]))["dither does not show in the pressure"]
    assert lacks == pytest.approx([0.0, 0.5 * np.log(2.0)])
