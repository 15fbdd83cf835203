"""Laws, kernels and choices between laws, as Python meets them; the compiler is loaded when a kernel first runs."""

from collections.abc import Callable, Mapping
from functools import cached_property, update_wrapper
from pathlib import Path
from threading import Lock
from types import ModuleType
from typing import Any

from layflat.jit.cache import cache_folder, included_sources
from layflat.jit.outside import blame_outside
from layflat.lanes import interpreted, lane_by_lane


def _compiler() -> ModuleType:
    from layflat.jit import compiler  # noqa: PLC0415  # it loads numba

    return compiler


class Law:
    """A function that kernels inline; Python calls it as it stands, with lanes one by one."""

    def __init__(self, function: Callable[..., Any], called: Callable[..., Any]) -> None:
        update_wrapper(self, function)
        self.py_func, self._called = function, called

    @cached_property
    def dispatcher(self) -> Any:
        """The compiler's own object for it."""
        return _compiler().inlined(self.py_func)

    @cached_property
    def _numba_type_(self) -> Any:
        return _compiler().dispatcher_type(self.dispatcher)

    def __call__(self, *args: Any) -> Any:
        """Call it from Python."""
        return self._called(*args)


class Kernel:
    """A function that is compiled for the arguments of its first call; the machine code is kept on disk."""

    _lock = Lock()

    def __init__(self, function: Callable[..., Any]) -> None:
        update_wrapper(self, function)
        self.py_func = function
        self._dispatchers: dict[tuple[str, ...], Any] = {}

    @property
    def dispatcher(self) -> Any:
        """The compiler's own object for it."""
        key = included_sources()
        if key not in self._dispatchers:
            with self._lock:
                if key not in self._dispatchers:
                    folder = cache_folder(Path(self.py_func.__code__.co_filename))
                    self._dispatchers[key] = _compiler().cached(self.py_func, folder)
        return self._dispatchers[key]

    @property
    def _numba_type_(self) -> Any:
        return _compiler().dispatcher_type(self.dispatcher)

    def __call__(self, *args: Any) -> Any:
        """Call it from Python; the first call with arguments of some types compiles it for them.

        Raises:
            KindError: a law from outside can't be compiled.
            KeyboardInterrupt: Ctrl-C meanwhile.
        """
        try:
            if not included_sources():
                return self.dispatcher(*args)
            with blame_outside():
                return self.dispatcher(*args)
        except SystemError as error:
            # What comes while machine code runs is found as it ends, and hidden behind an error of the interpreter.
            if isinstance(error.__cause__, KeyboardInterrupt):
                raise error.__cause__ from None
            raise


class ByKind:
    """A law for each kind of its first argument.

    The choice is made when a kernel is compiled, so a kernel costs nothing for the kinds it does not use. Kinds may be
    added later, to the mapping that it was made with.
    """

    def __init__(self, kinds: Mapping[type, Callable[..., Any]]) -> None:
        self.kinds = kinds

    @cached_property
    def _numba_type_(self) -> Any:
        return _compiler().choice(self.kinds)

    def __call__(self, first: Any, *rest: Any) -> Any:
        """Call from Python the law for the first argument."""
        return self.kinds[type(first)](first, *rest)


def law(function: Callable[..., Any]) -> Callable[..., Any]:
    """Make a scalar function a law: it is inlined into every kernel that uses it, for numbers and for lanes."""
    return Law(function, lane_by_lane(function))


def composition(function: Callable[..., Any]) -> Callable[..., Any]:
    """Make a function that joins and parts lanes a law; it is given them all at once in any case."""
    return Law(function, function)


def kernel(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function that Python calls when it is first called, and keep the machine code on disk."""
    return function if interpreted() else Kernel(function)


def by_kind(kinds: Mapping[type, Callable[..., Any]]) -> Callable[..., Any]:
    """A law that picks its implementation by the kind (named tuple class) of its first argument."""
    return ByKind(kinds)
