"""How laws and kernels are compiled.

A *law* is a scalar function of scalars and named tuples that returns a scalar or a tuple. It is inlined into whatever
kernel calls it. A *composition* is a law that puts laws together across lanes (see `lanes`). A *kernel* is the function
that Python calls to have much done; it loops over time, is compiled when it is first called, and its machine code is
kept on disk (see cache.py).

Called from Python, a law is the plain function that stands there: it has the same bits as when it is compiled, and
costs no compiler. So whoever only reads or checks a description never loads numba, which takes longer than all else;
what is needed of it stands in compiler.py.
"""

from layflat.jit.cache import cache_folder, include_source
from layflat.jit.functions import ByKind, Kernel, Law, by_kind, composition, kernel, law

__all__ = ["ByKind", "Kernel", "Law", "by_kind", "cache_folder", "composition", "include_source", "kernel", "law"]
