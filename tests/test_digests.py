"""Digests of results: what counts as the same, and what is said of what differs."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from benchmarks.digests import compare

floats = arrays(np.float64, array_shapes(max_dims=2, max_side=4))


def of(**items: dict[str, Any]) -> tuple[compare.Content, dict[str, np.ndarray]]:
    """A file's content and its arrays."""
    values = {f"{item}/{key}": compare.array(value) for item, own in items.items() for key, value in own.items()}
    digests = {item: {key: compare.digest(values[f"{item}/{key}"]) for key in own} for item, own in items.items()}
    return {"items": {item: {"arrays": own} for item, own in digests.items()}}, values


def told(here: tuple[Any, Any], there: tuple[Any, Any]) -> dict[str, tuple[bool, str]]:
    return compare.differences(here[0], there[0], here[1], there[1])


@given(floats, floats)
def test_digests_are_equal_where_every_bit_is(one: np.ndarray, other: np.ndarray) -> None:
    first, second = compare.array(one), compare.array(other)
    same = first.shape == second.shape and first.tobytes() == second.tobytes()
    assert (compare.digest(first) == compare.digest(second)) == same
    assert compare.digest(first) == compare.digest(compare.array(one.copy(order="F")))


def test_all_nans_are_alike_but_zeros_have_signs() -> None:
    assert compare.digest(compare.array([np.nan, 1.0])) == compare.digest(compare.array([-np.nan, 1.0]))
    assert compare.digest(compare.array([0.0])) != compare.digest(compare.array([-0.0]))
    assert compare.digest(compare.array([1.0])) != compare.digest(compare.array([[1.0]]))


@given(st.dictionaries(st.text("abc"), st.text("abc"), min_size=1))
def test_the_short_digest_depends_on_names_and_not_on_their_order(digests: dict[str, str]) -> None:
    assert compare.overall(digests) == compare.overall(dict(reversed(digests.items())))
    name = next(iter(digests))
    assert compare.overall(digests) != compare.overall({**digests, name: digests[name] + "x"})
    assert compare.overall(digests) != compare.overall({**digests, "".join(digests) + "x": ""})


def test_what_is_the_same_new_or_missing() -> None:
    here = of(both={"a": [1.0], "b": [2.0]}, new={"a": [1.0]}, more={"a": [1.0], "b": [1.0]}, fewer={"a": [1.0]})
    there = of(both={"a": [1.0], "b": [2.0]}, gone={"a": [1.0]}, more={"a": [1.0]}, fewer={"a": [1.0], "c": [1.0]})
    assert told(here, there) == {
        "both": (True, "same"),
        "gone": (False, "missing here"),
        "more": (True, "same, 1 new"),
        "fewer": (False, "1 of 2 missing here, first 'c'"),
        "new": (True, "new, nothing to compare with"),
    }


@pytest.mark.parametrize(
    ("here", "expected"),
    [
        ([0.0, 1.0, 2.0 + 2e-3], "1 of 2 differ, first 'a'; most by 0.001 of its range, 'a'"),
        ([0.0, 1.0], "most by inf of its range"),
        ([0.0, np.nan, 2.0], "most by inf of its range"),
        ([-0.0, 1.0, 2.0], "most by 0 of its range"),
    ],
)
def test_what_differs_is_told_with_its_size(here: list[float], expected: str) -> None:
    same, text = told(of(item={"a": here, "b": [5.0]}), of(item={"a": [0.0, 1.0, 2.0], "b": [5.0]}))["item"]
    assert not same
    assert expected in text


@pytest.mark.parametrize(
    ("here", "there", "same", "text"),
    [
        ({"error": "no such law"}, {"arrays": {}}, False, "error here: no such law"),
        ({"arrays": {}}, {"error": "no such law"}, False, "error there: no such law"),
        ({"error": "a"}, {"error": "b"}, False, "error here and there: b"),
        ({"skipped": "no OpenGL"}, {"skipped": "no OpenGL"}, True, "skipped here and there: no OpenGL"),
        ({"skipped": "no OpenGL"}, {"arrays": {}}, False, "skipped here: no OpenGL"),
    ],
)
def test_what_failed_or_was_skipped(here: compare.Content, there: compare.Content, same: bool, text: str) -> None:
    assert compare.differences({"items": {"x": here}}, {"items": {"x": there}}, {}, {}) == {"x": (same, text)}


def test_from_the_command_line_to_a_file_and_against_it(tmp_path: Path) -> None:
    out = tmp_path / "digests.json"
    command = [sys.executable, "-m", "benchmarks.digests", "--only", "sweeps", "--out", str(out)]
    root = Path(__file__).parents[1]
    assert subprocess.run(command, cwd=root, capture_output=True, check=False).returncode == 0
    content, arrays_there = compare.stored(out)
    assert list(content["items"]) == ["sweeps"]
    key = "rig-kevlar small: torque"
    assert compare.digest(arrays_there[f"sweeps/{key}"]) == content["items"]["sweeps"]["arrays"][key]
    content["items"]["sweeps"]["arrays"][key] = ""
    spoilt = tmp_path / "spoilt.json"
    spoilt.write_text(json.dumps(content))
    spoilt.with_suffix(".npz").write_bytes(out.with_suffix(".npz").read_bytes())
    done = subprocess.run([*command, "--against", str(spoilt)], cwd=root, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert f"first '{key}'" in done.stdout
    assert "1 of 1 items differ" in done.stdout
