"""Signs of life on a terminal while some work goes on; nothing is drawn where stderr is not a terminal."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from threading import Thread
from time import perf_counter
from typing import Any

LOOKS = 0.1  # between two looks whether some work is done, s; Ctrl-C is heard so soon

SHORT = 2.0  # work that takes longer has a bar, s

COMPILES = "(compiles for some seconds the first time)"
"""What is shown before the first step of anything that is simulated."""


@contextmanager
def bar(what: str, total: float | None, *columns: str) -> Iterator[Callable[..., None]]:
    """Show a bar for what is done; nothing where stderr is not a terminal.

    Columns behind it are named as in `rich.progress`. Yields what sets `completed`, `total` and `description`.
    """
    from rich import progress  # noqa: PLC0415
    from rich.console import Console  # noqa: PLC0415

    console = Console(stderr=True)
    behind = [getattr(progress, column)() for column in columns]
    shown = progress.Progress(
        progress.TextColumn("{task.description}"),
        progress.BarColumn(),
        *behind,
        console=console,
        transient=True,
        disable=not console.is_terminal,
    )
    with shown:
        yield partial(shown.update, shown.add_task(what, total=total))


@contextmanager
def steps_bar(what: str, total: int | None = None) -> Iterator[Any]:
    """Show a bar over steps, and how long they take; yields `advance(done, total=None, now="")`, which sets it."""
    with bar(f"{what} {COMPILES}", total, "MofNCompleteColumn", "TimeRemainingColumn") as update:

        def advance(done: int, total: int | None = None, now: str = "") -> None:
            update(completed=done, total=total, description=now or (what if done else None))

        yield advance


@contextmanager
def busy(what: str) -> Iterator[Callable[[str], None]]:
    """Show what is going on; call what it gives to show something else."""
    from rich.console import Console  # noqa: PLC0415

    with Console(stderr=True).status(what) as shown:
        yield shown.update


def in_background(work: Callable[[], Any], what: str, fraction: Callable[[], float] | None = None) -> Any:
    """Do some work in a thread, show for how long, and return what it gives or raise what it raises.

    Compiled code lets no Ctrl-C through; here it ends the waiting at once, and the thread ends with the process.

    Args:
        work: to be done.
        what: words for it.
        fraction: of the work that is done, for a bar once it takes long; default: unknown.
    """
    results: list[Any] = []
    failures: list[BaseException] = []

    def run() -> None:
        try:
            results.append(work())
        except BaseException as error:  # handed over to the thread that waits
            failures.append(error)

    thread, begun = Thread(target=run, daemon=True), perf_counter()
    thread.start()
    with busy(f"{what} {COMPILES}") as show:
        while thread.is_alive():
            thread.join(LOOKS)
            show(f"{what}, {perf_counter() - begun:.0f} s {COMPILES}")
            if fraction is not None and fraction() > 0.0 and perf_counter() - begun > SHORT:
                break
    if fraction is not None and thread.is_alive():
        with bar(what, 1.0, "TaskProgressColumn", "TimeElapsedColumn", "TimeRemainingColumn") as update:
            while thread.is_alive():
                thread.join(LOOKS)
                update(completed=fraction())
    if failures:
        raise failures[0]
    return results[0]
