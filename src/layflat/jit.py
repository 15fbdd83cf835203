"""How laws and kernels are compiled: every numba option of the project stands here.

A *law* is a scalar function of scalars and named tuples that returns a scalar or a tuple. It is inlined into whatever
calls it and is never cached by itself. A *kernel* is the function that Python calls; it loops over time and is cached.

Cached machine code goes stale when a law in another file changes, which numba does not see. So kernels are cached in
a folder named by a digest of all sources that can end up in a kernel: a changed source means another folder.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import numba
import platformdirs
from numba.extending import overload

F = TypeVar("F", bound=Callable[..., Any])

ROOMS = ("physics", "control", "sim")
"""The folders whose sources can end up in a kernel."""

STRICT: dict[str, Any] = {"error_model": "numpy", "nogil": True}
"""No fast-math: a run is bit for bit the same wherever its laws are inlined."""


@cache
def source_digest() -> str:
    """Digest of every source that can end up in a kernel."""
    package = Path(__file__).parent
    files = [Path(__file__), *(path for room in ROOMS for path in sorted((package / room).rglob("*.py")))]
    digest = hashlib.sha256()
    for path in files:
        digest.update(str(path.relative_to(package)).encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


@cache
def cache_folder() -> Path | None:
    """Folder for the compiled kernels of these very sources, or None where none can be written."""
    root = os.environ.get("LAYFLAT_CACHE_DIR") or platformdirs.user_cache_dir("layflat")
    folder = Path(root) / source_digest()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return None
    return folder if os.access(folder, os.W_OK) else None


def law(function: F) -> F:
    """Compile a scalar function so that it is inlined into every kernel that uses it."""
    return numba.njit(forceinline=True, **STRICT)(function)


def kernel(function: F) -> F:
    """Compile a function that Python calls, and keep the machine code on disk."""
    folder = cache_folder()
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(folder or "")
    try:
        return numba.njit(cache=folder is not None, **STRICT)(function)
    finally:
        numba.config.CACHE_DIR = before


def by_kind(kinds: Mapping[type, Callable[..., Any]]) -> Callable[..., Any]:
    """A law that picks its implementation by the kind (named tuple class) of its first argument.

    The choice is made when a kernel is compiled, so a kernel costs nothing for the kinds it does not use. A new kind
    is one more entry in `kinds`.
    """

    def choose(first: Any, *rest: Any) -> Any:
        return kinds[type(first)](first, *rest)

    @overload(choose, jit_options={"forceinline": True, **STRICT})
    def choose_compiled(first, *rest):  # type: ignore[no-untyped-def]  # numba compares bare signatures
        chosen = kinds[first.instance_class]
        return lambda first, *rest: chosen(first, *rest)

    return choose
