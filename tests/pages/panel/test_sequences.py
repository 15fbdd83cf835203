"""Sequences come back as they were saved, and nonsense is one line."""

import os
from math import degrees, radians
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.errors import LayflatError
from layflat.machine import load
from layflat.pages.panel.moves import (
    MAX_LISTED,
    MAX_STEPS,
    SequenceStep,
    load_sequence,
    newest_names,
    read_target,
    save_sequence,
    sequence_file,
)

ARM = load("paper-arm")
HALF = degrees(ARM.joint["small"].stops.working_stroke) / 2


@given(st.lists(st.tuples(st.floats(-0.9, 0.9), st.floats(-0.9, 0.9), st.floats(0.0, 9.0)), min_size=1, max_size=5))
def test_a_sequence_comes_back(
    tmp_path_factory: pytest.TempPathFactory, rows: list[tuple[float, float, float]]
) -> None:
    folder = tmp_path_factory.mktemp("saved")
    steps = [SequenceStep((a, b), pause) for a, b, pause in rows]
    save_sequence(folder, "to and fro", ARM, steps)
    assert newest_names(folder)[0] == ["to and fro"]
    for found, step in zip(load_sequence(folder, "to and fro", ARM), steps, strict=True):
        assert found.angles == pytest.approx(step.angles, abs=radians(1e-3))
        assert found.pause == pytest.approx(step.pause, abs=1e-3)


GRIPS = ARM.model_copy(update={"interface": ARM.interface.model_copy(update={"outputs": ("gripper", "lamp")})})


def test_outputs_of_steps_come_back_and_others_are_refused(tmp_path: Path) -> None:
    steps = [SequenceStep((0.1, 0.2), 0.5, outputs) for outputs in (frozenset({"gripper"}), frozenset[str](), None)]
    save_sequence(tmp_path, "grip", GRIPS, steps)
    assert [step.outputs for step in load_sequence(tmp_path, "grip", GRIPS)] == [step.outputs for step in steps]
    with pytest.raises(LayflatError, match=r"step 1: outputs: .*leave them out: the machine has none"):
        load_sequence(tmp_path, "grip", ARM)


@pytest.mark.parametrize(
    "name", ["", "../elsewhere", "a/b", ".hidden", "x" * 101, "nul\0", "CON", "aux", "nul.txt", "Com1"]
)
def test_names_stay_in_the_folder(tmp_path: Path, name: str) -> None:
    with pytest.raises(LayflatError, match=r"is empty|can't be a name|is reserved by some systems|more than 100 bytes"):
        sequence_file(tmp_path, name)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("no toml = = =", "can't be read"),
        ('machine = "paper-arm"', "holds no steps"),
        ('[[step]]\nangles = {large = "1 deg"}', "one angle for each joint"),
        ('[[step]]\nangles = {large = "1 deg", small = "200 deg"}', "outside the working stroke"),
        ('[[step]]\nangles = {large = "1 kg", small = "0 deg"}', "step 1: large"),
        ('[[step]]\npause = "-1 s"\nangles = {large = "1 deg", small = "0 deg"}', "pause"),
        ("step = [3]", "one angle for each joint"),
    ],
)
def test_nonsense_is_named(tmp_path: Path, text: str, words: str) -> None:
    sequence_file(tmp_path, "one").write_text(text)
    with pytest.raises(LayflatError, match=words) as raised:
        load_sequence(tmp_path, "one", ARM)
    assert "one.sequence.toml" in str(raised.value)


def test_a_sequence_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(LayflatError, match="can't be read"):
        load_sequence(tmp_path, "none", ARM)


def test_targets_are_inside_the_stroke() -> None:
    assert read_target(ARM, {"large": 10.0, "small": -HALF}) == pytest.approx((radians(10.0), radians(-HALF)))
    with pytest.raises(LayflatError, match="outside the working stroke"):
        read_target(ARM, {"large": 10.0, "small": HALF + 1.0})
    with pytest.raises(LayflatError, match="lacks an angle"):
        read_target(ARM, {"large": 10.0, "small": None})


def test_a_sequence_that_could_not_be_loaded_is_not_written(tmp_path: Path) -> None:
    steps = [SequenceStep(tuple(0.1 for _ in ARM.joints))] * MAX_STEPS
    save_sequence(tmp_path, "long", ARM, steps)
    assert len(load_sequence(tmp_path, "long", ARM)) == MAX_STEPS
    with pytest.raises(LayflatError, match=f"long: has {MAX_STEPS + 1} steps; give 1 to {MAX_STEPS}"):
        save_sequence(tmp_path, "long", ARM, [*steps, steps[0]])
    with pytest.raises(LayflatError, match=f"long: has 0 steps; give 1 to {MAX_STEPS}"):
        save_sequence(tmp_path, "long", ARM, [])
    assert len(load_sequence(tmp_path, "long", ARM)) == MAX_STEPS


def test_of_many_sequences_the_newest_are_offered(tmp_path: Path) -> None:
    for number in range(MAX_LISTED + 7):
        path = tmp_path / f"s{number:04d}.sequence.toml"
        path.touch()
        os.utime(path, (number, number))
    names, older = newest_names(tmp_path)
    assert (len(names), older) == (MAX_LISTED, 7)
    assert names == sorted(names)
    assert "s0006" not in names
