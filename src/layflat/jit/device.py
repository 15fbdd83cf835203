"""The compiler for CUDA devices: kernels that their threads run, and the laws inlined into these."""

# mypy: disable-error-code="no-untyped-call"
# The compiler's own modules are untyped.

from collections.abc import Callable
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

from layflat.jit.compiler import choice, config, keep_code
from layflat.jit.functions import ByKind, Law


def device_kernel(function: Callable[..., Any], folder: Path | None = None) -> Any:
    """Compile a function that the threads of a CUDA device run, and keep its machine code in a folder.

    It may call laws, and what `on_device` gives.
    """
    cuda: Any = import_module("numba.cuda")
    if config.ENABLE_CUDASIM:
        return cuda.jit(function)
    extending: Any = import_module("numba.cuda.extending")
    extending.typeof_impl.register(Law)(lambda law, _: on_device(law)._numba_type_)
    extending.typeof_impl.register(ByKind)(lambda laws, _: choice(laws.kinds, _device_type))
    return keep_code(cuda.jit, function, folder)


@cache
def on_device(function: Any) -> Any:
    """A law or a kernel, such that it is inlined into a `device_kernel` that calls it."""
    plain = getattr(function, "py_func", function)
    if config.ENABLE_CUDASIM:
        return plain
    return import_module("numba.cuda").jit(device=True, forceinline=True)(plain)


def _device_type(law: Any) -> Any:
    return on_device(law)._numba_type_
