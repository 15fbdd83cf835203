"""The compiler: every numba option of the project stands here, and the check that this numba is one that fits.

`lanes` teaches numba a type of its own by means that numba does not promise to keep. So the versions it was tested with
are the ones that are accepted.
"""

# mypy: disable-error-code="no-untyped-call"
# The compiler's own modules are untyped.

from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

from layflat.errors import CompilerError

FITTING = {"numba": ((0, 66), (0, 69)), "llvmlite": ((0, 46), (0, 51))}
"""Versions that fit: from the first on, below the second. They stand in pyproject.toml as well."""


def check_versions(installed: Callable[[str], str] = version) -> None:
    """Make sure that the installed compiler is one whose internals are known.

    Raises:
        CompilerError: it is older or newer.
    """
    for package, (first, end) in FITTING.items():
        found = installed(package)
        if not first <= tuple(int(part) for part in found.split(".")[:2]) < end:
            known = f"{package}>={'.'.join(map(str, first))},<{'.'.join(map(str, end))}"
            raise CompilerError(f"{package} {found} does not fit: layflat compiles with {known}; pip install '{known}'")


check_versions()
try:
    import numba
    from numba.core import types
    from numba.core.datamodel.models import OpaqueModel
    from numba.core.imputils import lower_constant
    from numba.extending import register_model

    import layflat.lanes.compiled  # noqa: F401  # it teaches the compiler lanes
    from layflat.jit.libraries import KernelCompiler, LawCompiler
except (ImportError, AttributeError) as error:
    raise CompilerError(f"numba {version('numba')} lacks what layflat needs of it ({error})") from error

config: Any = numba.config

STRICT: dict[str, Any] = {"error_model": "numpy", "nogil": True}
"""No fast-math: a run is bit for bit the same wherever its laws are inlined."""

INLINED: dict[str, Any] = {"forceinline": True, "no_cpython_wrapper": True, "no_cfunc_wrapper": True, **STRICT}
"""For laws inside kernels: an entry for Python would take a third of the time to compile."""


def inlined(function: Callable[..., Any]) -> Any:
    """Compile a law into the kernels that call it."""
    return numba.njit(pipeline_class=LawCompiler, **INLINED)(function)


def cached(function: Callable[..., Any], folder: Path | None) -> Any:
    """Compile a kernel, and keep its machine code in a folder where there is one."""
    return keep_code(partial(numba.njit, pipeline_class=KernelCompiler, **STRICT), function, folder)


def keep_code(compiler: Callable[..., Any], function: Callable[..., Any], folder: Path | None) -> Any:
    """A function for a compiler, which keeps its machine code in a folder where there is one."""
    before = config.CACHE_DIR
    config.CACHE_DIR = str(folder or "")
    try:
        dispatcher: Any = compiler(cache=folder is not None)(function)
    finally:
        config.CACHE_DIR = before
    save = dispatcher._cache.save_overload

    def save_where_possible(*args: Any) -> None:
        """On a full disk the machine code is of use all the same."""
        with suppress(OSError):
            save(*args)

    dispatcher._cache.save_overload = save_where_possible
    return dispatcher


def dispatcher_type(dispatcher: Any) -> Any:
    """Type of a law or a kernel to the compiler, which does not keep it alive."""
    return types.Dispatcher(dispatcher)


class _Choice(types.Callable):
    """To the compiler: a call is one of the law for the kind of the first argument."""

    def __init__(self, laws: Mapping[type, Any], type_of: Callable[[Any], Any]) -> None:
        self.laws, self.type_of = laws, type_of
        super().__init__(name=f"Choice({id(laws)}, {type_of.__name__})")

    def _law(self, args: Any) -> Any:
        return self.type_of(self.laws[args[0].instance_class])

    def get_call_type(self, context: Any, args: Any, kws: Any) -> Any:
        return self._law(args).get_call_type(context, args, kws)

    def get_call_signatures(self) -> Any:
        return (), True

    def get_impl_key(self, sig: Any) -> Any:
        return self._law(sig.args).get_impl_key(sig)


register_model(_Choice)(OpaqueModel)


@lower_constant(_Choice)  # type: ignore[untyped-decorator]
def _nothing(context: Any, builder: Any, kind: Any, value: Any) -> Any:  # noqa: ARG001
    return context.get_dummy_value()


def _host_type(law: Any) -> Any:
    return law._numba_type_


def choice(laws: Mapping[type, Any], type_of: Callable[[Any], Any] = _host_type) -> Any:
    """Type of a choice between laws to the compiler; `type_of` is that of a law."""
    return _Choice(laws, type_of)
