"""Users' kinds: a control law, valve, hysteresis or arm in a Python file that a machine's description names.

Such a file is a program: loading a machine that names one runs it.
"""

import re
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from hashlib import sha256
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

from layflat.errors import KindError, LayflatError
from layflat.jit.cache import include_source

_loaded: dict[Path, str] = {}
"""Digests of the files that have been run, by path."""

NO_CAUSE = re.compile(
    r"Failed in \S+ mode pipeline|During: |File \"|- Resolution failure|There are \d+ candidate|[\^~]+$|$"
)
"""Lines of the compiler's errors that do not say what is wrong."""

RAISED_FROM = re.compile(r"\s*Raised from .*")  # the place, which the message already has

NO_FAILURES = (LayflatError, KeyboardInterrupt)  # exceptions in a user's code that are no failures of it

COLOUR_CODE = re.compile(r"\x1b\[[0-9;]*m")


def load_kinds(path: Path, where: str) -> None:
    """Run a file that registers kinds, once; a copy of one that has run is not run again.

    Args:
        path: the file.
        where: description and key that name it, for messages.

    Raises:
        KindError: it can't be read, fails, or was changed since it was run.
    """
    path = path.resolve()
    try:
        content = path.read_bytes()
    except OSError as error:
        raise KindError(
            f"{path} can't be read ({error.strerror})", where=where, right="give the path of a Python file"
        ) from None
    digest = sha256(content).hexdigest()
    if path in _loaded:
        if _loaded[path] != digest:
            raise KindError(f"{path} was changed since it was loaded", where=where, right="start Python anew")
        return
    if digest in _loaded.values():  # a copy under another name holds the same kinds
        _loaded[path] = digest
        return
    # By content alone: cached machine code refers to the module's name, and is looked up by content.
    name = f"layflat_kinds_{digest[:16]}"
    spec = spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise KindError(f"{path} is not a Python file", where=where, right="give a file that ends in .py")
    module = sys.modules[name] = module_from_spec(spec)
    _loaded[path] = digest
    include_source(path)
    try:
        with blame_outside(path):
            exec(compile(content, str(path), "exec"), module.__dict__)  # content of the digest
    except BaseException:
        del sys.modules[name], _loaded[path]
        raise


@contextmanager
def blame_outside(running: Path | None = None) -> Iterator[None]:
    """Return a context in which an error in a loaded file of kinds becomes a KindError that names file and line.

    Errors elsewhere, other LayflatErrors and Ctrl-C pass unchanged.

    Args:
        running: the file that is being run, which all errors are attributed to; None: by the traceback.

    Raises:
        KindError: such a file failed, when it ran or when its laws were compiled.
    """
    if not _loaded:
        yield
        return
    try:
        yield
    except KindError as error:
        place = place_in_kinds(error)
        if place is None or any(str(path) in error.where for path in _loaded):
            raise
        raise KindError(error.what, where=f"{place}: {error.where}".removesuffix(": "), right=error.right) from None
    except NO_FAILURES:
        raise
    except BaseException as error:
        place = place_in_kinds(error) or (str(running) if running is not None else None)
        if place is None:
            raise
        raise KindError(first_line(error), where=place) from error


def first_line(error: BaseException) -> str:
    """Return class and message of an error in one line; of the compiler's many lines the first with the cause."""
    text = error.msg if isinstance(error, SyntaxError) else COLOUR_CODE.sub("", str(error))
    lines = [line.strip() for line in text.strip().split("\n")]
    message = next((line for line in lines if not NO_CAUSE.match(line)), lines[0])
    return f"{type(error).__name__}: {RAISED_FROM.sub('', message)}" if message else type(error).__name__


def place_in_kinds(error: BaseException) -> str | None:
    """Return FILE:LINE of an error's innermost frame in a file of kinds, or as its message tells; None if in none."""
    if isinstance(error, SyntaxError) and error.filename and Path(error.filename) in _loaded:
        return f"{error.filename}:{error.lineno}" if error.lineno else error.filename
    for frame in reversed(traceback.extract_tb(error.__traceback__)):
        if Path(frame.filename) in _loaded:
            return f"{frame.filename}:{frame.lineno}"
    for path in _loaded:
        name = re.escape(path.name)
        position = re.search(rf'File "(?:[^"]*/)?{name}", line (\d+)|Raised from (?:\S*/)?{name} \((\d+)\)', str(error))
        if position:
            return f"{path}:{position[1] or position[2]}"
    return None
