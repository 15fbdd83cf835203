"""A delayed command arrives whole, once, and so many cycles late."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.physics.driver import MAX_DELAY_CYCLES, ZERO_COMMANDS, delay_command

openings = st.lists(st.floats(-1.0, 1.0), min_size=1, max_size=12)


def acting(asked: list[float], cycles: float) -> list[float]:
    """What acts in each cycle, until nothing is left in the line."""
    line, seen = ZERO_COMMANDS, []
    for u in [*asked, *[0.0] * (MAX_DELAY_CYCLES + 1)]:
        acts, line = delay_command(line, u, cycles)
        seen.append(acts)
    return seen


@given(openings)
def test_no_delay_changes_nothing(asked: list[float]) -> None:
    assert acting(asked, 0.0)[: len(asked)] == asked


@pytest.mark.parametrize("cycles", [1, 2, 3])
@given(asked=openings)
def test_whole_cycles_shift_the_command(cycles: int, asked: list[float]) -> None:
    assert acting(asked, float(cycles))[cycles : cycles + len(asked)] == asked


@given(openings, st.floats(0.0, MAX_DELAY_CYCLES))
def test_the_whole_command_arrives_at_the_right_time_on_average(asked: list[float], cycles: float) -> None:
    acts = np.array(acting(asked, cycles))
    assert acts.sum() == pytest.approx(np.sum(asked), abs=1e-12)
    moment = np.arange(len(asked)) @ np.array(asked)
    assert np.arange(len(acts)) @ acts == pytest.approx(moment + cycles * np.sum(asked), abs=1e-9)
