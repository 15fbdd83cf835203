"""Cache folders of the machine code of kernels, by the sources that it depends on.

Machine code goes stale when a law in another file changes, which numba does not detect. So a kernel is cached in a
folder named by a digest of every source that can be part of it: its own file and its module-level imports, recursively.
A change of any other file leaves the machine code valid.
"""

import ast
import hashlib
import os
import shutil
import time
from collections.abc import Iterator
from functools import cache
from pathlib import Path

PACKAGE_FOLDER = Path(__file__).parents[1]

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
"""Rooms and files that laws may import although none of their source is compiled."""

DIGITS = 16  # hexadecimal digits of a digest that name a folder
MAX_CACHE_AGE = 30 * 24 * 3600.0  # of machine code of other sources, s

_included: dict[Path, str] = {}
_digests: tuple[str, ...] = ()


def include_source(path: Path) -> None:
    """Make the cache of every kernel depend on the present content of a file outside the package that defines laws.

    Kernels compile anew at their next call; a second call for the same path replaces its digest.
    """
    global _digests  # noqa: PLW0603  # read at every call of a kernel
    _included[path] = hashlib.sha256(path.read_bytes()).hexdigest()
    _digests = tuple(sorted(_included.values()))


def included_sources() -> tuple[str, ...]:
    """Return the digests, sorted, of the files that `include_source` has read."""
    return _digests


@cache
def kernel_sources(path: Path) -> tuple[Path, ...]:
    """Return, sorted, the files whose source can be part of the kernels of a file: itself and its imports, recursively.

    The compiler's own files are always included, those of `WITHOUT_LAWS` never. Results are kept for the process.
    """
    files = {path, *(PACKAGE_FOLDER / "jit").rglob("*.py"), PACKAGE_FOLDER / "lanes.py"}
    waiting = [path]
    while waiting:
        for other in _imported_files(waiting.pop()):
            if other not in files and other.relative_to(PACKAGE_FOLDER).parts[0] not in WITHOUT_LAWS:
                files.add(other)
                waiting.append(other)
    return tuple(sorted(files))


def _imported_files(path: Path) -> Iterator[Path]:
    """Yield the files of the package that a file imports at module level, by absolute imports."""
    for statement in ast.parse(path.read_bytes()).body:
        if isinstance(statement, ast.Import):
            names = [alias.name for alias in statement.names]
        elif isinstance(statement, ast.ImportFrom) and statement.module and not statement.level:
            names = [statement.module, *(f"{statement.module}.{alias.name}" for alias in statement.names)]
        else:
            continue
        for name in names:
            package, *steps = name.split(".")
            if package == PACKAGE_FOLDER.name and steps:
                place = PACKAGE_FOLDER.joinpath(*steps)
                yield from (file for file in (place.with_suffix(".py"), place / "__init__.py") if file.is_file())


@cache
def source_digest(path: Path, included: tuple[str, ...] = ()) -> str:
    """Return `DIGITS` hexadecimal digits of the SHA-256 of a file's `kernel_sources` and of the digests `included`.

    Results are kept for the process: a file that changes later does not change them.
    """
    digest = hashlib.sha256("".join(included).encode())
    for file in kernel_sources(path):
        digest.update(
            str(file.relative_to(PACKAGE_FOLDER) if file.is_relative_to(PACKAGE_FOLDER) else file.name).encode()
        )
        digest.update(file.read_bytes())
    return digest.hexdigest()[:DIGITS]


def cache_folder(path: Path) -> Path | None:
    """Create and return the folder for the machine code of a file's kernels; None where none can be written.

    It is in `LAYFLAT_CACHE_DIR`, or else in the user's cache folder, where a new one also removes stale ones.
    """
    import platformdirs  # noqa: PLC0415  # not needed to import laws

    root = Path(os.environ.get("LAYFLAT_CACHE_DIR") or platformdirs.user_cache_dir("layflat"))
    folder = root / source_digest(path, included_sources())
    try:
        if not folder.exists():
            folder.mkdir(parents=True, exist_ok=True)
            remove_stale(root)
    except OSError:
        return None
    return folder if os.access(folder, os.W_OK) else None


def remove_stale(root: Path) -> None:
    """Remove the folders in `root` named by a digest and last changed more than `MAX_CACHE_AGE` ago, where possible."""
    for other in root.iterdir():
        digest = len(other.name) == DIGITS and set(other.name) <= set("0123456789abcdef")
        if digest and time.time() - other.stat().st_mtime > MAX_CACHE_AGE:
            shutil.rmtree(other, ignore_errors=True)
