"""View of a sequence: entered pauses."""

from types import SimpleNamespace
from typing import Any

import pytest

from layflat.errors import InputError
from layflat.pages.panel.moves import MAX_PAUSE, check_pause
from layflat.pages.panel.sequence_view import SequenceView


def message(entered: Any) -> str:
    """What the page tells after "Add present angles" with an entered pause, without a rig."""
    told: list[str] = []
    view: Any = object.__new__(SequenceView)
    view._desk, view.steps = SimpleNamespace(snapshot=lambda: None), []
    view.pause, view.status = SimpleNamespace(value=entered), SimpleNamespace(set_text=told.append)
    view._add_step()
    assert view.steps == []
    return "".join(told)


@pytest.mark.parametrize("entered", [None, "", "banana", True, float("nan"), float("inf")])
def test_a_pause_that_is_no_number_is_not_called_one(entered: Any) -> None:
    assert message(entered) == f"pause: holds no number; give 0 to {MAX_PAUSE:g} s"


@pytest.mark.parametrize("seconds", [-1.0, -1e-9, 2.0 * MAX_PAUSE])
def test_a_pause_out_of_range_is_told_with_its_value(seconds: float) -> None:
    assert message(seconds) == f"pause: the pause is {seconds:g} s; give 0 to {MAX_PAUSE:g} s"
    with pytest.raises(InputError, match="step 1"):
        check_pause(seconds, "step 1")


@pytest.mark.parametrize("seconds", [0, 0.5, MAX_PAUSE])
def test_a_pause_within_its_range_is_accepted(seconds: float) -> None:
    assert message(seconds) == ""
    assert check_pause(seconds, "pause") == seconds
