"""Compilation for CUDA devices: kernels that their threads run, and the laws inlined into these."""

# mypy: disable-error-code="no-untyped-call"
# The compiler's own modules are untyped.

from collections.abc import Callable
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

from layflat.jit.compiler import choice_type, compile_with_cache, config
from layflat.jit.functions import ByKind, Law


def device_kernel(function: Callable[..., Any], folder: Path | None = None) -> Any:
    """Return a function as a kernel of a CUDA device, compiled at its first launch and cached in a folder; None: not.

    It may call laws, and functions of `device_law`. Numba's CUDA simulator interprets it, without a cache.
    """
    cuda: Any = import_module("numba.cuda")
    if config.ENABLE_CUDASIM:
        return cuda.jit(function)
    extending: Any = import_module("numba.cuda.extending")
    extending.typeof_impl.register(Law)(lambda law, _: device_law(law)._numba_type_)
    extending.typeof_impl.register(ByKind)(lambda laws, _: choice_type(laws.kinds, _device_type))
    return compile_with_cache(cuda.jit, function, folder)


@cache
def device_law(function: Any) -> Any:
    """Return a law or a kernel in a form that a `device_kernel` inlines; under CUDA's simulator plain Python."""
    plain = getattr(function, "py_func", function)
    if config.ENABLE_CUDASIM:
        return plain
    return import_module("numba.cuda").jit(device=True, forceinline=True)(plain)


def _device_type(law: Any) -> Any:
    return device_law(law)._numba_type_
