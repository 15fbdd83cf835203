"""Turns of an event loop are measured, and who held it up is told by name."""

import asyncio
import time
from collections.abc import Callable

from layflat.pages.server.logs import MAX_TURN_DURATION, MAX_TURN_WORK, Turn, TurnMonitor


def busy(seconds: float) -> None:
    """Use up processor time."""
    begun = time.thread_time()
    while time.thread_time() - begun < seconds:
        pass


def turns_of(*handlers: Callable[[], object], sampling: float = 0.01) -> list[Turn]:
    """Turns of a loop that calls handlers, one a turn."""
    turns: list[Turn] = []

    async def main() -> None:
        for handler in handlers:
            asyncio.get_running_loop().call_soon(handler)
            await asyncio.sleep(0.02)

    with TurnMonitor(turns.append, sampling=sampling) as monitor:
        monitor.reports = True
        with asyncio.Runner(loop_factory=lambda: asyncio.SelectorEventLoop(monitor.selector)) as runner:
            runner.run(main())
    return turns


def test_a_handler_that_works_for_long_is_told_by_its_name() -> None:
    turns = turns_of(lambda: busy(3 * MAX_TURN_WORK))
    longest = max(turns, key=lambda turn: turn.work)
    assert longest.is_slow
    assert longest.work >= 3 * MAX_TURN_WORK
    assert longest.handler.endswith("<lambda>")
    assert longest.inside.endswith("busy")
    assert "ms of them at work) by" in str(longest)


def test_a_handler_that_waits_is_told_too_and_short_ones_are_not() -> None:
    waited = max(turns_of(lambda: time.sleep(1.5 * MAX_TURN_DURATION)), key=lambda turn: turn.duration)
    assert waited.is_slow
    assert waited.work < MAX_TURN_WORK
    assert not any(turn.work > MAX_TURN_WORK for turn in turns_of(*[lambda: busy(1e-3)] * 5))


def test_a_loop_that_waits_for_something_to_do_has_no_long_turns() -> None:
    assert sum(turn.work for turn in turns_of(lambda: None)) < MAX_TURN_WORK


def test_nothing_is_reported_before_it_is_wanted() -> None:
    turns: list[Turn] = []
    with TurnMonitor(turns.append) as monitor:
        monitor.begin_turn()
        monitor.end_turn()
        assert turns == []
        monitor.reports = True
        monitor.begin_turn()
        monitor.end_turn()
        assert len(turns) == 1
