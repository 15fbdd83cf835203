"""How laws and kernels are compiled: every numba option of the project stands here.

A *law* is a scalar function of scalars and named tuples that returns a scalar or a tuple. It is inlined into whatever
kernel calls it; called from Python it is a kernel of its own. A *composition* is a law that puts laws together across
lanes (see `lanes`). A *kernel* is the function that Python calls; it loops over time and is cached.

Cached machine code goes stale when a law in another file changes, which numba does not see. So kernels are cached in
a folder named by a digest of all sources that can end up in a kernel: a changed source means another folder.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import time
from collections.abc import Callable, Mapping
from functools import cache, update_wrapper
from importlib import import_module
from pathlib import Path
from typing import Any, cast

import numba
import platformdirs
from numba.core import types
from numba.core.datamodel.models import OpaqueModel
from numba.core.imputils import lower_constant
from numba.extending import register_model

from layflat.lanes import lane_by_lane

config: Any = numba.config

ROOMS = ("lanes", "physics", "control", "sim", "bridge")
"""The folders whose sources can end up in a kernel."""

DIGITS = 16
"""Hexadecimal digits of a digest that name a folder."""

KEPT_FOR = 30 * 24 * 3600.0
"""Machine code of other sources is kept this long, s."""

STRICT: dict[str, Any] = {"error_model": "numpy", "nogil": True}
"""No fast-math: a run is bit for bit the same wherever its laws are inlined."""

INLINED: dict[str, Any] = {"forceinline": True, "no_cpython_wrapper": True, "no_cfunc_wrapper": True, **STRICT}
"""For laws inside kernels: an entry for Python would take a third of the time to compile."""


@cache
def source_digest() -> str:
    """Digest of every source that can end up in a kernel."""
    package = Path(__file__).parent
    files = [Path(__file__), *(path for room in ROOMS for path in sorted((package / room).rglob("*.py")))]
    digest = hashlib.sha256()
    for path in files:
        digest.update(str(path.relative_to(package)).encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()[:DIGITS]


@cache
def cache_folder() -> Path | None:
    """Folder for the compiled kernels of these very sources, or None where none can be written."""
    root = Path(os.environ.get("LAYFLAT_CACHE_DIR") or platformdirs.user_cache_dir("layflat"))
    folder = root / source_digest()
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


class Law:
    """A compiled law: kernels inline it, Python calls it."""

    def __init__(self, function: Callable[..., Any]) -> None:
        update_wrapper(self, function)
        self.py_func = function
        self._called = kernel(function)
        self._inlined = numba.njit(**INLINED)(function)
        self._numba_type_ = types.Dispatcher(self._inlined)

    def __call__(self, *args: Any) -> Any:
        """Call it from Python; the first call with arguments of some types compiles it for them."""
        return self._called(*args)


def law(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a scalar function so that it is inlined into every kernel that uses it."""
    return lane_by_lane(function) if config.DISABLE_JIT else Law(function)


def composition(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile like a law a function that joins and parts lanes; it is given them all at once in any case."""
    return function if config.DISABLE_JIT else Law(function)


def kernel(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function that Python calls, and keep the machine code on disk."""
    folder = cache_folder()
    before = config.CACHE_DIR
    config.CACHE_DIR = str(folder or "")
    try:
        return cast(Callable[..., Any], numba.njit(cache=folder is not None, **STRICT)(function))
    finally:
        config.CACHE_DIR = before


def device_kernel(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function that the threads of a CUDA device run. It may call laws, and what `on_device` gives."""
    if not config.ENABLE_CUDASIM:
        extending: Any = import_module("numba.cuda.extending")
        extending.typeof_impl.register(Law)(lambda law, _: on_device(law)._numba_type_)
        extending.typeof_impl.register(ByKind)(lambda choice, _: _choice_on_device(choice))
    return cast(Callable[..., Any], import_module("numba.cuda").jit(function))


@cache
def on_device(function: Any) -> Any:
    """A law or a kernel, such that it is inlined into a `device_kernel` that calls it."""
    plain = getattr(function, "py_func", function)
    if config.ENABLE_CUDASIM:
        return plain
    return import_module("numba.cuda").jit(device=True, forceinline=True)(plain)


class _Choice(types.Callable):
    """To the compiler: a call is one of the law for the kind of the first argument."""

    def __init__(self, laws: Mapping[type, Any]) -> None:
        self.laws = laws
        super().__init__(name=f"Choice({', '.join(str(law) for law in laws.values())})")

    def get_call_type(self, context: Any, args: Any, kws: Any) -> Any:
        return self.laws[args[0].instance_class].get_call_type(context, args, kws)

    def get_call_signatures(self) -> Any:
        return (), True

    def get_impl_key(self, sig: Any) -> Any:
        return self.laws[sig.args[0].instance_class].get_impl_key(sig)


register_model(_Choice)(OpaqueModel)


@lower_constant(_Choice)  # type: ignore[no-untyped-call,untyped-decorator]
def _nothing(context: Any, builder: Any, kind: Any, value: Any) -> Any:  # noqa: ARG001
    return context.get_dummy_value()


def _choice_on_device(choice: ByKind) -> _Choice:
    return _Choice({kind: on_device(law)._numba_type_ for kind, law in choice.kinds.items()})


class ByKind:
    """A law for each kind of its first argument."""

    def __init__(self, kinds: Mapping[type, Callable[..., Any]]) -> None:
        self.kinds = kinds
        if not config.DISABLE_JIT:
            self._numba_type_ = _Choice({kind: cast(Law, law)._numba_type_ for kind, law in kinds.items()})

    def __call__(self, first: Any, *rest: Any) -> Any:
        """Call from Python the law for the first argument."""
        return self.kinds[type(first)](first, *rest)


def by_kind(kinds: Mapping[type, Callable[..., Any]]) -> Callable[..., Any]:
    """A law that picks its implementation by the kind (named tuple class) of its first argument.

    The choice is made when a kernel is compiled, so a kernel costs nothing for the kinds it does not use. A new kind
    is one more entry in `kinds`.
    """
    return ByKind(kinds)
