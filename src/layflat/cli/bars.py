"""Progress of work on a terminal; nothing is drawn where stderr is not a terminal."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from threading import Thread
from time import perf_counter
from typing import Any

POLL_INTERVAL = 0.1  # between two checks whether work in a thread is done, s; Ctrl-C takes effect as soon

MIN_BAR_TIME = 2.0  # of work that gets a bar, s

COMPILING_TEXT = "(compiles for some seconds the first time)"
"""Text that is shown before the first step of a simulation."""


@contextmanager
def bar(what: str, total: float | None, *columns: str) -> Iterator[Callable[..., None]]:
    """Show a progress bar; yield a function that sets its `completed`, `total` and `description`.

    Args:
        what: description of the work.
        total: value of `completed` at the end; None if unknown.
        columns: names of the columns of `rich.progress` behind the bar.
    """
    from rich import progress  # noqa: PLC0415
    from rich.console import Console  # noqa: PLC0415

    console = Console(stderr=True)
    behind = [getattr(progress, column)() for column in columns]
    display = progress.Progress(
        progress.TextColumn("{task.description}"),
        progress.BarColumn(),
        *behind,
        console=console,
        transient=True,
        disable=not console.is_terminal,
    )
    with display:
        yield partial(display.update, display.add_task(what, total=total))


@contextmanager
def steps_bar(what: str, total: int | None = None) -> Iterator[Any]:
    """Show a bar over steps with the remaining time; yield `advance(done, total=None, now="")`, which sets it."""
    with bar(f"{what} {COMPILING_TEXT}", total, "MofNCompleteColumn", "TimeRemainingColumn") as update:

        def advance(done: int, total: int | None = None, now: str = "") -> None:
            update(completed=done, total=total, description=now or (what if done else None))

        yield advance


@contextmanager
def busy(what: str) -> Iterator[Callable[[str], None]]:
    """Show a status text; yield a function that replaces it."""
    from rich.console import Console  # noqa: PLC0415

    with Console(stderr=True).status(what) as shown:
        yield shown.update


def in_background(
    work: Callable[[], Any], what: str, fraction: Callable[[], float] | None = None, note: str = COMPILING_TEXT
) -> Any:
    """Call a function in a thread, show the elapsed time, and return its result or raise its error.

    Compiled code does not react to Ctrl-C; here Ctrl-C ends the wait at once, and the thread ends with the process.

    Args:
        work: function without arguments.
        what: description of the work.
        fraction: returns the fraction of the work done, 0..1, for a bar once it takes `MIN_BAR_TIME`; None: unknown.
        note: text behind the elapsed time.
    """
    results: list[Any] = []
    failures: list[BaseException] = []

    def run() -> None:
        """Store the result of the work, or its error."""
        try:
            results.append(work())
        except BaseException as error:  # handed over to the thread that waits
            failures.append(error)

    thread, start = Thread(target=run, daemon=True), perf_counter()
    thread.start()
    with busy(f"{what} {note}") as show:
        while thread.is_alive():
            thread.join(POLL_INTERVAL)
            show(f"{what}, {perf_counter() - start:.0f} s {note}")
            if fraction is not None and fraction() > 0.0 and perf_counter() - start > MIN_BAR_TIME:
                break
    if fraction is not None and thread.is_alive():
        with bar(what, 1.0, "TaskProgressColumn", "TimeElapsedColumn", "TimeRemainingColumn") as update:
            while thread.is_alive():
                thread.join(POLL_INTERVAL)
                update(completed=fraction())
    if failures:
        raise failures[0]
    return results[0]
