"""A study from its first chunk, or where it was stopped, to its table: rows are simulated and measured in chunks."""

from collections.abc import Callable, Generator, Iterable
from contextlib import closing
from math import ceil
from pathlib import Path
from typing import TYPE_CHECKING, Any

from layflat.errors import InputError, StoppedError
from layflat.extras import require
from layflat.sim.ensemble.parallel import check_device
from layflat.study.chunks import Work, made_with, measured
from layflat.study.cluster import on_cluster
from layflat.study.folder import Folder
from layflat.study.sampling import rows, samples
from layflat.study.study import Study

if TYPE_CHECKING:
    import pyarrow

CHUNKS = {"cpu": 4096, "cuda": 65536}
"""Runs that a device works on at once and that are kept together: what is lost at most when a study is stopped."""

Progress = Callable[[int, int], None]


def run(
    study: Study,
    out: str | Path,
    *,
    scheduler: str | None = None,
    device: str = "cpu",
    progress: Progress | None = None,
    threads: int | None = None,
    chunk: int | None = None,
) -> Path:
    """Run a study, or what is left of it where it was stopped before.

    Args:
        study: what to run.
        out: folder for the results; new, empty, or of the same study.
        scheduler: address of a Dask cluster's scheduler that does the work, such as "tcp://10.0.0.1:8786".
        device: that makes the runs here, "cpu" or "cuda".
        progress: is called with the runs done so far, and with how many there are.
        threads: how many work at a time here; default: one a core.
        chunk: runs that are kept together; default: as suits the device.

    Returns:
        The table's file: rows in order, the same whatever did the work and how often it was stopped.

    Raises:
        ChangedError: the folder holds another study.
        OutputError: the folder can't be used, or the disk is too full.
        InputError: no cluster answers, the device can't be used, or a part that is needed is not installed.
        StoppedError: the user stopped it (Ctrl-C); the same call goes on.
    """
    require("study", "pyarrow", where="study")
    if scheduler is not None and device != "cpu":
        raise InputError("a cluster works on its processors", where="--device", right="leave out --scheduler")
    check_device(device)
    chunk = CHUNKS[device] if chunk is None else chunk
    if chunk < 1:
        raise InputError(f"{chunk} is out of range", where="chunk", right="give 1 or more")
    folder = Folder(Path(out), ceil(study.rows / chunk))
    left = folder.chunks - len(folder.done())
    folder.check_space(min(left * chunk, study.rows), study.columns, left)
    if not study.fits:
        what = f"{study.samples:,} samples are more than can be held in memory"
        raise InputError(what, where=study.file.name, right="give fewer, or divide it into several studies")
    with folder.opened(_content(study, chunk, device)):
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
                if scheduler is None:
                    tables = ((number, measured(study, runs, device, threads, tell)) for number, runs in work)
                else:
                    tables = _on_cluster(study, work, scheduler, tell)
                with closing(tables):
                    for number, table in tables:
                        folder.keep(number, table)
            except KeyboardInterrupt:
                kept = f"{sum(folder.done().values())} of {study.rows} runs"
                folder.mark(kept)
                raise StoppedError(kept, folder.place) from None
        return folder.table if folder.table.exists() else folder.join()


def finished(study: Study, out: str | Path, *, chunk: int | None = None) -> bool:
    """Return whether a folder holds the whole table of this very study, made with what is installed here."""
    folder = Folder(Path(out), 1)
    contents = (_content(study, chunk or usual, device) for device, usual in CHUNKS.items())
    return folder.table.exists() and any(map(folder.holds, contents))


def _content(study: Study, chunk: int, device: str) -> dict[str, Any]:
    """All that decides about the last bit of a study's files."""
    return {**study.canonical(), "chunk": chunk, "device": device, "made_with": made_with(study)}


def _on_cluster(
    study: Study, work: Work, scheduler: str, tell: Callable[[int], None]
) -> "Generator[tuple[int, pyarrow.Table]]":
    """Yield chunks as they get done on a cluster, in any order."""
    for number, table in on_cluster(study, work, scheduler):
        yield number, table
        tell(table.num_rows)


def _work(study: Study, chunk: int, left: Iterable[int]) -> Work:
    drawn = samples(study.varied, study.file)
    seeds = [scenario.seed for scenario in study.scenarios]
    counts = study.samples, len(study.variants)
    for first in (number * chunk for number in left):
        last = min(first + chunk, study.rows)
        yield first // chunk, rows(drawn, *counts, seeds, study.file.noise_seeds, first, last)
