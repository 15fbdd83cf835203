"""The command line: the one place that puts the parts together."""

import atexit
import gc
import os
import signal
import sys
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from typing import NoReturn

import typer
from typer.main import get_command

from layflat.cli.app import app
from layflat.cli.lazy import ASKING
from layflat.errors import LayflatError, StoppedError
from layflat.outputs import command_of, running

__all__ = ["app", "main"]

STOPPED = 130  # exit status after Ctrl-C
TERMINATED = 143  # exit status after SIGTERM
NOTHING_KEPT = "stopped before there was anything to keep"


def main() -> None:
    """Run a command; an error is one line on stderr and exit status 2, Ctrl-C one line and 130, SIGTERM and 143.

    A command that can keep what was done catches `KeyboardInterrupt`, writes its results marked as partial, and raises
    `StoppedError`, whose line says where they are.
    """
    atexit.register(gc.freeze)  # last of all: looking for garbage at the end takes a short command a tenth of its time
    words = sys.argv[1:]
    signals: list[int] = []
    try:
        command = get_command(app)
        with command.make_context("layflat", words) as context, _outputs(words), _ending_orderly() as signals:
            status = command.invoke(context)
        sys.stdout.flush()
    except typer.Exit as end:
        status = end.exit_code
    except StoppedError as error:
        _fail(str(error), _status_after(signals))
    except (typer.Abort, KeyboardInterrupt):
        _fail(NOTHING_KEPT, _status_after(signals))
    except LayflatError as error:
        _fail(str(error))
    except typer.TyperException as error:
        _fail_usage(error)
    except BrokenPipeError:
        _silence(sys.stdout)
        sys.exit(0)
    except MemoryError:
        _fail("not enough memory")
    except OSError as error:
        _silence(sys.stdout)
        _fail(f"{error.filename or 'standard output'}: {error.strerror or error}")
    except Exception:
        if not signals:
            raise
        _fail(NOTHING_KEPT, _status_after(signals))  # a library made an error of its own of what interrupted it
    sys.exit(status if isinstance(status, int) else 0)


def _status_after(signals: list[int]) -> int:
    return TERMINATED if signal.SIGTERM in signals else STOPPED


@contextmanager
def _ending_orderly() -> Iterator[list[int]]:
    """End a command on SIGTERM as on Ctrl-C, so that nothing half done stays; yield the list of signals that came."""
    signals: list[int] = []

    def interrupt(number: int, _frame: object) -> None:
        signals.append(number)
        raise KeyboardInterrupt

    before = {signal.SIGTERM: signal.signal(signal.SIGTERM, interrupt)}
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:  # it may be ignored, as in the background
        before[signal.SIGINT] = signal.signal(signal.SIGINT, interrupt)
    try:
        yield signals
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _outputs(words: list[str]) -> AbstractContextManager[None]:
    """Return a context in which nothing is replaced that the command does not own, unless its page asks before."""
    if words and words[0] in ASKING:
        return nullcontext()
    groups = [name for name, place in app.modules.items() if ":" in place]
    return running(command_of(words, groups, lambda text: print(f"layflat: {text}", file=sys.stderr)))  # noqa: T201


def _fail_usage(error: typer.TyperException) -> NoReturn:
    """Say what is wrong with the words of a command, and which help tells more; without words, show the help."""
    context = getattr(error, "ctx", None)
    if "Usage:" in error.format_message():  # a group without a command
        print(error.format_message(), file=sys.stderr)  # noqa: T201
        sys.exit(2)
    command = context.command_path if context is not None else "layflat"
    _fail(f"{error.format_message().rstrip('.')} (see `{command} --help`)")


def _fail(text: str, status: int = 2) -> NoReturn:
    with suppress(OSError):
        print(f"layflat: {' '.join(text.split())}", file=sys.stderr)  # noqa: T201
    sys.exit(status)


def _silence(stream: object) -> None:
    """Discard the rest of a stream that refuses to be written, so that the interpreter ends quietly."""
    with suppress(OSError, ValueError, AttributeError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())  # type: ignore[attr-defined]
