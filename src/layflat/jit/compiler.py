"""Compiler options: all numba options of the project, and the check of the installed version.

Some parts of numba that are used (internals.py) are not documented and may change. So only the tested versions are
accepted, unless `LAYFLAT_ANY_COMPILER` is set, by which `make newest-numba` tries others.
"""

# mypy: disable-error-code="no-untyped-call"
# The compiler's own modules are untyped.

from collections.abc import Callable, Mapping
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

from layflat.errors import CompilerError
from layflat.registers import is_switched_on

SUPPORTED_VERSIONS = {"numba": ((0, 66), (0, 69)), "llvmlite": ((0, 46), (0, 51))}
"""Supported versions: from the first on, below the second, as in pyproject.toml."""


def check_versions(installed: Callable[[str], str] = version) -> None:
    """Check that the installed compiler is of a supported version.

    Args:
        installed: returns the version of a package, such as "0.66.0", by its name.

    Raises:
        CompilerError: it is older or newer, and `LAYFLAT_ANY_COMPILER` is not set.
    """
    if is_switched_on("LAYFLAT_ANY_COMPILER"):
        return
    for package, (first, end) in SUPPORTED_VERSIONS.items():
        present = installed(package)
        if not first <= tuple(int(part) for part in present.split(".")[:2]) < end:
            known = f"{package}>={'.'.join(map(str, first))},<{'.'.join(map(str, end))}"
            what = f"{package} {present} does not fit: layflat compiles with {known}; pip install '{known}'"
            raise CompilerError(what)


check_versions()
try:
    import numba
    from numba import types
    from numba.extending import models, register_model

    import layflat.jit.lanes  # noqa: F401  # registers the types of lanes
    from layflat.jit.internals import tolerate_failed_save
    from layflat.jit.libraries import KernelCompiler, LawCompiler
except (ImportError, AttributeError) as error:
    what = f"numba {version('numba')} lacks a part that layflat uses ({error}); install layflat again"
    raise CompilerError(what) from error

config: Any = numba.config

JIT_OPTIONS: dict[str, Any] = {"error_model": "numpy", "nogil": True}
"""Options of all functions. No fast-math: results are bit for bit the same wherever laws are inlined."""

INLINE_OPTIONS: dict[str, Any] = {
    "forceinline": True,
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
    **JIT_OPTIONS,
}
"""Options of laws: without an entry point for Python, which would take a third of the time to compile."""


def compile_law(function: Callable[..., Any]) -> Any:
    """Return numba's dispatcher of a law, which is compiled when a kernel that inlines it is."""
    return numba.njit(pipeline_class=LawCompiler, **INLINE_OPTIONS)(function)


def compile_cached(function: Callable[..., Any], folder: Path | None) -> Any:
    """Return numba's dispatcher of a kernel, which compiles at its first call and caches in a folder unless None."""
    return compile_with_cache(partial(numba.njit, pipeline_class=KernelCompiler, **JIT_OPTIONS), function, folder)


def compile_with_cache(compiler: Callable[..., Any], function: Callable[..., Any], folder: Path | None) -> Any:
    """Return the dispatcher that a numba decorator makes of a function, with its machine code cached in a folder.

    The function compiles at its first call; machine code that can't be saved is no error.

    Args:
        compiler: decorator factory with an argument `cache`.
        function: the function.
        folder: folder of the cache; None: no cache.
    """
    before = config.CACHE_DIR
    config.CACHE_DIR = str(folder or "")
    try:
        return tolerate_failed_save(compiler(cache=folder is not None)(function))
    finally:
        config.CACHE_DIR = before


def dispatcher_type(dispatcher: Any) -> Any:
    """Return the numba type of a law or a kernel, which holds only a weak reference."""
    return types.Dispatcher(dispatcher)


class _Choice(types.Callable, types.Opaque):
    """Type of a choice between laws: a call is one of the law for the class of the first argument."""

    def __init__(self, laws: Mapping[type, Any], type_of: Callable[[Any], Any]) -> None:
        self.laws, self.type_of = laws, type_of
        super().__init__(name=f"Choice({id(laws)}, {type_of.__name__})")

    def _law(self, args: Any) -> Any:
        return self.type_of(self.laws[args[0].instance_class])

    def get_call_type(self, context: Any, args: Any, kws: Any) -> Any:  # language: numba's interface
        return self._law(args).get_call_type(context, args, kws)

    def get_call_signatures(self) -> Any:
        return (), True

    def get_impl_key(self, sig: Any) -> Any:
        return self._law(sig.args).get_impl_key(sig)


register_model(_Choice)(models.OpaqueModel)


def _host_type(law: Any) -> Any:
    return law._numba_type_


def choice_type(laws: Mapping[type, Any], type_of: Callable[[Any], Any] = _host_type) -> Any:
    """Return the numba type of a choice between laws; `type_of` maps a law to its type."""
    return _Choice(laws, type_of)
