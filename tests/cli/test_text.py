import pytest

from layflat.cli.text import signal, timed
from layflat.errors import InputError

NAMES = ["large", "small"]


def test_one_value_is_for_all_joints() -> None:
    assert timed(["40 deg"], NAMES, "x") == [(0.0, {"large": "40 deg", "small": "40 deg"})]


def test_values_in_order_of_joints() -> None:
    assert timed(["40 deg, 20 deg @ 1 s"], NAMES, "x") == [(1.0, {"large": "40 deg", "small": "20 deg"})]


def test_a_joint_that_is_not_named_keeps_its_value() -> None:
    steps = timed(["small=20 deg @ 2 s", "large=40 deg"], NAMES, "x")
    assert steps == [(0.0, {"large": "40 deg", "small": 0.0}), (2.0, {"large": "40 deg", "small": "20 deg"})]


def test_two_at_one_time_are_one_step() -> None:
    assert timed(["small=1 deg", "large=2 deg"], NAMES, "x") == [(0.0, {"large": "2 deg", "small": "1 deg"})]


def test_nothing_given_is_no_signal() -> None:
    assert signal(None, NAMES, "x") is None
    assert signal([], NAMES, "x") is None


@pytest.mark.parametrize(
    ("text", "expected"),
    [("elbow=1 deg", "'elbow' is no joint"), ("1 deg @ -1 s", "before the start"), ("1, 2, 3", "has 3 values; give 2")],
)
def test_mistakes(text: str, expected: str) -> None:
    with pytest.raises(InputError, match=expected):
        timed([text], NAMES, "--move")
