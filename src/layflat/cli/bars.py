"""A bar on a terminal that shows how far some work is."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

COMPILES = "(compiles for some seconds the first time)"
"""What is shown before the first step of anything that is simulated."""


@contextmanager
def steps_bar(what: str, total: int | None = None) -> Iterator[Any]:
    """Show a bar over steps; nothing where stderr is no terminal.

    Args:
        what: what is done.
        total: steps in all, where known.

    Yields:
        `advance(done, total=None, what=None)`, which sets what the bar shows.
    """
    from rich.console import Console  # noqa: PLC0415
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn  # noqa: PLC0415

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    console = Console(stderr=True)
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(f"{what} {COMPILES}", total=total)

        def advance(done: int, total: int | None = None, now: str = "") -> None:
            bar.update(task, completed=done, total=total, description=now or (what if done else None))

        yield advance
