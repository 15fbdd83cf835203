"""Execution of a study, from its first chunk or where it was stopped, to its table: here, or on a Dask cluster.

Rows are simulated in the same way on this machine and on a worker of a cluster.
"""

import asyncio
import logging
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import closing
from hashlib import sha256
from importlib.metadata import version
from itertools import islice
from math import ceil
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from layflat._version import __version__
from layflat.arrays import Array
from layflat.errors import InputError, LayflatError, StoppedError
from layflat.extras import import_extra, require
from layflat.jit.cache import source_digest
from layflat.sim.ensemble import ensemble
from layflat.sim.ensemble import kernel as ensemble_kernel
from layflat.sim.ensemble.parallel import check_device
from layflat.study.built import BUILT_UNITS, built_columns, rules_digest
from layflat.study.folder import StudyFolder
from layflat.study.sampling import draw_samples, study_rows
from layflat.study.study import Study
from layflat.study.varied import machine_values

if TYPE_CHECKING:
    import pyarrow
    import xarray


Work = Iterable[tuple[int, dict[str, Array]]]  # numbers of chunks, and their runs


def software_versions(study: Study) -> dict[str, str]:
    """Return what a table's bits depend on: versions by library, digests by user's kind (file name) and of sources."""
    libraries = {name: version(name) for name in ("numpy", "scipy", "numba")}
    files = [Path(path) for variant in study.variants for path in variant.machine.kinds]
    kinds = {path.name: sha256(path.read_bytes()).hexdigest()[:16] for path in files}
    built = {"rules": rules_digest()} if BUILT_UNITS.keys() & study.metrics else {}
    return {
        "layflat": __version__,
        **built,
        "laws": source_digest(Path(ensemble_kernel.__file__)),
        **kinds,
        **libraries,
    }


def simulate_rows(
    study: Study,
    runs: dict[str, Array],
    device: str = "cpu",
    threads: int | None = None,
    progress: Callable[[int], None] | None = None,
) -> "pyarrow.Table":
    """Simulate rows of a study.

    Args:
        study: study to which the rows belong.
        runs: one value per row, by path, as of `study_rows`.
        device: "cpu" or "cuda".
        threads: number of threads; default: one per core.
        progress: called with the number of rows that are newly finished.

    Returns:
        Table, variant by variant, with a column's unit in its metadata.
    """
    import pyarrow  # noqa: PLC0415

    parts = []
    for number in np.unique(runs["variant"]):  # rows come variant by variant
        selected = np.flatnonzero(runs["variant"] == number)
        rows = {key: values[selected] for key, values in runs.items()}
        parts.append(_simulate_variant(study, int(number), rows, device=device, threads=threads, progress=progress))
    return pyarrow.concat_tables(parts)


def _simulate_variant(study: Study, number: int, runs: dict[str, Array], **how: Any) -> "pyarrow.Table":
    """Simulate rows of one variant of the machine, and return their table of inputs and metrics, with units."""
    import pyarrow  # noqa: PLC0415

    variant = study.variants[number]
    vary: dict[str, Array] = {key: runs[key] for key in ("scenario", "seed")}
    vary |= machine_values(study.varied, runs, variant.machine)
    (band, tip_band), given = study.bands, (variant.machine, study.scenarios, vary)
    simulated = [name for name in study.metrics if name not in BUILT_UNITS]
    how |= {"metrics": simulated, "precision": study.precision}
    data = ensemble(*given, step=study.step, band=band, tip_band=tip_band, **how)
    names = np.array(study.scenario_names)[runs["scenario"].astype(int)]
    columns = [
        *([("variant", np.full(len(names), variant.name), "1")] if variant.name else []),
        ("sample", runs["sample"], "1"),
        ("scenario", names, "1"),
        ("noise_seed", runs["seed"], "1"),
        *((one.path, runs[one.path], one.kind.unit) for one in study.varied),
        *(column for metric in (*simulated, "diverged") for column in _metric_columns(data, metric)),
        *built_columns(variant.machine, vary, study.metrics, study.prices),
    ]
    arrays = [pyarrow.array(values) for _, values, _ in columns]
    fields = [
        pyarrow.field(name, array.type, metadata={"unit": unit})
        for (name, _, unit), array in zip(columns, arrays, strict=True)
    ]
    return pyarrow.Table.from_arrays(arrays, schema=pyarrow.schema(fields))


