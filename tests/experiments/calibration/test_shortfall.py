"""What made-up joints lack."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from layflat.experiments.calibration import shortfall as s
from layflat.experiments.calibration.evidence import BACK, CAREFUL, WATCHED, Carried, Steps
from layflat.experiments.calibration.evidence import carried as came_to
from layflat.experiments.limits import STEP
from layflat.experiments.two_axis import END, FIRST, HALF, SECOND
from layflat.sim.metrics import BAND

CYCLE = 0.005
RATIOS, EARLIER = np.geomspace(1e-2, 1e-1, 11), np.geomspace(1e-2, 4e-2, 8)
Floats = NDArray[np.float64]
TIME = CYCLE * np.arange(round(WATCHED / CYCLE))


def arrives(after: float, swings: float = 0.0) -> Floats:
    """Errors of a joint that comes to its demand after so many seconds, and goes on swinging by so many degrees."""
    return np.where(after > TIME, -STEP, np.radians(swings) * np.sin(8.0 * TIME))


def unbraked(until: float) -> Floats:
    return np.where(TIME < 0.4, -STEP, np.radians(np.where(until > TIME, 4.0, 0.2)) * np.sin(8.0 * TIME))


def carried(limit: float, ratios: Floats = RATIOS, arrival: float = 1.0) -> Carried:
    """What comes of each inertia; one of its runs goes wrong by bad luck."""
    each = [
        [arrives(arrival, 0.0 if ratio <= limit else 3.0)] * (CAREFUL.repeats - 1) + [arrives(2.5)] for ratio in ratios
    ]
    return came_to(np.concatenate(each)[None], ratios, CYCLE)


def alone(after: float, swings: float = 0.0) -> Carried:
    return came_to(arrives(after, swings)[None, None], np.zeros(1), CYCLE)


def steps(**changes: Any) -> Steps:
    right: dict[str, Any] = {
        "unbraked": np.array([[unbraked(4.0), unbraked(4.5)]]),
        "braked": alone(1.0),
        "carried_braked": carried(0.036),
        "carried_earlier": carried(0.018, EARLIER),
    }
    return Steps(CYCLE, **{**right, **changes})


def test_a_joint_has_settled_where_it_stays_for_a_second() -> None:
    assert s.settled(arrives(1.0), BAND, CYCLE) == pytest.approx(1.0)
    assert s.settled(arrives(0.0), BAND, CYCLE) == 0.0
    assert s.settled(arrives(1.0, 1.0), BAND, CYCLE) == np.inf
    assert s.settled(arrives(WATCHED - 0.9), BAND, CYCLE) == np.inf


def test_machines_that_do_what_the_paper_says_lack_nothing() -> None:
    found = s.axis_one(steps())
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
    found = s.axis_one(steps(**changes))
    assert found[lacks][0] > 0.05


def test_limits_lack_less_the_nearer_they_are() -> None:
    by_limit = [
        s.axis_one(steps(carried_braked=carried(at)))["limits are not as one to two"][0] for at in (0.036, 0.05, 0.08)
    ]
    assert by_limit == sorted(by_limit)
    assert by_limit[0] < by_limit[2]


def arm(late: float = 0.8, pushed: float = 1.0, apart: float = 0.0) -> Floats:
    """Angles of an arm that makes both steps after so many seconds; the small joint's pushes the large one (deg)."""
    time = CYCLE * np.arange(round(BACK / CYCLE))
    large = np.where(time < FIRST + late, -HALF, HALF) + np.radians(pushed) * ((time > SECOND) & (time < SECOND + 0.3))
    small = np.where(time < SECOND + late, -HALF, HALF) + np.radians(10.0) * ((time > FIRST) & (time < FIRST + 0.3))
    both = np.where(time[:, None] < END + 0.8, np.stack([large, small], axis=-1), np.radians(apart) / 2)
    return np.repeat(both[None, None], 2, axis=1)


def test_an_arm_settles_and_is_pushed_little() -> None:
    assert all(lack[0] == 0.0 for lack in s.two_axes(arm(), CYCLE).values())
    assert s.two_axes(arm(late=2.0), CYCLE)["arm settles too late"][0] > 0.5
    assert s.two_axes(arm(pushed=6.0), CYCLE)["large joint is pushed"][0] > 0.5
    assert s.two_axes(1.2 * arm(), CYCLE)["arm overshoots"][0] == pytest.approx(0.2)
    assert s.two_axes(arm(apart=0.3), CYCLE)["arm does not come back"][0] == pytest.approx(0.9)


def test_dither_shows_or_not() -> None:
    lacks = s.dither(np.array([[800.0, 700.0], [300.0, 700.0]]))["dither does not show in the pressure"]
    assert lacks == pytest.approx([0.0, 0.5 * np.log(2.0)])
