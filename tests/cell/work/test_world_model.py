from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.cell.plan.order import Fruit
from layflat.cell.work.world_model import OcclusionModel, is_same_fruit, update_fruit

CAMERA = np.array([0.3, 0.37, 1.5])
ALONG_X = OcclusionModel(
    CAMERA, np.array([[0.0, 0.3], [0.4, 0.3], [0.7, 0.3]]), height=0.42, radius=0.05, half_height=0.1
)
SPOTS = st.tuples(st.floats(-0.1, 0.7), st.floats(0.0, 0.7))


def fruit(x: float, y: float, diameter: float = 0.06) -> Fruit:
    return Fruit(x, y, diameter, "tomato", "first")


def test_what_lies_under_a_link_is_hidden() -> None:
    # The line of sight to a fruit beyond the link, seen from the camera, passes the link's height nearer to the camera.
    share = (1.5 - 0.42) / (1.5 - 0.03)
    under = 0.37 + (0.3 - 0.37) / share
    assert ALONG_X.hides(fruit(0.2, under))
    assert not ALONG_X.hides(fruit(0.2, under + 0.2))
    assert not ALONG_X.hides(fruit(0.2, under - 0.2))


def test_what_hangs_from_the_tip_hides_what_is_under_it() -> None:
    away = OcclusionModel(
        CAMERA, np.array([[-0.5, -0.5], [-0.2, -0.2], [0.3, 0.37]]), height=0.42, radius=0.01, half_height=0.0
    )
    assert away.hides(fruit(0.3, 0.37))
    assert not away.hides(fruit(0.45, 0.37))


@given(SPOTS, st.floats(0.03, 0.05), st.floats(0.05, 0.08))
def test_of_a_larger_fruit_more_is_hidden(spot: tuple[float, float], small: float, large: float) -> None:
    if ALONG_X.hides(fruit(*spot, small)):
        assert ALONG_X.hides(fruit(*spot, large))


@given(st.lists(SPOTS, max_size=8), st.lists(SPOTS, max_size=8))
def test_the_open_is_believed_and_the_hidden_is_remembered(
    before: list[tuple[float, float]], now: list[tuple[float, float]]
) -> None:
    known, seen = [fruit(*spot) for spot in before], [fruit(*spot) for spot in now]
    found = update_fruit(known, seen, ALONG_X)
    for one in found:
        assert one in known if ALONG_X.hides(one) else one in seen
    for one in seen:
        assert (one in found) == (not ALONG_X.hides(one)) or one in known
    for one in known:
        if ALONG_X.hides(one):
            assert one in found or any(is_same_fruit(one, other) for other in found)


def test_without_the_arm_the_picture_is_all_that_counts() -> None:
    assert update_fruit([fruit(0.2, 0.3)], [fruit(0.5, 0.3)], None) == [fruit(0.5, 0.3)]


@pytest.mark.parametrize(("apart", "is_same"), [(0.01, True), (0.02, False)])
def test_two_sightings_near_one_another_are_of_one_fruit(apart: float, is_same: bool) -> None:
    assert is_same_fruit(fruit(0.2, 0.3), fruit(0.2 + apart, 0.3)) is is_same
