"""Laws, kernels and choices between laws as Python objects; the compiler is loaded when a kernel first runs."""

import logging
from collections.abc import Callable, Mapping
from functools import cached_property, partial, update_wrapper
from pathlib import Path
from threading import Lock
from types import ModuleType
from typing import Any

from layflat.errors import CompilerError
from layflat.jit import stored
from layflat.jit.cache import cache_folder, included_sources
from layflat.jit.outside import blame_outside
from layflat.jit.signatures import signature_text, words
from layflat.lanes import lane_by_lane
from layflat.lazy import numpy as np
from layflat.registers import interpreted, register_bytes

LOG = logging.getLogger(__name__)


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
        return _compiler().compile_law(self.py_func)

    @property
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


class PortableKernel:
    """Function of arrays, numbers, `Like` and tuples of these, whose machine code is an object file.

    It allocates nothing, and returns integers only. It is looked up among the prebuilt object files of the package and
    in the cache, and loaded without the compiler; where there is none, it is compiled and kept.

    Args:
        function: the function.
        results: number of integers that it returns.
        in_lanes: whether it reads as many lanes as a vector register holds, so that its machine code differs with that.
    """

    _lock = Lock()

    def __init__(self, function: Callable[..., Any], results: int, *, in_lanes: bool = False) -> None:
        update_wrapper(self, function)
        self.py_func, self.results, self.in_lanes = function, results, in_lanes
        self._loaded: dict[tuple[str, tuple[str, ...]], Callable[[int], None]] = {}

    @cached_property
    def dispatcher(self) -> Any:
        """Numba's dispatcher of it as a law, which other kernels inline."""
        return _compiler().compile_law(self.py_func)

    @property
    def _numba_type_(self) -> Any:
        return _compiler().dispatcher_type(self.dispatcher)

    def bind(self, *args: Any) -> Callable[..., Any]:
        """Return a function that calls it with these arrays, and with any numbers as its last arguments.

        Raises:
            UnportableError: an argument is none of those of `PortableKernel`, or an array is not contiguous.
            KindError: a user's law can't be compiled.
        """
        if interpreted():
            return lambda *last: self.py_func(*args[: len(args) - len(last)], *last)
        return BoundKernel(self, args)

    def __reduce__(self) -> str:
        """Pickle it by its name: it is the same in every copy of what is bound to it."""
        return self.py_func.__qualname__

    def __call__(self, *args: Any) -> Any:
        """Call it from Python; raise as `bind` does."""
        return self.py_func(*args) if interpreted() else BoundKernel(self, args)()

    def portable_code(self, args: tuple[Any, ...]) -> str:
        """Return LLVM's text of the function for arguments of these types (see `portable`)."""
        from layflat.jit import portable  # noqa: PLC0415  # it loads numba

        with blame_outside():
            return portable.portable_code(self.py_func.__name__, self, args, self.results)

    def code_name(self, args: tuple[Any, ...]) -> str:
        """Return the name of the object file for arguments of these types."""
        return stored.code_name(self.file, self.py_func.__name__, self.signature(args))

    def signature(self, args: tuple[Any, ...]) -> str:
        """Return the types of arguments as a text: equal texts mean the same machine code."""
        return signature_text(args) + (f" lanes:{register_bytes()}" if self.in_lanes else "")

    @property
    def file(self) -> Path:
        """File of the function."""
        return Path(self.py_func.__code__.co_filename)

    def machine_code(self, args: tuple[Any, ...]) -> Callable[[int], None]:
        """Return the loaded machine code for arguments of these types: a function of the address of their words.

        It is looked up, or else compiled, at the first call for these types.
        """
        key = self.signature(args), included_sources()
        if key not in self._loaded:
            with self._lock:
                if key not in self._loaded:
                    self._loaded[key] = self._load(args)
        return self._loaded[key]

    def _load(self, args: tuple[Any, ...]) -> Callable[[int], None]:
        """Return stored machine code, or else compile it and keep it; stored code that does not load is remarked."""
        from layflat.jit import objects  # noqa: PLC0415  # it loads LLVM

        name, entry, processor = self.code_name(args), self.py_func.__name__, objects.host()
        for path, code in stored.find_code(self.file, name, processor.digest):
            try:
                function = objects.load(code, entry)
            except CompilerError as error:
                stored.remark_damage(path, f"can't be loaded ({error})")
            else:
                LOG.debug("loaded %s from %s", entry, path)
                return function
        stored.report_compilation(entry, self.file)
        text = self.portable_code(args)
        for observe in COMPILATION_OBSERVERS:
            observe(self, args, text)
        code = objects.machine_code(text, (entry,), processor)
        stored.keep_code(self.file, name, processor.digest, code)
        return objects.load(code, entry)


COMPILATION_OBSERVERS: list[Callable[[PortableKernel, tuple[Any, ...], str], None]] = []
"""Functions that are called when a kernel is compiled: with it, its arguments and LLVM's text of it."""


class BoundKernel:
    """Call of a portable kernel with certain arrays; its last numbers may differ from call to call."""

    def __init__(self, kernel: PortableKernel, args: tuple[Any, ...]) -> None:
        self._function, self._results, self._bound = kernel.machine_code(args), kernel.results, (kernel, args)
        passed = list(words(args))
        self._words = np.zeros(self._results + len(passed), np.int64)
        numbers = self._words.view(np.float64)
        for i, value in enumerate(passed, self._results):
            (numbers if isinstance(value, float) else self._words)[i] = value
        self._address = self._words.ctypes.data

    def __reduce__(self) -> tuple[Any, ...]:
        """Copy it by its arrays, since addresses are those of this process and of these arrays."""
        return BoundKernel, self._bound

    def __call__(self, *last: int) -> Any:
        """Call it with integers for its last arguments, which stay for later calls; return its integer, or a tuple."""
        if last:
            self._words[-len(last) :] = last
        self._function(self._address)
        results = self._words[: self._results].tolist()
        return tuple(results) if self._results > 1 else results[0] if results else None


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


def portable_kernel(results: int = 0, *, in_lanes: bool = False) -> Callable[[Callable[..., Any]], PortableKernel]:
    """Return a decorator for kernels that allocate nothing (see `PortableKernel`, also for the arguments)."""
    return partial(PortableKernel, results=results, in_lanes=in_lanes)


def by_kind(kinds: Mapping[type, Callable[..., Any]]) -> Callable[..., Any]:
    """Return a law that selects its implementation by the class (named tuple) of its first argument."""
    return ByKind(kinds)
