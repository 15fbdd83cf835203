"""Command about machine code: where it is kept, and which of it is prebuilt."""

import shutil
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated

import typer

from layflat.cli.common import count_noun, print_table
from layflat.cli.groups import app
from layflat.errors import OutputError


@app.register("cache", "", "--clear")
def show_cache(
    clear: Annotated[bool, typer.Option("--clear", help="remove what was compiled on this computer")] = False,
) -> None:
    """Show where machine code is kept, and how much.

    What was compiled on this computer is kept for other runs, as are the solids that the panel draws; what came with
    layflat for usual processors is used first, the fastest that this computer can run. Where neither fits, kernels are
    compiled.
    """
    from layflat.jit.cache import cache_root, cached_folders  # noqa: PLC0415

    root = cache_root()
    folders = cached_folders(root)
    size = _describe(path for folder in folders for path in folder.rglob("*"))
    if not clear:
        print_table(["machine code", "", "state"], [["compiled here", size, str(root)], *_prebuilt_rows()])
        return
    for folder in folders:
        try:
            shutil.rmtree(folder)
        except OSError as error:
            problem, right = f"can't be removed ({error.strerror})", "see who owns it"
            raise OutputError(problem, where=str(folder), right=right) from None
    typer.echo(f"removed {size} of {root}")


def _prebuilt_rows() -> list[list[str]]:
    """Return a row for each folder of prebuilt machine code: its name, content and use."""
    from layflat.jit.stored import PREBUILT_FOLDER, find_stale_sources, host_levels, prebuilt_levels  # noqa: PLC0415

    levels = prebuilt_levels()
    if not levels:
        return [["prebuilt", "none", f"there is no {PREBUILT_FOLDER}: kernels are compiled once"]]
    stale = find_stale_sources()
    fitting = "of other sources: " + ", ".join(stale) if stale else "fits this computer"
    return [
        [
            f"prebuilt {level}",
            _describe((PREBUILT_FOLDER / level).iterdir()),
            fitting if level in host_levels() else "not for this computer",
        ]
        for level in levels
    ]


def _describe(paths: Iterable[Path]) -> str:
    """Return the number and the size of files."""
    sizes = [path.stat().st_size for path in paths if path.is_file()]
    return f"{count_noun(len(sizes), 'file')}, {sum(sizes) / 1e6:.1f} MB"
