"""Machine code of portable kernels as files: prebuilt ones of the package, and those of this computer in its cache.

A file is an object file with its SHA-256 digest in front. Its name says which sources, kernel and types of arguments
it was made from, so that a file of other sources is never found.
"""

import logging
import os
import platform
import sys
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any

from layflat.jit.cache import PACKAGE_FOLDER, cache_folder, included_sources, source_digest
from layflat.registers import is_switched_on

LOG = logging.getLogger(__name__)

PREBUILT_FOLDER = PACKAGE_FOLDER / "prebuilt"
SOURCES_FOLDER = "sources"
"""Folder beside prebuilt machine code with the digest of the sources that it was made from, a file for each file."""

VERBOSE_VARIABLE = "LAYFLAT_VERBOSE"  # environment variable that --verbose sets, which processes of a command inherit

LEVEL_FEATURES = {
    "x86-64-v4": ("avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"),
    "x86-64-v3": ("avx2", "bmi2", "fma", "f16c", "lzcnt", "movbe"),
    "x86-64-v2": ("sse4.2", "popcnt", "cx16"),
}
"""Features of a processor by which it is of a level of x86-64, from the highest level down."""

DIGEST_BYTES = sha256().digest_size


@cache
def host_levels() -> tuple[str, ...]:
    """Return the kinds of prebuilt machine code that run on this computer, the fastest first."""
    system = {"linux": "linux", "win32": "windows", "darwin": "macos"}.get(sys.platform, sys.platform)
    if platform.machine().lower() in ("aarch64", "arm64"):
        return (f"{system}-aarch64",)
    from llvmlite import binding  # noqa: PLC0415  # only where machine code is looked for

    features: Any = binding.get_host_cpu_features()  # type: ignore[no-untyped-call]
    fitting = (level for level, needed in LEVEL_FEATURES.items() if all(features.get(name) for name in needed))
    return tuple(f"{system}-{level}" for level in fitting)


def code_name(file: Path, kernel: str, signature: str) -> str:
    """Return the name of the machine code of a kernel.

    Args:
        file: file of the kernel.
        kernel: name of the kernel.
        signature: types of its arguments (see `signatures.signature_text`).
    """
    identity = "\n".join((source_digest(file, included_sources()), kernel, signature))
    return f"{kernel}-{sha256(identity.encode()).hexdigest()[:24]}.o"


def find_code(file: Path, name: str, processor: str) -> Iterator[tuple[Path, bytes]]:
    """Yield the object files of a name (see `code_name`) with their paths: prebuilt ones, then that of the cache.

    Args:
        file: file of the kernel, whose sources name the folder of the cache.
        name: name of the machine code.
        processor: digest of the processor that cached code is made for.
    """
    folders = [PREBUILT_FOLDER / level for level in host_levels()] if PREBUILT_FOLDER.is_dir() else []
    paths = [] if included_sources() else [folder / name for folder in folders]
    folder = cache_folder(file)
    if folder is not None:
        paths.append(folder / f"{processor}-{name}")
    for path in paths:
        code = _read(path)
        if code is not None:
            yield path, code


def missing_reason(file: Path) -> str:
    """Return the reason why there is no prebuilt machine code for a kernel of a file."""
    if included_sources():
        return "laws from outside the package take part"
    if not any((PREBUILT_FOLDER / level).is_dir() for level in host_levels()):
        return "no prebuilt machine code for this processor is installed"
    try:
        digest = (PREBUILT_FOLDER / SOURCES_FOLDER / source_name(file)).read_text(encoding="utf-8")
    except OSError:
        return "its file has no prebuilt machine code"
    if digest != source_digest(file):
        return "prebuilt machine code is of other sources"
    return "no prebuilt machine code is of these types of arguments"


def report_compilation(kernel: str, file: Path) -> None:
    """Log that a kernel of a file is compiled, and why: a warning if `LAYFLAT_VERBOSE` is set, else for information."""
    level = logging.WARNING if is_switched_on(VERBOSE_VARIABLE) else logging.INFO
    LOG.log(level, "compiling %s of %s: %s", kernel, file.name, missing_reason(file))


def source_name(file: Path) -> str:
    """Return the name of the file in `SOURCES_FOLDER` for a file with kernels."""
    steps = file.relative_to(PACKAGE_FOLDER).parts if file.is_relative_to(PACKAGE_FOLDER) else (file.name,)
    return f"{'-'.join(steps)}.txt"


def prebuilt_levels() -> list[str]:
    """Return the names of the folders of prebuilt machine code, sorted."""
    names = sorted(os.listdir(PREBUILT_FOLDER)) if PREBUILT_FOLDER.is_dir() else []  # noqa: PTH208
    return [name for name in names if name != SOURCES_FOLDER]


def find_stale_sources() -> list[str]:
    """Return the names of the package's files with kernels whose prebuilt machine code is of other sources."""
    digests = {path.name: path.read_text(encoding="utf-8") for path in (PREBUILT_FOLDER / SOURCES_FOLDER).glob("*.txt")}
    files = {source_name(file): file for file in PACKAGE_FOLDER.rglob("*.py") if source_name(file) in digests}
    return [
        name.removesuffix(".txt")
        for name, text in digests.items()
        if name not in files or source_digest(files[name]) != text
    ]


def keep_code(file: Path, name: str, processor: str, code: bytes) -> None:
    """Write an object file into the cache; where it can't be written, it is not kept.

    Args:
        file: file of the kernel.
        name: name of the machine code.
        processor: digest of the processor that it is made for.
        code: the object file.
    """
    folder = cache_folder(file)
    if folder is not None:
        with suppress(OSError):
            write_code(folder / f"{processor}-{name}", code)


def write_code(path: Path, code: bytes) -> None:
    """Write an object file with its digest, under a temporary name first."""
    temporary = path.with_suffix(f".{os.getpid()}")
    temporary.write_bytes(sha256(code).digest() + code)
    temporary.replace(path)


def remark_damage(path: Path, reason: str = "is damaged") -> None:
    """Warn that an object file can't be used; once in a process, whatever the file."""
    if not _remarked:
        _remarked.append(path)
        LOG.warning("%s %s: its kernel is compiled instead; install layflat anew, or clear its cache", path, reason)


_remarked: list[Path] = []


def _read(path: Path) -> bytes | None:
    """Return an object file; None where there is none, or a damaged one, which is remarked."""
    try:
        content = path.read_bytes()
    except OSError:
        return None
    digest, code = content[:DIGEST_BYTES], content[DIGEST_BYTES:]
    if sha256(code).digest() == digest:
        return code
    remark_damage(path)
    return None
