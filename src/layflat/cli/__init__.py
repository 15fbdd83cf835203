"""Command line: the one place that puts the parts together."""

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

from layflat.cli.groups import COMPLETION_VARIABLE, VERBOSE_OPTION, app
from layflat.cli.lazy import PAGE_COMMANDS, LazyTyper
from layflat.cli.moved import PRESENT_OPTIONS, moved_line
from layflat.errors import LayflatError, StoppedError
from layflat.outputs import parse_command, run_command

__all__ = ["app", "main"]

VERBOSE_VARIABLE = "LAYFLAT_VERBOSE"  # which `layflat.jit` reads
INTERRUPTED_EXIT = 130  # exit status after Ctrl-C
TERMINATED_EXIT = 143  # exit status after SIGTERM
NOTHING_KEPT = "stopped before there was anything to keep"


def main() -> None:
    """Run a command: an error is one line on stderr with exit status 2, after Ctrl-C with 130, after SIGTERM with 143.

    A command that can keep what was done catches `KeyboardInterrupt`, writes its results marked as partial, and raises
    `StoppedError`, whose line says where they are.
    """
    atexit.register(gc.freeze)  # last of all: looking for garbage at the end takes a short command a tenth of its time
    gc.disable()  # until a command begins: nearly all that is imported stays
    words = _take_verbose(sys.argv[1:])
    if os.environ.get(COMPLETION_VARIABLE):
        from layflat.cli.completion import answer_shell  # noqa: PLC0415

        answer_shell()
    if line := moved_line(words):
        _fail(line)
    signals: list[int] = []
    try:
        command = get_command(app)
        with (
            command.make_context("layflat", words) as context,
            _protect_outputs(words),
            _signals_as_interrupts() as signals,
        ):
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
        _fail(NOTHING_KEPT, _status_after(signals))  # a library turned the interrupt into an error of its own
    sys.exit(status if isinstance(status, int) else 0)


def _take_verbose(words: list[str]) -> list[str]:
    """Return a command line without --verbose, and set `VERBOSE_VARIABLE` for it, so that all processes know."""
    rest = [word for word in words if word != VERBOSE_OPTION]
    if len(rest) < len(words):
        os.environ[VERBOSE_VARIABLE] = "1"
    return rest


def _status_after(signals: list[int]) -> int:
    """Return the exit status of an interrupted command: 143 if SIGTERM is among the signals, else 130."""
    return TERMINATED_EXIT if signal.SIGTERM in signals else INTERRUPTED_EXIT


@contextmanager
def _signals_as_interrupts() -> Iterator[list[int]]:
    """Raise KeyboardInterrupt on SIGTERM as on Ctrl-C, so that commands clean up; yield the received signals."""
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


def _protect_outputs(words: list[str]) -> AbstractContextManager[None]:
    """Return a context in which a command replaces only files of its own; for `PAGE_COMMANDS` one that does nothing."""
    if words and words[0] in PAGE_COMMANDS:
        return nullcontext()
    groups = [name for name, place in app.places.items() if isinstance(place, LazyTyper)]
    return run_command(parse_command(words, groups, lambda text: print(f"layflat: {text}", file=sys.stderr)))  # noqa: T201


def _fail_usage(error: typer.TyperException) -> NoReturn:
    """Print the error in the arguments of a command, and the name of its help; without arguments, print the help."""
    context = getattr(error, "ctx", None)
    if "Usage:" in error.format_message():  # a group without a command
        print(error.format_message(), file=sys.stderr)  # noqa: T201
        sys.exit(2)
    command = context.command_path if context is not None else "layflat"
    option = getattr(error, "option_name", "")
    if (command, option) in PRESENT_OPTIONS:
        _fail(f"{option} is {PRESENT_OPTIONS[command, option]} now")
    _fail(f"{error.format_message().rstrip('.')} (see `{command} --help`)")


def _fail(text: str, status: int = 2) -> NoReturn:
    """Print a text on stderr in one line, and exit with a status."""
    with suppress(OSError):
        print(f"layflat: {' '.join(text.split())}", file=sys.stderr)  # noqa: T201
    sys.exit(status)


def _silence(stream: object) -> None:
    """Discard the rest of a stream that refuses to be written, so that the interpreter ends quietly."""
    with suppress(OSError, ValueError, AttributeError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())  # type: ignore[attr-defined]
