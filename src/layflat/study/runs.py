"""A study from its first chunk, or where it was stopped, to its table: chunks computed here, or on a Dask cluster."""

import asyncio
import logging
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import closing
from itertools import islice
from math import ceil
from pathlib import Path
from typing import TYPE_CHECKING, Any

from layflat.errors import InputError, LayflatError, StoppedError
from layflat.extras import module, require
from layflat.sim.ensemble.parallel import check_device
from layflat.study.chunks import Work, made_with, measured, measured_there
from layflat.study.folder import Folder
from layflat.study.sampling import rows, samples
from layflat.study.study import Study

if TYPE_CHECKING:
    import pyarrow

PATIENCE = 4.0  # a scheduler has to answer within, s
AHEAD = 64  # chunks that wait at the scheduler, beside two for every thread: new workers find work at once


def on_cluster(study: Study, work: Work, scheduler: str) -> "Iterator[tuple[int, pyarrow.Table]]":
    """Yield chunks of a study as they get done, in any order.

    Raises:
        InputError: no scheduler answers, dask is not installed, or a chunk can't be done there.
    """
    where = f"--scheduler {scheduler}"
    client = _client(scheduler, where)
    try:
        yield from _done(client, study, work)
    except LayflatError:
        raise
    except Exception as error:  # whatever a cluster may raise
        what = f"the cluster failed ({type(error).__name__}: {''.join(str(error).splitlines()[:1])})"
        raise InputError(what, where=where, right="the same command goes on") from error
    finally:
        client.close()


def _done(client: Any, study: Study, work: Work) -> "Iterator[tuple[int, pyarrow.Table]]":
    from distributed import as_completed  # noqa: PLC0415

    waiting, numbers, own = iter(work), {}, made_with(study)

    def submit(count: int) -> list[Any]:
        futures = []
        for number, runs in islice(waiting, count):
            future = client.submit(measured_there, study, runs, own, pure=False)
            numbers[future.key] = number
            futures.append(future)
        return futures

    ahead = AHEAD + 2 * sum(client.nthreads().values())
    running = as_completed(submit(ahead), loop=client.loop, with_results=True)
    for future, table in running:
        if isinstance(table, BaseException):  # the scheduler is lost
            raise table
        for following in submit(1):
            running.add(following)
        yield numbers.pop(future.key), table


def _client(scheduler: str, where: str) -> Any:
    client = module("cluster", "distributed", where=where).Client
    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)  # what fails is told in one line, by us
    try:
        asyncio.run(asyncio.wait_for(_identity(scheduler), PATIENCE))
        return client(scheduler, timeout=PATIENCE, set_as_default=False)
    except Exception:  # of many libraries, depending on what else answers there
        right = "give the address that `dask scheduler` prints, such as tcp://10.0.0.1:8786"
        raise InputError("no Dask scheduler answers", where=where, right=right) from None


async def _identity(scheduler: str) -> None:
    """Ask a scheduler who it is: a client that finds none can't be closed without another long wait."""
    from distributed import Security  # noqa: PLC0415
    from distributed.core import rpc  # noqa: PLC0415

    security = Security().get_connection_args("client")
    async with rpc(scheduler, connection_args=security, timeout=PATIENCE) as remote:
        await remote.identity()


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