def simulate_rows_on_worker(study: Study, runs: dict[str, Array], expected: dict[str, str]) -> "pyarrow.Table":
    """Simulate rows on a worker of a cluster, in one thread.

    Args:
        study: study to which the rows belong.
        runs: one value per row, by path.
        expected: versions of the client, as of `software_versions`.

    Raises:
        InputError: the worker has other versions than the client.
    """
    versions = software_versions(study)
    other = [f"{key} {versions[key]}, not {expected[key]}" for key in versions if versions[key] != expected[key]]
    if other:
        raise InputError(f"a worker has {other[0]}", where="scheduler", right="install the same on all workers")
    return simulate_rows(study, runs, threads=1)


def _metric_columns(data: "xarray.Dataset", metric: str) -> Iterator[tuple[str, Any, str]]:
    """Yield name, values and unit of a metric's columns, such as "settling.small.0" for joint small in move 0."""
    array = data[metric]
    order = [dimension for dimension in ("joint", "move") if dimension in array.dims]
    labels = [[str(label) for label in data[dimension].to_numpy()] for dimension in order]
    values = array.transpose("run", *order).to_numpy()
    for place in np.ndindex(values.shape[1:]):
        name = ".".join([metric, *(labels[i][k] for i, k in enumerate(place))])
        yield name, values[(slice(None), *place)], array.attrs["units"]


SCHEDULER_TIMEOUT = 4.0  # for a scheduler's response, s
QUEUED_CHUNKS = 64  # at the scheduler, besides two per thread, so that new workers start at once


def simulate_on_cluster(study: Study, work: Work, scheduler: str) -> "Iterator[tuple[int, pyarrow.Table]]":
    """Yield number and table of each chunk of a study as it is completed, in any order.

    Args:
        study: study to run.
        work: indices of chunks and their rows.
        scheduler: address.

    Raises:
        InputError: no scheduler answers, dask is not installed, or a chunk can't be done there.
    """
    where = f"scheduler {scheduler}"
    client = _connect_client(scheduler, where)
    try:
        yield from _completed_chunks(client, study, work)
    except LayflatError:
        raise
    except Exception as error:  # whatever a cluster may raise
        what = f"the cluster failed ({type(error).__name__}: {''.join(str(error).splitlines()[:1])})"
        raise InputError(what, where=where, right="the same command goes on") from error
    finally:
        client.close()


def _completed_chunks(client: Any, study: Study, work: Work) -> "Iterator[tuple[int, pyarrow.Table]]":
    """Yield number and table of each chunk as a cluster completes it, with a limited number of chunks queued.

    What a worker raises is raised here, as is the loss of the scheduler.
    """
    from distributed import as_completed  # noqa: PLC0415

    waiting, numbers, own = iter(work), {}, software_versions(study)

    def submit(count: int) -> list[Any]:
        """Submit the next `count` chunks, or as many as are left, without waiting; return their futures."""
        futures = []
        for number, runs in islice(waiting, count):
            future = client.submit(simulate_rows_on_worker, study, runs, own, pure=False)
            numbers[future.key] = number
            futures.append(future)
        return futures

    ahead = QUEUED_CHUNKS + 2 * sum(client.nthreads().values())
    running = as_completed(submit(ahead), loop=client.loop, with_results=True)
    for future, table in running:
        if isinstance(table, BaseException):  # the scheduler is lost
            raise table
        for following in submit(1):
            running.add(following)
        yield numbers.pop(future.key), table


def _connect_client(scheduler: str, where: str) -> Any:
    """Return a client of a Dask scheduler, with its log silenced.

    Raise InputError if no scheduler answers within `SCHEDULER_TIMEOUT`.
    """
    client = import_extra("cluster", "distributed", where=where).Client
    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)  # what fails is told in one line, by us
    try:
        asyncio.run(asyncio.wait_for(_check_scheduler(scheduler), SCHEDULER_TIMEOUT))
        return client(scheduler, timeout=SCHEDULER_TIMEOUT, set_as_default=False)
    except Exception:  # of many libraries, depending on what else answers there
        right = "give the address that `dask scheduler` prints, such as tcp://10.0.0.1:8786"
        raise InputError("no Dask scheduler answers", where=where, right=right) from None


async def _check_scheduler(scheduler: str) -> None:
    """Query a scheduler's identity, and raise if none answers: a client without a scheduler takes long to close."""
    from distributed import Security  # noqa: PLC0415
    from distributed.core import rpc  # noqa: PLC0415

    security = Security().get_connection_args("client")
    async with rpc(scheduler, connection_args=security, timeout=SCHEDULER_TIMEOUT) as remote:
        await remote.identity()


CHUNK_SIZES = {"cpu": 4096, "cuda": 65536}
"""Runs per chunk, which a device computes together and which are saved together; a stopped study loses one chunk."""

Progress = Callable[[int, int], None]


