"""Some rows of a study, simulated and measured, as a part of its table."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import layflat
from layflat.errors import InputError
from layflat.jit.cache import source_digest
from layflat.sim.ensemble import ensemble
from layflat.sim.ensemble import kernel as ensemble_kernel
from layflat.study.sampling import Array
from layflat.study.study import Study
from layflat.study.varied import applied

if TYPE_CHECKING:
    import pyarrow
    import xarray


def made_with() -> dict[str, str]:
    """What decides, besides the study, about the last bit of its table."""
    libraries = {name: version(name) for name in ("numpy", "scipy", "numba")}
    return {"layflat": layflat.__version__, "laws": source_digest(Path(ensemble_kernel.__file__)), **libraries}


def measured(
    study: Study,
    runs: dict[str, Array],
    threads: int | None = None,
    progress: Callable[[int], None] | None = None,
) -> pyarrow.Table:
    """Simulate rows of a study; every column has its unit in its metadata."""
    parts = []
    for number in np.unique(runs["variant"]):
        own = np.flatnonzero(runs["variant"] == number)
        parts.append(
            _of_one_machine(study, int(number), {key: values[own] for key, values in runs.items()}, threads, progress)
        )
    import pyarrow  # noqa: PLC0415

    return pyarrow.concat_tables(parts)


def _of_one_machine(
    study: Study,
    number: int,
    runs: dict[str, Array],
    threads: int | None,
    progress: Callable[[int], None] | None,
) -> pyarrow.Table:
    """Rows, which come variant by variant, of one of these."""
    variant = study.variants[number]
    vary: dict[str, Array] = {key: runs[key] for key in ("scenario", "seed")}
    vary |= applied(study.varied, runs, variant.machine)
    (band, tip_band), given = study.bands, (variant.machine, study.scenarios, vary)
    data = ensemble(*given, step=study.step, band=band, tip_band=tip_band, threads=threads, progress=progress)
    names = np.array(study.scenario_names)[runs["scenario"].astype(int)]
    columns = [
        *([("variant", np.full(len(names), variant.name), "1")] if variant.name else []),
        ("sample", runs["sample"], "1"),
        ("scenario", names, "1"),
        ("noise_seed", runs["seed"], "1"),
        *((one.path, runs[one.path], one.kind.unit) for one in study.varied),
        *(column for metric in (*study.metrics, "diverged") for column in _flat(data, metric)),
    ]
    return _arrow(columns)


def measured_there(study: Study, runs: dict[str, Array], expected: dict[str, str]) -> pyarrow.Table:
    """The same on a worker of a cluster, whose other threads have rows of their own.

    Raises:
        InputError: the worker has other versions than the one who asks.
    """
    own = made_with()
    other = [f"{key} {own[key]}, not {expected[key]}" for key in own if own[key] != expected[key]]
    if other:
        raise InputError(f"a worker has {other[0]}", where="--scheduler", right="install the same on all workers")
    return measured(study, runs, threads=1)


def _flat(data: xarray.Dataset, metric: str) -> Iterator[tuple[str, Any, str]]:
    """Columns of a metric, such as "settling.small.0" for joint small in move 0."""
    array = data[metric]
    order = [dimension for dimension in ("joint", "move") if dimension in array.dims]
    values = array.transpose("run", *order).to_numpy()
    labels = [[str(label) for label in data[dimension].to_numpy()] for dimension in order]
    for place in np.ndindex(values.shape[1:]):
        name = ".".join([metric, *(labels[i][k] for i, k in enumerate(place))])
        yield name, values[(slice(None), *place)], array.attrs["units"]


def _arrow(columns: list[tuple[str, Any, str]]) -> pyarrow.Table:
    import pyarrow  # noqa: PLC0415

    arrays = [pyarrow.array(values) for _, values, _ in columns]
    fields = [
        pyarrow.field(name, array.type, metadata={"unit": unit})
        for (name, _, unit), array in zip(columns, arrays, strict=True)
    ]
    return pyarrow.Table.from_arrays(arrays, schema=pyarrow.schema(fields))
