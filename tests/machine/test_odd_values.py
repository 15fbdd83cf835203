"""Every value of every sort of description replaced by what it can't be: one line, which names the place."""

from __future__ import annotations

import copy
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from math import inf, nan
from pathlib import Path
from typing import Any

import pytest

from layflat.cell.file import loader as cells
from layflat.cell.file.model import Cell
from layflat.errors import InputError
from layflat.identify.benches.loader import bench_tables, build_bench
from layflat.identify.logs.mapping import parse_mapping
from layflat.machine import build
from layflat.machine.loader import BENCH_LIBRARY, tables

ODD: list[Any] = [
    None, True, 0, -1, 3, 1e14, -1e300, 1e300, 5e-324, inf, nan, "", "x", "3", "1 kg", "1 m", "-1 Pa", "1e300 m",
    "1e-300 s", "9**9 kg", "2,5 kg", "\0", "x" * 500, [], [1], ["1 m"], [[1]], {}, {"a": 1}, {"kind": "x"},
    {"value": 1},
]  # fmt: skip

PRIVATE = r"(?i)\binput\b|pydantic|\bshould\b|type=|instance|dictionary|\btuple\b|\bstr\b|NoneType|traceback"
"""Words of those who wrote the libraries."""


def below(plain: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Paths of all tables, lists and values."""
    if path:
        yield path
    for key, value in plain.items() if isinstance(plain, dict) else enumerate(plain) if isinstance(plain, list) else []:
        yield from below(value, (*path, key))


def replaced(plain: dict[str, Any], path: tuple[Any, ...], value: Any) -> dict[str, Any]:
    copied = copy.deepcopy(plain)
    table: Any = copied
    for key in path[:-1]:
        table = table[key]
    table[path[-1]] = value
    return copied


def refused(make: Callable[[dict[str, Any]], Any], plain: dict[str, Any], every: int = 1) -> int:
    """How many odd values are refused; all others are taken."""
    count = 0
    for i, path in enumerate(below(plain)):
        for j, value in enumerate(ODD):
            if (i + j) % every:
                continue
            try:
                make(replaced(plain, path, value))
            except InputError as error:
                count += 1
                line = str(error)
                assert line.startswith("f.toml"), (path, value, line)
                assert len(line.splitlines()) == 1, (path, value, line)
                assert len(line) < 600, (path, value, line)
                assert not re.search(PRIVATE, line.replace(repr(value), "")), (path, value, line)
    return count


@pytest.mark.parametrize("name", ["paper-small-joint-switching", "earlier-actuator"])
def test_machines(name: str) -> None:
    assert refused(lambda plain: build(plain, {}, "f.toml"), tables(name)[0], every=13) > 300


@pytest.mark.parametrize("name", BENCH_LIBRARY.names)
def test_benches(name: str) -> None:
    assert refused(lambda plain: build_bench(plain, "f.toml"), bench_tables(name)[0]) > 300


def test_cells() -> None:
    described, _ = cells.CELL_LIBRARY.tables("packing")
    plain = {key: value for key, value in described.items() if key not in {"machine", "container"}}
    made = refused(lambda plain: cells._validate(Cell, plain, "f.toml"), plain, every=31)
    assert made > 200


def test_mappings() -> None:
    column = {
        "from": "p",
        "signal": "pressure_a",
        "joint": "elbow",
        "unit": "kPa",
        "gauge": True,
        "sign": 1,
        "scale": 1.0,
    }
    plain = {"ambient": "1 bar", "time": {"column": "t", "unit": "s"}, "column": [column]}
    assert refused(lambda plain: parse_mapping(plain, "f.toml"), plain) > 150


def test_nothing_has_to_be_written_to_read_a_description(tmp_path: Path) -> None:
    home = tmp_path / "home"
    home.write_text("a file in place of a folder")
    mine = tmp_path / "mine.toml"
    mine.write_text('extends = "paper-arm"\n[joint.large.link]\nlength = "16 inch"\n')
    code = f"from layflat.machine import load; print(load({str(mine)!r}).joint['large'].link.length)"
    places = {"HOME": str(home), "XDG_CACHE_HOME": str(home), "LAYFLAT_CACHE_DIR": str(home)}
    path = ":".join(one for one in sys.path if one)
    done = subprocess.run(
        [sys.executable, "-c", code], env=places | {"PYTHONPATH": path}, capture_output=True, text=True, check=True
    )
    assert float(done.stdout) == pytest.approx(0.4064)


def test_a_description_is_read_without_the_compiler_numpy_and_pint() -> None:
    heavy = ("numba", "llvmlite", "numpy", "pint", "scipy", "xarray", "matplotlib")
    code = f"import sys; from layflat.machine import load; load('paper-arm'); print({{*{heavy}}} & {{*sys.modules}})"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"
