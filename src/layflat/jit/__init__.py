"""Compilation of laws and kernels.

A *law* is a scalar function of scalars and named tuples that returns a scalar or a tuple. It is inlined into every
kernel that calls it. A *composition* is a law that combines laws across lanes (see `lanes`). A *kernel* is a function
that Python calls for a long computation; it loops over time, is compiled at its first call, and its machine code is
cached on disk (see cache.py).

Called from Python, a law is the plain function: it returns the same bits as compiled, and needs no compiler. So code
that only reads or checks a description never loads numba, which takes longer than all else; only compiler.py does.
"""

from layflat.jit.cache import cache_folder, include_source
from layflat.jit.functions import (
    ByKind,
    Kernel,
    Law,
    PortableKernel,
    by_kind,
    composition,
    kernel,
    law,
    portable_kernel,
)

__all__ = [
    "ByKind",
    "Kernel",
    "Law",
    "PortableKernel",
    "by_kind",
    "cache_folder",
    "composition",
    "include_source",
    "kernel",
    "law",
    "portable_kernel",
]
