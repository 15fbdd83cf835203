"""A study from its first chunk, or where it was stopped, to its table: rows are simulated and measured in chunks."""

from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import closing
from hashlib import sha256
from importlib.metadata import version
from math import ceil
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import layflat
from layflat.arrays import Array
from layflat.errors import InputError, StoppedError
from layflat.extras import require
from layflat.jit.cache import source_digest
from layflat.sim.ensemble import ensemble
from layflat.sim.ensemble import kernel as ensemble_kernel
from layflat.sim.ensemble.parallel import check_device
from layflat.study.folder import Folder
from layflat.study.sampling import rows, samples
from layflat.study.study import Study
from layflat.study.varied import applied

if TYPE_CHECKING:
    import pyarrow
    import xarray

CHUNKS = {"cpu": 4096, "cuda": 65536}
"""Runs that a device works on at once and that are kept together: what is lost at most when a study is stopped."""

Progress = Callable[[int, int], None]
Work = Iterable[tuple[int, dict[str, Array]]]  # numbers of chunks, and their runs


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
    """Chunks as they get done on a cluster, in any order."""
    from layflat.study.cluster import on_cluster  # noqa: PLC0415

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


def made_with(study: Study) -> dict[str, str]:
    """Return what decides, besides the study, about the last bit of its table."""
    libraries = {name: version(name) for name in ("numpy", "scipy", "numba")}
    files = [Path(path) for one in study.variants for path in one.machine.kinds]
    kinds = {path.name: sha256(path.read_bytes()).hexdigest()[:16] for path in files}
    return {"layflat": layflat.__version__, "laws": source_digest(Path(ensemble_kernel.__file__)), **kinds, **libraries}


def measured(
    study: Study,
    runs: dict[str, Array],
    device: str = "cpu",
    threads: int | None = None,
    progress: Callable[[int], None] | None = None,
) -> "pyarrow.Table":
    """Simulate rows of a study; every column has its unit in its metadata."""
    import pyarrow  # noqa: PLC0415

    parts = []
    for number in np.unique(runs["variant"]):  # rows come variant by variant
        own = np.flatnonzero(runs["variant"] == number)
        rows = {key: values[own] for key, values in runs.items()}
        parts.append(_of_one_machine(study, int(number), rows, device=device, threads=threads, progress=progress))
    return pyarrow.concat_tables(parts)


def _of_one_machine(study: Study, number: int, runs: dict[str, Array], **how: Any) -> "pyarrow.Table":
    import pyarrow  # noqa: PLC0415

    variant = study.variants[number]
    vary: dict[str, Array] = {key: runs[key] for key in ("scenario", "seed")}
    vary |= applied(study.varied, runs, variant.machine)
    (band, tip_band), given = study.bands, (variant.machine, study.scenarios, vary)
    how |= {"metrics": study.metrics, "precision": study.precision}
    data = ensemble(*given, step=study.step, band=band, tip_band=tip_band, **how)
    names = np.array(study.scenario_names)[runs["scenario"].astype(int)]
    columns = [
        *([("variant", np.full(len(names), variant.name), "1")] if variant.name else []),
        ("sample", runs["sample"], "1"),
        ("scenario", names, "1"),
        ("noise_seed", runs["seed"], "1"),
        *((one.path, runs[one.path], one.kind.unit) for one in study.varied),
        *(column for metric in (*study.metrics, "diverged") for column in _flat(data, metric)),
    ]
    arrays = [pyarrow.array(values) for _, values, _ in columns]
    fields = [
        pyarrow.field(name, array.type, metadata={"unit": unit})
        for (name, _, unit), array in zip(columns, arrays, strict=True)
    ]
    return pyarrow.Table.from_arrays(arrays, schema=pyarrow.schema(fields))


def measured_there(study: Study, runs: dict[str, Array], expected: dict[str, str]) -> "pyarrow.Table":
    """Do the same on a worker of a cluster, whose other threads have rows of their own.

    Raises:
        InputError: the worker has other versions than the one who asks.
    """
    own = made_with(study)
    other = [f"{key} {own[key]}, not {expected[key]}" for key in own if own[key] != expected[key]]
    if other:
        raise InputError(f"a worker has {other[0]}", where="--scheduler", right="install the same on all workers")
    return measured(study, runs, threads=1)


def _flat(data: "xarray.Dataset", metric: str) -> Iterator[tuple[str, Any, str]]:
    """Columns of a metric, such as "settling.small.0" for joint small in move 0."""
    array = data[metric]
    order = [dimension for dimension in ("joint", "move") if dimension in array.dims]
    labels = [[str(label) for label in data[dimension].to_numpy()] for dimension in order]
    values = array.transpose("run", *order).to_numpy()
    for place in np.ndindex(values.shape[1:]):
        name = ".".join([metric, *(labels[i][k] for i, k in enumerate(place))])
        yield name, values[(slice(None), *place)], array.attrs["units"]
