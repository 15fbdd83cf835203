import pytest

from layflat.cli.moves import parse_row, parse_steps
from layflat.errors import InputError

NAMES = ["large", "small"]


def test_nothing_given_is_no_step() -> None:
    assert parse_steps([], NAMES, "x") == []


def test_one_value_is_for_all_joints() -> None:
    assert parse_steps(["40 deg"], NAMES, "x") == [(0.0, {"large": "40 deg", "small": "40 deg"})]


def test_values_in_order_of_joints() -> None:
    assert parse_steps(["40 deg, 20 deg @ 1 s"], NAMES, "x") == [(1.0, {"large": "40 deg", "small": "20 deg"})]


def test_a_step_names_what_its_text_names() -> None:
    steps = parse_steps(["small=20 deg @ 2 s", "large=40 deg"], NAMES, "x")
    assert steps == [(0.0, {"large": "40 deg"}), (2.0, {"small": "20 deg"})]


def test_two_at_one_time_are_one_step() -> None:
    assert parse_steps(["small=1 deg", "large=2 deg"], NAMES, "x") == [(0.0, {"large": "2 deg", "small": "1 deg"})]


def test_bare_numbers_where_there_is_no_unit() -> None:
    assert parse_steps(["0.5"], NAMES, "x", bare=True) == [(0.0, {"large": 0.5, "small": 0.5})]


def test_a_start_has_no_time() -> None:
    assert parse_row("large=1 deg", NAMES, "--start") == {"large": "1 deg"}
    with pytest.raises(InputError, match="--start: '1 deg @ 2 s' has a time; give angles alone"):
        parse_row("1 deg @ 2 s", NAMES, "--start")


@pytest.mark.parametrize(
    ("texts", "expected"),
    [
        (["elbow=1 deg"], "unknown joint 'elbow'"),
        (["1 deg @ -1 s"], "before the start"),
        (["1, 2, 3"], "has 3 values; give 2"),
        (["large=1 deg, large=2 deg"], "'large' is given twice in 'large=1 deg, large=2 deg'; give it once"),
        (["large=1 deg @ 1 s", "large=2 deg @ 1 s"], "'large' is given twice at 1 s; give it once, or at another time"),
        (["1 deg", "small=2 deg"], "'small' is given twice at 0 s"),
        (["4,5 deg"], "'4,5 deg' has a comma in its number; write \"4.5 deg\""),
        (["large=-4,25 deg @ 1 s"], 'has a comma in its number; write "large=-4.25 deg"'),
    ],
)
def test_mistakes(texts: list[str], expected: str) -> None:
    with pytest.raises(InputError, match=expected):
        parse_steps(texts, NAMES, "--move")


def test_a_decimal_comma_of_a_value_that_all_share_is_named() -> None:
    with pytest.raises(InputError, match=r"--supply: '4,5 bar' has a comma in its number; write \"4\.5 bar\""):
        parse_steps(["4,5 bar"], ["supply"], "--supply", of="value")
    assert parse_steps(["1 deg, 2 deg"], NAMES, "--move") == [(0.0, {"large": "1 deg", "small": "2 deg"})]
    assert parse_steps(["0.1,0"], NAMES, "--opening", bare=True) == [(0.0, {"large": 0.1, "small": 0.0})]
