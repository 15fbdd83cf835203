"""Machine code of portable kernels as files: prebuilt ones of the package, and those of this computer in its cache.

A file is an object file with its SHA-256 digest in front. Its name says which sources, kernel and types of arguments
it was made from, so that a file of other sources is never found.
"""

import logging
import os
import platform
import sys
from contextlib import suppress
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any

from layflat.jit.cache import PACKAGE_FOLDER, cache_folder, included_sources, source_digest

LOG = logging.getLogger(__name__)

PREBUILT_FOLDER = PACKAGE_FOLDER / "prebuilt"

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


def find_code(file: Path, name: str, processor: str) -> bytes | None:
    """Return the object file of a name (see `code_name`), prebuilt or from the cache; None: neither.

    Args:
        file: file of the kernel, whose sources name the folder of the cache.
        name: name of the machine code.
        processor: digest of the processor that cached code is made for.
    """
    for level in host_levels() if not included_sources() else ():
        code = _read(PREBUILT_FOLDER / level / name)
        if code is not None:
            return code
    folder = cache_folder(file)
    return None if folder is None else _read(folder / f"{processor}-{name}")


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


def _read(path: Path) -> bytes | None:
    """Return an object file; None where there is none, or a damaged one, which is remarked."""
    try:
        content = path.read_bytes()
    except OSError:
        return None
    digest, code = content[:DIGEST_BYTES], content[DIGEST_BYTES:]
    if sha256(code).digest() == digest:
        return code
    LOG.warning("%s is damaged: its kernel is compiled instead", path)
    return None
