"""Cache folders of the machine code of kernels, by the sources that it depends on.

Machine code goes stale when a law in another file changes, which numba does not detect. So a kernel is cached in a
folder named by a digest of every source that can be part of it: its own file and its module-level imports, recursively.
A change of any other file leaves the machine code valid.
"""

import hashlib
import os
import re
import shutil
import time
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
    "lazy.py",
    "outputs.py",
    "parallel.py",
)
"""Rooms and files that laws may import although none of their source is compiled."""

ROOMS_WITHOUT_LAWS = frozenset(name.removesuffix(".py") for name in WITHOUT_LAWS)

IMPORT_PATTERN = re.compile(
    rb"^(?:from[ \t]+(layflat[\w.]*)[ \t]+import|import)[ \t]*(\((?:[^)#]|#.*)*\)|.*)", re.MULTILINE
)
"""Import at the beginning of a line: the module that names are imported from, and these, or modules."""

COMMENT_PATTERN = re.compile(rb"#.*")
NAME_PATTERN = re.compile(rb"(?<![\w.])[A-Za-z_][\w.]*")

DIGITS = 16  # hexadecimal digits of a digest that name a folder
HEX_DIGITS = frozenset("0123456789abcdef")
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
    compiling = [PACKAGE_FOLDER / "lanes.py", PACKAGE_FOLDER / "registers.py", *(PACKAGE_FOLDER / "jit").rglob("*.py")]
    files = {str(path), *map(str, compiling)}
    waiting = [str(path)]
    while waiting:
        added = imported_files(waiting.pop()) - files
        files |= added
        waiting += added
    return tuple(sorted(map(Path, files)))


@cache
def _content(path: str) -> bytes:
    with open(path, "rb") as file:  # noqa: PTH123  # of a hundred files: a Path takes twice as long
        return file.read()


@cache
def imported_files(path: str) -> frozenset[str]:
    """Return the files of the package, without those of `WITHOUT_LAWS`, that a file imports at module level.

    Imports are absolute, and begin a line. They are found without a parser, which takes ten times as long; a line of a
    text that looks like one only adds a file.
    """
    found = set[str]()
    for module, listed in IMPORT_PATTERN.findall(_content(path)):
        imported = _module_file(module.decode())
        found.add(imported)
        if not module or module == b"layflat" or imported.endswith("__init__.py"):
            prefix = f"{module.decode()}." if module else ""
            found |= {
                _module_file(prefix + name.decode()) for name in NAME_PATTERN.findall(COMMENT_PATTERN.sub(b"", listed))
            }
    return frozenset(found - {""})


@cache
def _module_file(module: str) -> str:
    """Return the file of a module of the package; "" if there is none, or no law can be in it."""
    package, *steps = module.split(".")
    place = os.path.join(PACKAGE_FOLDER, *steps)  # noqa: PTH118  # as above
    if package != PACKAGE_FOLDER.name or not steps or steps[0] in ROOMS_WITHOUT_LAWS:
        return ""
    files = (f"{place}.py", os.path.join(place, "__init__.py"))  # noqa: PTH118
    return next((file for file in files if os.path.isfile(file)), "")  # noqa: PTH113


@cache
def _content_digest(path: str) -> bytes:
    return hashlib.sha256(_content(path)).digest()


@cache
def source_digest(path: Path, included: tuple[str, ...] = ()) -> str:
    """Return `DIGITS` hexadecimal digits of the SHA-256 of a file's `kernel_sources` and of the digests `included`.

    Results are kept for the process: a file that changes later does not change them.
    """
    digest = hashlib.sha256("".join(included).encode())
    for file in kernel_sources(path):
        name = file.relative_to(PACKAGE_FOLDER).as_posix() if file.is_relative_to(PACKAGE_FOLDER) else file.name
        digest.update(name.encode())
        digest.update(_content_digest(str(file)))
    return digest.hexdigest()[:DIGITS]


def cache_root() -> Path:
    """Return the folder with all machine code of this computer: `LAYFLAT_CACHE_DIR`, or else the user's cache."""
    import platformdirs  # noqa: PLC0415  # not needed to import laws

    return Path(os.environ.get("LAYFLAT_CACHE_DIR") or platformdirs.user_cache_dir("layflat"))


def cached_folders(root: Path) -> list[Path]:
    """Return the folders of machine code in a cache, each named by a digest."""
    names = sorted(os.listdir(root)) if root.is_dir() else []  # noqa: PTH208
    return [root / name for name in names if len(name) == DIGITS and set(name) <= HEX_DIGITS]


def cache_folder(path: Path) -> Path | None:
    """Create and return the folder for the machine code of a file's kernels; None where none can be written.

    It is in `cache_root`, where a new one also removes stale ones.
    """
    root = cache_root()
    folder = root / source_digest(path, included_sources())
    try:
        if not folder.exists():
            folder.mkdir(parents=True, exist_ok=True)
            remove_stale(root)
    except OSError:
        return None
    return folder if os.access(folder, os.W_OK) else None


def remove_stale(root: Path) -> None:
    """Remove the folders of machine code in `root` last changed more than `MAX_CACHE_AGE` ago, where possible."""
    for folder in cached_folders(root):
        if time.time() - folder.stat().st_mtime > MAX_CACHE_AGE:
            shutil.rmtree(folder, ignore_errors=True)
