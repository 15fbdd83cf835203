"""Where the machine code of kernels is kept, and when it is stale.

Machine code goes stale when a law in another file changes, which numba does not see. So a kernel is kept in a folder
named by a digest of every source that can end up in it: its own file and what this imports at its top, and so on. A
change of any other file leaves the machine code as it is.
"""

import ast
import hashlib
import os
import shutil
import time
from collections.abc import Iterator
from functools import cache
from pathlib import Path

PACKAGE = Path(__file__).parents[1]

WITHOUT_LAWS = (
    "arrays.py",
    "description",
    "errors.py",
    "files.py",
    "kind_checks.py",
    "kinds.py",
    "outputs.py",
    "parallel.py",
)
"""Rooms and files that laws may import although none of their source ends up in machine code."""

DIGITS = 16  # hexadecimal digits of a digest that name a folder
KEPT_FOR = 30 * 24 * 3600.0  # machine code of other sources is kept this long, s

_included: dict[Path, str] = {}
_digests: tuple[str, ...] = ()


def include_source(path: Path) -> None:
    """Let the machine code of all kernels depend on a file outside the package, which holds laws too."""
    global _digests  # noqa: PLW0603  # asked for at every call of a kernel
    _included[path] = hashlib.sha256(path.read_bytes()).hexdigest()
    _digests = tuple(sorted(_included.values()))


def included_sources() -> tuple[str, ...]:
    """Digests of the files outside the package that hold laws."""
    return _digests


@cache
def sources(path: Path) -> tuple[Path, ...]:
    """Every file of the package that can end up in the kernels of a file, that file included."""
    found = {path, *(PACKAGE / "jit").glob("*.py"), *(PACKAGE / "lanes").glob("*.py")}
    waiting = [path]
    while waiting:
        for other in _imported(waiting.pop()):
            if other not in found and other.relative_to(PACKAGE).parts[0] not in WITHOUT_LAWS:
                found.add(other)
                waiting.append(other)
    return tuple(sorted(found))


def _imported(path: Path) -> Iterator[Path]:
    """Files of the package that a file imports at its top."""
    for statement in ast.parse(path.read_bytes()).body:
        if isinstance(statement, ast.Import):
            names = [alias.name for alias in statement.names]
        elif isinstance(statement, ast.ImportFrom) and statement.module and not statement.level:
            names = [statement.module, *(f"{statement.module}.{alias.name}" for alias in statement.names)]
        else:
            continue
        for name in names:
            package, *steps = name.split(".")
            if package == PACKAGE.name and steps:
                place = PACKAGE.joinpath(*steps)
                yield from (file for file in (place.with_suffix(".py"), place / "__init__.py") if file.is_file())


@cache
def source_digest(path: Path, included: tuple[str, ...] = ()) -> str:
    """Digest of every source that can end up in the kernels of a file."""
    digest = hashlib.sha256("".join(included).encode())
    for file in sources(path):
        digest.update(str(file.relative_to(PACKAGE) if file.is_relative_to(PACKAGE) else file.name).encode())
        digest.update(file.read_bytes())
    return digest.hexdigest()[:DIGITS]


def cache_folder(path: Path) -> Path | None:
    """Folder for the machine code of a file's kernels, or None where none can be written."""
    import platformdirs  # noqa: PLC0415  # not needed to import laws

    root = Path(os.environ.get("LAYFLAT_CACHE_DIR") or platformdirs.user_cache_dir("layflat"))
    folder = root / source_digest(path, included_sources())
    try:
        if not folder.exists():
            folder.mkdir(parents=True, exist_ok=True)
            forget_stale(root)
    except OSError:
        return None
    return folder if os.access(folder, os.W_OK) else None


def forget_stale(root: Path) -> None:
    """Remove the machine code of other sources to which nothing was added for a month."""
    for other in root.iterdir():
        digest = len(other.name) == DIGITS and set(other.name) <= set("0123456789abcdef")
        if digest and time.time() - other.stat().st_mtime > KEPT_FOR:
            shutil.rmtree(other, ignore_errors=True)
