"""Public names of a package, and NumPy, that are imported when they are first used."""

import gc
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any


def lazy_getattr(package: str, homes: Mapping[str, str]) -> Callable[[str], Any]:
    """Return a `__getattr__` for a package, which imports the home of a name.

    Args:
        package: its name.
        homes: "module:name" of each public name, or the module alone where that is what the name stands for.

    Returns:
        A function that raises AttributeError, with the nearest names, for any other name.
    """

    def find(name: str) -> Any:
        """Return what a public name stands for; raise AttributeError for any other name."""
        if name in homes:
            module, _, attribute = homes[name].partition(":")
            with without_collection():
                home = import_module(module)
            return getattr(home, attribute) if attribute else home
        if name.startswith("__"):
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        raise AttributeError(_unknown_name(package, name, homes))

    return find


@contextmanager
def without_collection() -> Iterator[None]:
    """Collect no garbage during the block: nearly all that imports make stays, and searching it takes a tenth."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


def _unknown_name(package: str, name: str, homes: Mapping[str, str]) -> str:
    """Return the message for an unknown name: with up to three similar public names, or with all if none is similar."""
    from difflib import get_close_matches  # noqa: PLC0415  # for the message alone

    folded = {public.lower(): public for public in homes}
    near = [folded[match] for match in get_close_matches(name.lower(), folded, n=3, cutoff=0.5)]
    advice = f"did you mean {' or '.join(near)}?" if near else f"it offers {', '.join(sorted(homes))}"
    return f"module {package!r} has no attribute {name!r}; {advice}"


class LazyModule(ModuleType):
    """Module that is imported when one of its names is first used."""

    def __getattr__(self, name: str) -> Any:
        """Return what a name of the module stands for, and keep it."""
        value = getattr(import_module(self.__name__), name)
        setattr(self, name, value)
        return value


if TYPE_CHECKING:
    import numpy as numpy  # noqa: PLC0414  # a public name
else:
    numpy = LazyModule("numpy")
"""NumPy for modules that describe machines: to read a description takes a third less time without it."""
