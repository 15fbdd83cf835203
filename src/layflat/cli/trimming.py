"""Commands without what large packages do for other users: it takes as long as the rest of a short command.

xarray imports each package of arrays that is installed, dask with its scheduler among them, and pandas imports Arrow,
although commands hand them plain arrays alone. No command works asynchronously, over encrypted connections, with TeX's
glyphs or with figures in space. Matplotlib writes the documentation of every method that sets properties, which nobody
reads in a command.
"""

import gc
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from importlib.util import find_spec
from types import ModuleType
from typing import Any

GC_THRESHOLD = 100_000  # new objects between two searches for garbage
ARRAY_PACKAGES = ("dask", "pint", "cupy", "sparse", "cubed")  # that xarray looks for
TABLE_PACKAGES = ("pyarrow",)  # that pandas looks for; 40 MB of memory
LATE_MODULES = ("asyncio", "fontTools.agl")  # of xarray and matplotlib; 4 MB of memory


@contextmanager
def hide_packages(*names: str) -> Iterator[None]:
    """Make packages that are not imported yet count as not installed during the block."""
    hidden = [name for name in names if name not in sys.modules]
    sys.modules.update(dict.fromkeys(hidden))  # type: ignore[arg-type]  # None: it can't be imported
    try:
        yield
    finally:
        for name in hidden:
            del sys.modules[name]


class LateModule(ModuleType):
    """Module in the place of another one, which is imported when something of it is used."""

    def __getattr__(self, name: str) -> Any:
        """Import the module, and return what is used of it."""
        if sys.modules.get(self.__name__) is self:
            del sys.modules[self.__name__]
        return getattr(import_module(self.__name__), name)


def load_late(name: str) -> None:
    """Put a `LateModule` where imports of a module find it, unless that is imported already."""
    package, _, last = name.rpartition(".")
    if name not in sys.modules and find_spec(package or name):
        sys.modules[name] = LateModule(name)
        if package:
            setattr(import_module(package), last, sys.modules[name])


@contextmanager
def without_space() -> Iterator[None]:
    """Import matplotlib during the block without its figures in space, which are another megabyte."""
    with hide_packages("mpl_toolkits.mplot3d"), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Unable to import Axes3D")
        yield


def trim_imports() -> None:
    """Import xarray, pandas and matplotlib without what a command does not need, and search for garbage less often.

    Left out are `ARRAY_PACKAGES`, `TABLE_PACKAGES`, `LATE_MODULES`, and matplotlib's documentation. It is for the
    process of a command, before anything else imports them.
    """
    gc.set_threshold(GC_THRESHOLD)  # else a sixth of the time is spent on objects that stay
    for name in LATE_MODULES:
        load_late(name)
    with hide_packages(*ARRAY_PACKAGES, *TABLE_PACKAGES):
        from xarray.namedarray.pycompat import array_type  # noqa: PLC0415
        from xarray.namedarray.utils import module_available  # noqa: PLC0415

        for name in ARRAY_PACKAGES:
            array_type(name)  # type: ignore[arg-type]  # its answers are kept for the process, as of the next
        module_available("dask")

    import matplotlib.artist  # noqa: PLC0415

    matplotlib.artist.kwdoc = lambda artist: ""  # noqa: ARG005
