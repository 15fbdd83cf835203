import pytest

from layflat.cli.moves import timed
from layflat.errors import InputError

STILL: dict[str, str | float] = {"large": 0.0, "small": 0.0}


def test_nothing_given_is_the_first_value_throughout() -> None:
    assert timed([], STILL, "x") == [(0.0, STILL)]


def test_one_value_is_for_all_joints() -> None:
    assert timed(["40 deg"], STILL, "x") == [(0.0, {"large": "40 deg", "small": "40 deg"})]


def test_values_in_order_of_joints() -> None:
    assert timed(["40 deg, 20 deg @ 1 s"], STILL, "x")[1:] == [(1.0, {"large": "40 deg", "small": "20 deg"})]


def test_until_its_time_the_first_value_holds() -> None:
    assert timed(["0 bar @ 1 s"], {"supply": 4e5}, "x") == [(0.0, {"supply": 4e5}), (1.0, {"supply": "0 bar"})]


def test_a_joint_that_is_not_named_keeps_its_value() -> None:
    steps = timed(["small=20 deg @ 2 s", "large=40 deg"], {"large": 0.0, "small": "5 deg"}, "x")
    assert steps == [(0.0, {"large": "40 deg", "small": "5 deg"}), (2.0, {"large": "40 deg", "small": "20 deg"})]


def test_two_at_one_time_are_one_step() -> None:
    assert timed(["small=1 deg", "large=2 deg"], STILL, "x") == [(0.0, {"large": "2 deg", "small": "1 deg"})]


def test_bare_numbers_where_there_is_no_unit() -> None:
    assert timed(["0.5"], STILL, "x", bare=True) == [(0.0, {"large": 0.5, "small": 0.5})]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("elbow=1 deg", "unknown joint 'elbow'"),
        ("1 deg @ -1 s", "before the start"),
        ("1, 2, 3", "has 3 values; give 2"),
    ],
)
def test_mistakes(text: str, expected: str) -> None:
    with pytest.raises(InputError, match=expected):
        timed([text], STILL, "--move")
