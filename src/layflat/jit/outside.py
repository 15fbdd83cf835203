"""Kinds from outside: a user's own control law, valve, hysteresis or arm, in a Python file that a machine's file names.

Such a file is a program: whoever loads a machine that names one runs it.
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


def load_kinds(path: Path, where: str) -> None:
    """Run a file that registers kinds, once.

    Args:
        path: the file.
        where: who names it, for messages.

    Raises:
        KindError: it can't be read, fails, or was changed since it was run.
    """
    path = path.resolve()
    try:
        digest = sha256(path.read_bytes()).hexdigest()
    except OSError as error:
        raise KindError(
            f"{path} can't be read ({error.strerror})", where=where, right="give the path of a Python file"
        ) from None
    if path in _loaded:
        if _loaded[path] != digest:
            raise KindError(f"{path} was changed since it was loaded", where=where, right="start Python anew")
        return
    name = f"layflat_kinds_{path.stem}_{digest[:8]}"
    spec = spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise KindError(f"{path} is not a Python file", where=where, right="give a file that ends in .py")
    module = sys.modules[name] = module_from_spec(spec)
    _loaded[path] = digest
    include_source(path)
    try:
        with blame_outside():
            spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[name], _loaded[path]
        raise


@contextmanager
def blame_outside() -> Iterator[None]:
    """Turn what goes wrong in a file of kinds into one line that names the file and the line.

    Raises:
        KindError: such a file failed, when it ran or when its laws were compiled.
    """
    if not _loaded:
        yield
        return
    try:
        yield
    except KindError as error:
        place = _place(error)
        if place is None or place in error.where:
            raise
        raise KindError(error.what, where=f"{place}: {error.where}".removesuffix(": "), right=error.right) from None
    except LayflatError:
        raise
    except Exception as error:
        place = _place(error)
        if place is None:
            raise
        text = str(error).strip().split("\n")
        # The compiler's first line says only in which of its steps it failed.
        said = next((line.strip() for line in text[1:] if line.strip()), text[0]) if len(text) > 1 else text[0]
        raise KindError(f"{type(error).__name__}: {said}", where=place) from error


def _place(error: Exception) -> str | None:
    for frame in reversed(traceback.extract_tb(error.__traceback__)):
        if Path(frame.filename) in _loaded:
            return f"{frame.filename}:{frame.lineno}"
    for path in _loaded:
        found = re.search(rf'File "[^"]*{re.escape(path.name)}", line (\d+)', str(error))
        if found:
            return f"{path}:{found[1]}"
    return None
