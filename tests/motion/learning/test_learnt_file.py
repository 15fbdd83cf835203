"""What was learnt as a file: it comes back whole, and is refused for any other motion or machine."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from layflat.errors import InputError
from layflat.machine import changed, load
from layflat.motion.demand_file import read_demand, write_demand
from layflat.motion.learning import LearntCorrections, begin_learning
from layflat.motion.learning.file import read_learnt, write_learnt

ARM = load("paper-arm-tracking")


def motion(size: float = 0.3) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    u = np.linspace(0.0, 1.0, 61)[:, None] * [1.0, -1.0]
    s = size * np.sign(u) * np.abs(u) ** 3 * (10.0 - 15.0 * np.abs(u) + 6.0 * u**2)
    v = np.gradient(s, ARM.cycle, axis=0)
    return s, v, np.gradient(v, ARM.cycle, axis=0)


@pytest.fixture
def learnt() -> LearntCorrections:
    learnt = begin_learning(ARM, motion())
    for cycles in (3, 2, 4):
        learnt = learnt.learn_from(np.roll(learnt.demand().angles, cycles, axis=0))
    return learnt


def test_it_comes_back_whole(learnt: LearntCorrections, tmp_path: Path) -> None:
    path = write_learnt(learnt, tmp_path / "move.learnt")
    read = read_learnt(path, ARM, learnt.motion)
    assert read.history == learnt.history
    assert read.filter == learnt.filter
    for name in ("sent", "best", "step"):
        assert np.array_equal(getattr(read, name), getattr(learnt, name))
    assert [entry.name for entry in tmp_path.iterdir()] == ["move.learnt"]
    again = np.roll(learnt.demand().angles, 1, axis=0)
    assert np.array_equal(read.learn_from(again).sent, learnt.learn_from(again).sent)
    assert path.read_text() == write_learnt(read, tmp_path / "again.learnt").read_text()


def test_a_motion_is_the_same_after_a_demand_file(tmp_path: Path) -> None:
    q, v, a = motion()
    time = ARM.cycle * np.arange(len(q), dtype=np.float64)
    path = write_demand(ARM, time, q, tmp_path / "move.csv", velocity=v, acceleration=a)
    first = begin_learning(ARM, read_demand(ARM, path, ARM.cycle)).motion.fingerprint
    assert first == begin_learning(ARM, read_demand(ARM, path, ARM.cycle)).motion.fingerprint


def test_another_machine_or_motion_is_refused(learnt: LearntCorrections, tmp_path: Path) -> None:
    path = write_learnt(learnt, tmp_path / "move.learnt")
    other = load("paper-arm-fast-tuned")
    with pytest.raises(InputError, match="was learnt with another machine, 'paper-arm-tracking'; give that machine"):
        read_learnt(path, other)
    heavier = changed(ARM, "arm.payload", "1.6 kg")
    with pytest.raises(InputError, match="was learnt with another description of paper-arm-tracking; give"):
        read_learnt(path, heavier)
    with pytest.raises(InputError, match="was learnt for another motion; give that motion, or learn anew"):
        read_learnt(path, ARM, begin_learning(ARM, motion(0.31)).motion)


def put(*keys: str, value: Any) -> Callable[[dict[str, Any]], None]:
    def change(content: dict[str, Any]) -> None:
        for key in keys[:-1]:
            content = content[key]
        content[keys[-1]] = value

    return change


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (put("format", value="another"), "its format is not 'layflat learnt motion, version 1'"),
        (put("correction", "next", "large", value=[0.0]), "can't be read as learnt corrections"),
        (put("correction", "best", value={"large": [0.0] * 9, "small": [0.0] * 9}), "does not fit the motion"),
        (put("correction", "step", "small", value="none"), "can't be read as learnt corrections"),
        (put("motion", "angles", "small", value=[0.1] * 61), "holds a motion that was changed; learn anew"),
        (put("history", value=[{"rms": 1.0}]), "can't be read as learnt corrections"),
        (put("filter", "lead", value="soon"), "can't be read as learnt corrections"),
        (put("filter", "smoothing", value=0.0), "can't be read as learnt corrections"),
        (put("gain", value=None), "can't be read as learnt corrections"),
    ],
)
def test_bad_files_are_refused(
    change: Callable[[dict[str, Any]], None], expected: str, learnt: LearntCorrections, tmp_path: Path
) -> None:
    path = write_learnt(learnt, tmp_path / "move.learnt")
    content = json.loads(path.read_text())
    change(content)
    path.write_text(json.dumps(content), encoding="utf-8")
    with pytest.raises(InputError, match=expected) as refusal:
        read_learnt(path, ARM)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("text", ["", "[]", "{", "\x00\xff"])
def test_what_is_no_such_file_is_refused(text: str, tmp_path: Path) -> None:
    path = tmp_path / "no.learnt"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match="give a file that `layflat motion learn` has written"):
        read_learnt(path, ARM)
