"""Commands without what large packages do for other users: it takes as long as the rest of a short command.

xarray imports each package of arrays that is installed, dask with its scheduler among them, and pandas imports Arrow,
although commands hand them plain arrays alone. Matplotlib writes the documentation of every method that sets
properties, which nobody reads in a command.
"""

import gc
import sys
from collections.abc import Iterator
from contextlib import contextmanager

GC_THRESHOLD = 100_000  # new objects between two searches for garbage
ARRAY_PACKAGES = ("dask", "pint", "cupy", "sparse", "cubed")  # that xarray looks for
TABLE_PACKAGES = ("pyarrow",)  # that pandas looks for; 40 MB of memory


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


def trim_imports() -> None:
    """Import xarray, pandas and matplotlib without what a command does not need, and search for garbage less often.

    Left out are `ARRAY_PACKAGES`, `TABLE_PACKAGES`, and matplotlib's documentation. It is for the process of a command,
    before anything else imports them.
    """
    gc.set_threshold(GC_THRESHOLD)  # else a sixth of the time is spent on objects that stay
    with hide_packages(*ARRAY_PACKAGES, *TABLE_PACKAGES):
        from xarray.namedarray.pycompat import array_type  # noqa: PLC0415
        from xarray.namedarray.utils import module_available  # noqa: PLC0415

        for name in ARRAY_PACKAGES:
            array_type(name)  # type: ignore[arg-type]  # its answers are kept for the process, as of the next
        module_available("dask")

    import matplotlib.artist  # noqa: PLC0415

    matplotlib.artist.kwdoc = lambda artist: ""  # noqa: ARG005
