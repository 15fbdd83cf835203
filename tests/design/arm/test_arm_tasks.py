"""Tasks of arms: what a file and options say, and one line for what is wrong in them."""

from math import radians
from pathlib import Path
from typing import Any

import pytest
from numpy.testing import assert_allclose

from layflat.design.arm import TASK_LIBRARY, read_task
from layflat.design.arm.sizing import size_arm
from layflat.design.arm.task import STANDARD_CHAINS
from layflat.errors import DesignError

USUAL = {"payload": "1 kg", "supply": "6 bar", "time": "1 s"}
REACH: dict[str, Any] = USUAL | {"reach": "0.8 m"}
SLIDE = """
name = "swing"
title = "One upright joint"
payload = "0.5 kg"
supply = "4 bar"
acceleration = "3 m/s^2"

[[joint]]
name = "post"
axis = [0, 0, 2]
stroke = "90 deg"
link = ["0.3 m", "0 m", "0 m"]
"""


def written(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "task.toml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("name", TASK_LIBRARY.names)
def test_built_in_tasks_say_what_they_are(name: str) -> None:
    task = read_task(name)
    assert (task.name, bool(task.title)) == (name, True)


@pytest.mark.parametrize("count", STANDARD_CHAINS)
def test_links_of_a_standard_arm_come_to_its_reach(count: int) -> None:
    chain = read_task(**REACH, joints=count).chain
    assert len(chain) == count
    assert sum(joint.link[0] for joint in chain) == pytest.approx(0.8)


def test_a_file_says_any_chain(tmp_path: Path) -> None:
    task = read_task(written(tmp_path, SLIDE))
    assert [joint.name for joint in task.chain] == ["post"]
    assert task.chain[0].stroke == pytest.approx(radians(90.0))
    assert task.time is None


def test_options_stand_over_the_file(tmp_path: Path) -> None:
    path = written(tmp_path, SLIDE)
    quicker = read_task(path, time="0.5 s", supply="6 bar", payload=None)
    assert (quicker.time, quicker.acceleration, quicker.payload) == (0.5, None, 0.5)
    assert quicker.supply == pytest.approx(6e5)
    there = read_task("picking-arm", points=[["0.5 m", "0 m", "0.2 m"], ["0.4 m", "0.1 m", "0.3 m"]])
    assert_allclose(there.points, [(0.5, 0.0, 0.2), (0.4, 0.1, 0.3)])


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({}, "task: payload: is missing; docs/sizing-arms.md shows a complete task"),
        (USUAL, "needs reach, of a standard arm, or [[joint]] tables; give one of them"),
        (REACH | {"reach": "0.8"}, "task: reach: '0.8' is a bare number; give a length such as"),
        (REACH | {"reach": "8 kg"}, "task: reach: '8 kg' is not a length"),
        (REACH | {"payload": "-1 kg"}, "task: payload: '-1 kg' is out of range"),
        (REACH | {"supply": "12 bar"}, "supply: '12 bar' is no pressure of such joints; give 0.5 bar to 10 bar"),
        (REACH | {"acceleration": "2 m/s^2"}, "needs time, that a move takes, or acceleration, of the tip; give one"),
        (REACH | {"joints": 5}, "joints: 5 is out of range; give at most 4"),
        (REACH | {"margin": 0.9}, "margin: 0.9 is out of range; give at least 1"),
        (REACH | {"name": "a/b"}, "name: 'a/b' can't be a name"),
        (REACH | {"rotation": "150 deg"}, "rotation is 150 deg, and no joint turns more than 120 deg; give less"),
        (REACH | {"points": [["0.5 m", "0 m", "0 m"]]}, "points has a single one, which is no move; give at least two"),
        (REACH | {"points": [["0.5 m", "0 m"]] * 2}, "points.0: has too few values; give 3"),
        (
            REACH | {"joints": 1, "configurations": [["0 deg"], ["1 deg", "2 deg"]]},
            "configuration 2 has 2 angles; give one a joint, 1",
        ),
        (
            REACH | {"joints": 1, "configurations": [["0 deg"], ["70 deg"]]},
            "configuration 2 turns joint 'lift' to 70 deg; its stroke is 60 deg either way, from the middle",
        ),
        (
            REACH | {"volume": {"low": ["1 m", "0 m", "0 m"], "high": ["0 m", "1 m", "1 m"]}},
            "volume: low must not be above high, in any of x, y and z",
        ),
    ],
)
def test_one_line_says_what_is_wrong(given: dict[str, Any], told: str) -> None:
    with pytest.raises(DesignError) as caught:
        read_task(**given)
    assert told in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        (
            "axis = [0, 0, 2]",
            "axis = [0, 0, 0]",
            "joint.0: axis has no direction; a joint that turns about z has [0, 0, 1]",
        ),
        ("axis =", "axes =", "joint.0.axes: unknown key; did you mean 'axis'?"),
        ("[[joint]]", 'reach = "1 m"\n[[joint]]', "needs reach, of a standard arm, or [[joint]] tables; give one"),
        ("[[joint]]", "joints = 3\n[[joint]]", "joints counts those of a standard arm, but [[joint]] tables are given"),
        ('"post"', '"a.b"', "joint.0.name: 'a.b' can't be a name"),
        ("acceleration =", "acceleraton =", "acceleraton: unknown key; did you mean 'acceleration'?"),
        ('"0.5 kg"', "0.5", 'payload: 0.5 is a bare number; give a mass such as "'),
    ],
)
def test_one_line_says_what_is_wrong_in_a_file(tmp_path: Path, old: str, new: str, told: str) -> None:
    path = written(tmp_path, SLIDE.replace(old, new))
    with pytest.raises(DesignError) as caught:
        read_task(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert told in str(caught.value)


def test_joints_have_names_of_their_own(tmp_path: Path) -> None:
    twice = SLIDE + SLIDE[SLIDE.index("[[joint]]") :]
    with pytest.raises(DesignError, match="two joints are called 'post'; give each a name of its own"):
        read_task(written(tmp_path, twice))


def test_an_unknown_task_is_told() -> None:
    with pytest.raises(DesignError, match="pickin-arm: no such arm task; did you mean 'picking-arm'"):
        read_task("pickin-arm")


def test_the_pages_example_is_a_task_that_arms_can_do(tmp_path: Path) -> None:
    page = Path(__file__).parents[3] / "docs" / "sizing-arms.md"
    _, _, text = page.read_text(encoding="utf-8").partition("```toml\n")
    arm = size_arm(read_task(written(tmp_path, text.partition("```")[0])))
    assert [part.task.name for part in arm.parts] == ["yaw", "shoulder", "elbow"]
    assert 0.5 < arm.mass < 2.0
