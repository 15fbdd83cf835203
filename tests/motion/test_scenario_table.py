"""The table of signals: rows, and what the pages say of them."""

from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from layflat.machine import Machine, load
from layflat.motion.scenario import SIGNALS, Scenario, SignalRow
from layflat.motion.signal_rows import expand_signal
from layflat.motion.signal_values import Sampling

PAGE = Path(__file__).parents[2] / "docs" / "conventions.md"
ARM = load("paper-arm")
HEADER = "| signal | unit | for | between runs | `simulate` | in logs | |\n|---|---|---|---|---|---|---|\n"


def line(name: str, row: SignalRow) -> str:
    unit, _ = row.recorded
    cells = [
        f"`{name}`", unit, "a joint" if row.by_joint else "all joints", row.varies, f"`--{name}`" if row.option else "",
        row.logged, row.meaning + (", gauge" if row.gauge else ""),
    ]  # fmt: skip
    return f"| {' | '.join(cells)} |"


def test_the_page_shows_the_table() -> None:
    table = HEADER + "\n".join(line(name, row) for name, row in SIGNALS.items())
    assert table in PAGE.read_text(encoding="utf-8"), f"docs/conventions.md lacks:\n{table}"


@pytest.mark.parametrize("name", SIGNALS)
def test_a_row_is_whole(name: str) -> None:
    row = SIGNALS[name]
    assert row.meaning
    assert (row.varies == "replaces") == (not row.by_joint) == bool(row.path)
    assert row.annotation is not None
    assert (row.quantity is None) == (not row.written)


@pytest.mark.parametrize("name", [one.name for one in fields(Scenario) if one.metadata])
@pytest.mark.parametrize("machine", [ARM, load("earlier-actuator")], ids=["arm", "without valves"])
def test_values_that_are_usual_are_plausible(name: str, machine: Machine) -> None:
    row = SIGNALS[name]
    usual = np.full(len(machine.joints) if row.by_joint else 1, row.usual_of(machine))
    rows = expand_signal({}, row.kind(name, list(machine.joints)), usual, Sampling(0.005, 3))
    assert np.array_equal(row.check(machine, rows, name), np.tile(usual, (3, 1)), equal_nan=True)
