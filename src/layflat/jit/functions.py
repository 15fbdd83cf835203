"""Laws, kernels and choices between laws as Python objects; the compiler is loaded when a kernel first runs."""

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
    """Law: kernels inline `function`; a call from Python runs `called`, its interpreted form."""

    def __init__(self, function: Callable[..., Any], called: Callable[..., Any]) -> None:
        update_wrapper(self, function)
        self.py_func, self._called = function, called

    @cached_property
    def dispatcher(self) -> Any:
        """Numba's dispatcher of the law; the first access loads the compiler."""
        return _compiler().compile_inlined(self.py_func)

    @cached_property
    def _numba_type_(self) -> Any:
        return _compiler().dispatcher_type(self.dispatcher)

    def __call__(self, *args: Any) -> Any:
        """Call it from Python."""
        return self._called(*args)


class Kernel:
    """Function that is compiled for the types of its arguments at the first call; machine code is cached on disk."""

    _lock = Lock()

    def __init__(self, function: Callable[..., Any]) -> None:
        update_wrapper(self, function)
        self.py_func = function
        self._dispatchers: dict[tuple[str, ...], Any] = {}

    @property
    def dispatcher(self) -> Any:
        """Numba's dispatcher of the kernel, another after each `include_source`; the first loads the compiler."""
        key = included_sources()
        if key not in self._dispatchers:
            with self._lock:
                if key not in self._dispatchers:
                    folder = cache_folder(Path(self.py_func.__code__.co_filename))
                    self._dispatchers[key] = _compiler().compile_cached(self.py_func, folder)
        return self._dispatchers[key]

    @property
    def _numba_type_(self) -> Any:
        return _compiler().dispatcher_type(self.dispatcher)

    def __call__(self, *args: Any) -> Any:
        """Call it from Python; the first call with arguments of some types compiles it for them.

        Raises:
            KindError: a user's law can't be compiled.
            KeyboardInterrupt: Ctrl-C during the call.
        """
        try:
            if not included_sources():
                return self.dispatcher(*args)
            with blame_outside():
                return self.dispatcher(*args)
        except SystemError as error:
            # Ctrl-C while machine code runs appears at its end, hidden behind an error of the interpreter.
            if isinstance(error.__cause__, KeyboardInterrupt):
                raise error.__cause__ from None
            raise


class ByKind:
    """Choice between laws by the class of the first argument.

    The choice is made when a kernel is compiled, so kinds that a kernel does not use cost nothing. Kinds may be added
    later to the mapping.
    """

    def __init__(self, kinds: Mapping[type, Callable[..., Any]]) -> None:
        self.kinds = kinds

    @cached_property
    def _numba_type_(self) -> Any:
        return _compiler().choice_type(self.kinds)

    def __call__(self, first: Any, *rest: Any) -> Any:
        """Call the law for the exact class of the first argument from Python; raise KeyError where there is none."""
        return self.kinds[type(first)](first, *rest)


def law(function: Callable[..., Any]) -> Callable[..., Any]:
    """Decorate a scalar function as a law, which kernels inline, for numbers and for lanes."""
    return Law(function, lane_by_lane(function))


def composition(function: Callable[..., Any]) -> Callable[..., Any]:
    """Decorate a function that joins and separates lanes as a law; it always gets all lanes at once."""
    return Law(function, function)


def kernel(function: Callable[..., Any]) -> Callable[..., Any]:
    """Decorate a function as a `Kernel`; where nothing is compiled (NUMBA_DISABLE_JIT), return the function itself."""
    return function if interpreted() else Kernel(function)


def by_kind(kinds: Mapping[type, Callable[..., Any]]) -> Callable[..., Any]:
    """Return a law that selects its implementation by the class (named tuple) of its first argument."""
    return ByKind(kinds)
