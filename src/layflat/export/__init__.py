"""Laws and plants on other computers: as C, on microcontrollers, in simulators of others, in browsers.

The way of a value: a machine gives its entries (`entries.py`), which are the laws as they stand; numba's portable code
of them (`compiled.py`) becomes object files by the table of targets (`targets.py`); their structs (`layout.py`) become
headers (`header.py`); and a writer puts all into a folder. Readable C takes another way, from the laws' sources
(`c_source/`).

Example:
    >>> import layflat as lf
    >>> sorted(name for name in lf.export.TARGET_WRITERS if name.startswith("cortex"))
    ['cortex-m33', 'cortex-m4', 'cortex-m4f', 'cortex-m7']
"""

from collections.abc import Callable
from contextlib import nullcontext
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from layflat.errors import InputError
from layflat.files import whole_folder
from layflat.outputs import is_forced

if TYPE_CHECKING:
    from layflat.machine import Machine

__all__ = ["TARGET_WRITERS", "export"]

C_TARGETS = ("c", "cortex-m7", "cortex-m4f", "cortex-m4", "cortex-m33", "riscv32")

TARGET_WRITERS: dict[str, str] = {
    **dict.fromkeys(C_TARGETS, "layflat.export.c_folder:write_c_folder"),
    "c-source": "layflat.export.c_source.folder:write_source_folder",
    "fmu": "layflat.export.fmu.writer:write_fmus",
    "wasm": "layflat.export.web.folder:write_folder",
    "wasm-plain": "layflat.export.web.folder:write_folder",
}
"""Function that writes the folder of each target, as "module:function"; see `export`."""


def export(
    machine: "str | Path | Machine",
    target: str,
    out: str | Path,
    *,
    precision: str = "double",
    wait_for: Callable[[Callable[[], list[Path]]], list[Path]] = lambda work: work(),
) -> list[Path]:
    """Write what a target needs to run a machine's laws, all of it or nothing.

    Args:
        machine: a description, its file, or the name of a built-in machine.
        target: name of the target, such as "c", "cortex-m7", "wasm" or "fmu".
        out: folder, which is new or empty.
        precision: "double" or "single".
        wait_for: function that calls the one that compiles and writes, and returns its result; such as in a thread.

    Returns:
        The files that were written.

    Raises:
        InputError: there is no such target or precision, or the folder is not empty.
        KindError: the control law is plain Python.
        OutputError: the folder can't be made or written, or the disk is full.
    """
    from layflat.description.wrong import did_you_mean  # noqa: PLC0415  # the names of the targets are read at a key
    from layflat.machine import load  # noqa: PLC0415

    if target not in TARGET_WRITERS:
        raise InputError(f"{target!r} is not a target", where="target", right=did_you_mean(target, TARGET_WRITERS))
    folder = Path(out)
    is_used = folder.exists() and (not folder.is_dir() or any(folder.iterdir()))
    if is_used and not is_forced():
        raise InputError(f"{folder} is no empty folder", where="out", right="give the name of a new one")
    module, function = TARGET_WRITERS[target].split(":")
    write: Callable[..., Any] = getattr(import_module(module), function)
    described = load(machine)
    with nullcontext(folder) if is_used else whole_folder(folder, ()) as place:
        written = wait_for(lambda: list(write(described, place, target=target, precision=precision)))
    return [folder / path.relative_to(place) for path in written]
