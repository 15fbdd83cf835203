"""A study from its first chunk, or where it was stopped, to its table."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable
from contextlib import closing
from math import ceil
from pathlib import Path
from typing import TYPE_CHECKING, Any

from layflat.errors import InputError, StoppedError
from layflat.extras import require
from layflat.study.chunk import made_with, measured
from layflat.study.folder import Folder
from layflat.study.sampling import Array, rows, samples
from layflat.study.study import Study

if TYPE_CHECKING:
    import pyarrow

CHUNK = 512
"""Runs that are kept together: what is lost at most when a study is stopped."""

Progress = Callable[[int, int], None]
Work = Iterable[tuple[int, dict[str, Array]]]
"""Numbers of chunks, and their runs."""


def run(
    study: Study,
    out: str | Path,
    *,
    scheduler: str | None = None,
    progress: Progress | None = None,
    threads: int | None = None,
    chunk: int = CHUNK,
) -> Path:
    """Run a study, or what is left of it where it was stopped before.

    Args:
        study: what to run.
        out: folder for the results; new, empty, or of the same study.
        scheduler: address of a Dask cluster's scheduler that does the work, such as "tcp://10.0.0.1:8786".
        progress: is called with the runs done so far, and with how many there are.
        threads: how many work at a time here; default: one a core.
        chunk: runs that are kept together.

    Returns:
        The table's file: rows in order, the same whatever did the work and how often it was stopped.

    Raises:
        ChangedError: the folder holds another study.
        OutputError: the folder can't be used, or the disk is too full.
        InputError: no cluster answers, or a part that is needed is not installed.
        StoppedError: the user stopped it (Ctrl-C); the same call goes on.
    """
    require("study", "pyarrow", where="study")
    if chunk < 1:
        raise InputError(f"{chunk} is out of range", where="chunk", right="give 1 or more")
    folder = Folder(Path(out), ceil(study.rows / chunk))
    left = folder.chunks - len(folder.done())
    folder.check_space(min(left * chunk, study.rows), study.columns, left)
    if not study.fits:
        what = f"{study.samples:,} samples are more than can be held in memory"
        raise InputError(what, where=study.file.name, right="give fewer, or divide it into several studies")
    with folder.opened(_content(study, chunk)):
        done = folder.done()
        ran = sum(done.values())

        def tell(count: int) -> None:
            nonlocal ran
            ran += count
            if progress is not None:
                progress(ran, study.rows)

        tell(0)
        if len(done) < folder.chunks:
            work = _work(study, chunk, [number for number in range(folder.chunks) if number not in done])
            try:
                with closing(_tables(study, work, scheduler, threads, tell)) as tables:
                    for number, table in tables:
                        folder.keep(number, table)
            except KeyboardInterrupt:
                kept = f"{sum(folder.done().values())} of {study.rows} runs"
                folder.mark(kept)
                raise StoppedError(kept, folder.place) from None
        return folder.table if folder.table.exists() else folder.join()


def finished(study: Study, out: str | Path, *, chunk: int = CHUNK) -> bool:
    """Return whether a folder holds the whole table of this very study, made with what is installed here."""
    folder = Folder(Path(out), ceil(study.rows / chunk))
    return folder.table.exists() and folder.holds(_content(study, chunk))


def _content(study: Study, chunk: int) -> dict[str, Any]:
    """All that decides about the last bit of a study's files."""
    return {**study.canonical(), "chunk": chunk, "made_with": made_with(study)}


def _tables(
    study: Study, work: Work, scheduler: str | None, threads: int | None, tell: Callable[[int], None]
) -> Generator[tuple[int, pyarrow.Table]]:
    if scheduler is not None:
        from layflat.study.cluster import on_cluster  # noqa: PLC0415

        for number, table in on_cluster(study, work, scheduler):
            yield number, table
            tell(table.num_rows)
        return
    for number, runs in work:
        yield number, measured(study, runs, threads, tell)


def _work(study: Study, chunk: int, left: Iterable[int]) -> Work:
    drawn = samples(study.varied, study.file)
    seeds = [scenario.seed for scenario in study.scenarios]
    counts = study.samples, len(study.variants)
    for first in (number * chunk for number in left):
        last = min(first + chunk, study.rows)
        yield first // chunk, rows(drawn, *counts, seeds, study.file.noise_seeds, first, last)
