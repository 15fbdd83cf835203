"""Signs of life on a terminal, while something takes long; nothing is drawn where there is none."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Thread
from typing import Any

LOOKS = 0.1
"""Between two looks whether a work is done, s; Ctrl-C is heard so soon."""


@contextmanager
def busy(what: str) -> Iterator[None]:
    """Show what is going on."""
    from rich.console import Console  # noqa: PLC0415

    with Console(stderr=True).status(what):
        yield


@contextmanager
def bar(what: str, *, total: float | None = None, counted: bool = False) -> Iterator[Callable[..., None]]:
    """A progress bar; call what it gives with `completed`, `total`, `description` or `advance`.

    Args:
        what: is shown until a description is given.
        total: of what counts; may be told later.
        counted: show how many of how many, and how long it will take.
    """
    from rich.console import Console  # noqa: PLC0415
    from rich.progress import (  # noqa: PLC0415
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    ends = (MofNCompleteColumn(), TimeRemainingColumn()) if counted else (TimeElapsedColumn(),)
    columns = (TextColumn("{task.description}"), BarColumn(), *ends)
    console = Console(stderr=True)
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as progress:
        task = progress.add_task(what, total=total)
        yield lambda **changes: progress.update(task, **changes)


def in_background(work: Callable[[], Any], what: str) -> Any:
    """Do a work in a thread, show how long it takes, and return what it gives or raise what it raises.

    Compiled code lets no Ctrl-C through; here it ends the waiting at once, and the thread with the process.

    Raises:
        KeyboardInterrupt: the user stopped it.
    """
    result: list[Any] = []
    failure: list[BaseException] = []

    def run() -> None:
        try:
            result.append(work())
        except BaseException as error:  # handed over to the thread that waits
            failure.append(error)

    thread = Thread(target=run, daemon=True)
    thread.start()
    thread.join(2 * LOOKS)  # what is quick needs no sign
    if thread.is_alive():
        with bar(what):
            while thread.is_alive():
                thread.join(LOOKS)
    if failure:
        raise failure[0]
    return result[0]
