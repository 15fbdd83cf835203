"""Rows of a study, simulated and measured: the same on this machine and on a worker of a cluster."""

from collections.abc import Callable, Iterable, Iterator
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from layflat._version import __version__
from layflat.arrays import Array
from layflat.errors import InputError
from layflat.jit.cache import source_digest
from layflat.sim.ensemble import ensemble
from layflat.sim.ensemble import kernel as ensemble_kernel
from layflat.study.study import Study
from layflat.study.varied import applied

if TYPE_CHECKING:
    import pyarrow
    import xarray

Work = Iterable[tuple[int, dict[str, Array]]]  # numbers of chunks, and their runs


def made_with(study: Study) -> dict[str, str]:
    """Return what decides, besides the study, about the last bit of its table."""
    libraries = {name: version(name) for name in ("numpy", "scipy", "numba")}
    files = [Path(path) for one in study.variants for path in one.machine.kinds]
    kinds = {path.name: sha256(path.read_bytes()).hexdigest()[:16] for path in files}
    return {"layflat": __version__, "laws": source_digest(Path(ensemble_kernel.__file__)), **kinds, **libraries}


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
