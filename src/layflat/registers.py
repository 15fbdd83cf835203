"""Vector registers for which laws are compiled, and the variables of the environment that switch the compiler."""

import os
from functools import cache
from typing import Any

MAX_REGISTER_BYTES = 64  # of the widest vector registers (AVX-512)
MIN_REGISTER_BYTES = 32  # of AVX2, and of pairs of narrower registers


def is_switched_on(name: str) -> bool:
    """Return whether a variable of the environment is set, and not to 0."""
    return os.environ.get(name, "").strip() not in ("", "0")


@cache
def interpreted() -> bool:
    """Return whether nothing is compiled (NUMBA_DISABLE_JIT)."""
    return is_switched_on("NUMBA_DISABLE_JIT")


_register_bytes: list[int] = []  # of this process; empty: those of this computer


@cache
def host_register_bytes() -> int:
    """Return the size of this computer's vector registers, at least two of 16 bytes."""
    from llvmlite import binding  # noqa: PLC0415  # part of the compiler, which takes long to load

    features: Any = binding.get_host_cpu_features()  # type: ignore[no-untyped-call]
    return MAX_REGISTER_BYTES if features.get("avx512f") else MIN_REGISTER_BYTES


def register_bytes() -> int:
    """Return the size of the vector registers for which lanes are compiled."""
    return _register_bytes[0] if _register_bytes else host_register_bytes()


def set_register_bytes(size: int) -> None:
    """Compile lanes for registers of another size than this computer's; to be set before anything is compiled."""
    _register_bytes[:] = [size]


def host_width(size: int = 8, max_bytes: int = MAX_REGISTER_BYTES) -> int:
    """Return the number of lanes of `size` bytes in a vector register, or `max_bytes` of it; 1 if CUDA is simulated."""
    if interpreted() and is_switched_on("NUMBA_ENABLE_CUDASIM"):
        return 1
    return min(register_bytes(), max_bytes) // size
