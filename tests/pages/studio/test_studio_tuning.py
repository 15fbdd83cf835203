"""Gains are searched in another process, which tells how far it is, can be stopped, and says what is wrong."""

import signal
import time
from collections.abc import Iterator
from multiprocessing import get_context
from multiprocessing.connection import Connection
from multiprocessing.synchronize import Event
from typing import Any

import pytest

from layflat.machine.listing import to_toml
from layflat.machine.loader import tables
from layflat.pages.studio.design import Design, open_description
from layflat.pages.studio.tuning import TuningProgress, TuningRun, _tune

pytestmark = pytest.mark.compiled


def ended(run: TuningRun) -> TuningProgress:
    deadline = time.monotonic() + 60.0
    while not run.progress.has_ended:
        assert time.monotonic() < deadline
        time.sleep(0.02)
    return run.progress


def test_gains_that_are_found_can_be_taken_and_undone() -> None:
    pytest.importorskip("cma")
    design = Design(open_description("paper-small-joint"))
    design.edit("joint.small.gains.far.error", "0.05 V/deg")
    found = ended(TuningRun(design, generations=5))
    assert not found.error
    assert found.first is not None
    assert found.best is not None
    assert found.best < found.first
    design.edit_all(found.changes)
    assert design.source("joint.small.gains.far.error").source == "calibrated"
    design.undo()
    assert set(design.changes) == {"joint.small.gains.far.error"}


@pytest.fixture
def here() -> Iterator[tuple[Connection, Connection, Event]]:
    """What a tuning in this process talks through."""
    context = get_context("spawn")
    before = signal.getsignal(signal.SIGINT)
    ours, theirs = context.Pipe(duplex=False)
    yield ours, theirs, context.Event()
    signal.signal(signal.SIGINT, before)


def told(name: str, generations: int, ours: Connection, theirs: Connection, cancelled: Event) -> list[tuple[str, Any]]:
    _tune(to_toml(*tables(name)), generations, 1, theirs, cancelled)
    theirs.close()
    lines = []
    while ours.poll():
        try:
            lines.append(ours.recv())
        except EOFError:
            break
    return lines


def test_a_tuning_that_is_stopped_ends_with_what_it_has(here: tuple[Connection, Connection, Event]) -> None:
    pytest.importorskip("cma")
    here[2].set()
    lines = told("paper-small-joint", 500, *here)
    assert [what for what, _ in lines] == ["best", "found"]


def test_what_can_not_be_tuned_is_said(here: tuple[Connection, Connection, Event]) -> None:
    pytest.importorskip("cma")
    ((what, text),) = told("rig-kevlar", 1, *here)
    assert what == "error"
    assert "rig-kevlar" in text or "controller" in text