def run_study(
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
        study: study to run.
        out: folder for the results; new, empty, or of the same study.
        scheduler: address of a Dask cluster's scheduler that does the work, such as "tcp://10.0.0.1:8786".
        device: device that makes the runs here, "cpu" or "cuda".
        progress: called with the number of runs done so far, and of all runs.
        threads: number of threads here; default: one a core.
        chunk: number of runs that are saved together; default: that of `CHUNK_SIZES` for the device.

    Returns:
        The table's file: rows in order, the same whatever did the work and how often it was stopped.

    Raises:
        ChangedError: the folder holds another study.
        OutputError: the folder can't be used, or the disk is too full.
        InputError: an argument is out of range, memory can't hold the samples, or a cluster, device or part is missing.
        StoppedError: the user stopped it (Ctrl-C); the same call goes on.
    """
    _check_means(scheduler, device)
    chunk = CHUNK_SIZES[device] if chunk is None else chunk
    if chunk < 1:
        raise InputError(f"{chunk} is out of range", where="chunk", right="give 1 or more")
    folder = StudyFolder(Path(out), ceil(study.rows / chunk))
    left = folder.chunks - len(folder.finished_chunks())
    folder.check_space(min(left * chunk, study.rows), study.columns, left)
    if not study.fits_in_memory:
        what = f"{study.samples:,} samples are more than can be held in memory"
        raise InputError(what, where=study.file.name, right="give fewer, or divide it into several studies")
    with folder.lock(_study_content(study, chunk, device)):
        done = folder.finished_chunks()
        ran = sum(done.values())

        def tell(count: int) -> None:
            """Report the number of finished runs, of which `count` are new."""
            nonlocal ran
            ran += count
            if progress is not None:
                progress(ran, study.rows)

        tell(0)
        if len(done) < folder.chunks:
            work = _chunk_rows(study, chunk, [number for number in range(folder.chunks) if number not in done])
            if scheduler is None:
                tables = ((number, simulate_rows(study, runs, device, threads, tell)) for number, runs in work)
            else:
                tables = _report_cluster_chunks(study, work, scheduler, tell)
            _write_chunks(tables, folder, study.rows)
        return folder.table if folder.table.exists() else folder.write_table()


def _check_means(scheduler: str | None, device: str) -> None:
    """Raise InputError if pyarrow is missing, the device can't be used, or one is named for a cluster."""
    require("study", "pyarrow", where="study")
    if scheduler is not None and device != "cpu":
        what = f"a cluster works on its processors, not on {device!r}"
        raise InputError(what, where="device", right="leave out `scheduler`, or `device`")
    check_device(device)


def _write_chunks(tables: "Generator[tuple[int, pyarrow.Table]]", folder: StudyFolder, rows: int) -> None:
    """Write all chunks of a study of so many rows; after Ctrl-C write partial.txt and raise StoppedError."""
    try:
        with closing(tables):
            for number, table in tables:
                folder.write_chunk(number, table)
    except KeyboardInterrupt:
        kept = f"{sum(folder.finished_chunks().values())} of {rows} runs"
        folder.mark_partial(kept)
        raise StoppedError(kept, folder.place) from None


def is_finished(study: Study, out: str | Path, *, chunk: int | None = None) -> bool:
    """Return whether a folder holds the complete table of this study, with the installed versions.

    Args:
        study: expected study.
        out: folder.
        chunk: expected runs per chunk; default: that of any device.
    """
    folder = StudyFolder(Path(out), 1)
    contents = (_study_content(study, chunk or usual, device) for device, usual in CHUNK_SIZES.items())
    return folder.table.exists() and any(map(folder.holds, contents))


def _study_content(study: Study, chunk: int, device: str) -> dict[str, Any]:
    """Return everything on which the bits of a study's files depend."""
    return {**study.canonical(), "chunk": chunk, "device": device, "made_with": software_versions(study)}


def _report_cluster_chunks(
    study: Study, work: Work, scheduler: str, tell: Callable[[int], None]
) -> "Generator[tuple[int, pyarrow.Table]]":
    """Yield chunks as they are completed on a cluster, and report their rows."""
    for number, table in simulate_on_cluster(study, work, scheduler):
        yield number, table
        tell(table.num_rows)


def _chunk_rows(study: Study, chunk: int, left: Iterable[int]) -> Work:
    """Yield the number of each chunk that is left, and its rows of drawn samples, scenarios and seeds."""
    drawn = draw_samples(study.varied, study.file)
    seeds = [scenario.seed for scenario in study.scenarios]
    counts = study.samples, len(study.variants)
    for first in (number * chunk for number in left):
        last = min(first + chunk, study.rows)
        yield first // chunk, study_rows(drawn, *counts, seeds, study.file.noise_seeds, first, last)
