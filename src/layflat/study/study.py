"""A study: what is simulated, and what varies, read from its file and checked."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from math import prod
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from layflat.errors import InputError
from layflat.machine import Machine, load
from layflat.sim import STEP, Scenario
from layflat.sim.ensemble.parallel import TIP_BAND
from layflat.sim.metrics import BAND
from layflat.study.check import check
from layflat.study.description import ScenarioTable, StudyFile, explained
from layflat.study.kinds import kind
from layflat.study.sampling import samples
from layflat.study.varied import Varied, resolved


@dataclass(frozen=True)
class Study:
    """A study that can be run.

    Args:
        file: as it was written.
        machine: that is varied.
        scenarios: each sample runs in every one.
        varied: what varies, by path in alphabetical order.
        metrics: names of the metrics to keep.
    """

    file: StudyFile
    machine: Machine
    scenarios: tuple[Scenario, ...]
    varied: tuple[Varied, ...]
    metrics: tuple[str, ...]

    @property
    def name(self) -> str:
        """Of the study."""
        return self.file.name

    @property
    def samples(self) -> int:
        """How many there are."""
        if self.file.sampling == "grid":
            return prod(len(one.grid()) for one in self.varied)
        assert self.file.runs is not None
        return self.file.runs

    @property
    def rows(self) -> int:
        """Runs in all: every sample in every scenario with every seed of the noise."""
        return self.samples * len(self.scenarios) * self.file.noise_seeds

    @property
    def step(self) -> float:
        """Of the plant, s."""
        return self.file.step or STEP

    @property
    def bands(self) -> tuple[float, float]:
        """Within these of its goal a joint (rad) and the tip (m) have settled."""
        return self.file.band or BAND, self.file.tip_band or TIP_BAND

    @property
    def scenario_names(self) -> list[str]:
        """As they stand in the table: their numbers where they have no names."""
        return [table.name or str(i) for i, table in enumerate(self.file.scenario)]

    def canonical(self) -> dict[str, Any]:
        """All that decides about the table, in SI units: equal for files that say the same in other words."""
        written = self.file.model_dump(mode="json", exclude_none=True, exclude={"vary", "machine", "metrics"})
        written |= {"metrics": list(self.metrics), "vary": {one.path: one.canonical() for one in self.varied}}
        return {"study": written, "machine": self.machine.model_dump(mode="json")}


def read(path: str | Path) -> Study:
    """A study from its TOML file.

    Raises:
        InputError: in one line, which file, key and value is wrong and what would be right.
    """
    where = str(path)
    file = _file(Path(path), where)
    machine = load(_machine_place(Path(path), file.machine))
    given = sorted(file.vary.items())
    varied = tuple(_varied(key, value, file.sampling, machine, f"{where}: vary.{key}") for key, value in given)
    _check_runs(file, varied, where)
    scenarios = tuple(_scenario(table, file) for table in file.scenario)
    study = Study(file, machine, scenarios, varied, _metrics(file.metrics, where))
    names = study.scenario_names
    if len(set(names)) < len(names):
        raise InputError("two have the same name", where=f"{where}: scenario.name", right="give each its own")
    check(machine, scenarios, samples(varied, file), study.step, where)
    return study


def _file(path: Path, where: str) -> StudyFile:
    try:
        return StudyFile.model_validate(tomllib.loads(path.read_text(encoding="utf-8")))
    except OSError as error:
        raise InputError(f"can't be read ({error.strerror})", where=where, right="give a study's TOML file") from None
    except UnicodeDecodeError:
        raise InputError("is not a text file in UTF-8", where=where, right="give a study's TOML file") from None
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"is not TOML: {error}", where=where, right='values look like low = "1 kg"') from None
    except ValidationError as error:
        raise explained(error.errors()[0], where) from None


def _machine_place(path: Path, machine: str) -> str:
    """A file is meant relative to the study's file."""
    return str(path.parent / machine) if machine.endswith(".toml") else machine


def _varied(path: str, given: Any, sampling: str, machine: Machine, where: str) -> Varied:
    return resolved(path, given, kind(machine, path, where), sampling, where)


def _check_runs(file: StudyFile, varied: tuple[Varied, ...], where: str) -> None:
    if file.noise_seeds > 1 and not all(table.noise for table in file.scenario):
        raise InputError("has no effect on runs without noise", where=f"{where}: noise_seeds", right="leave it out")
    if file.sampling == "grid":
        return
    if not varied:
        raise InputError("nothing varies", where=f"{where}: vary", right='say what, or use sampling = "grid"')
    if file.runs is None:
        raise InputError("is missing", where=f"{where}: runs", right="say how many samples, such as 1024")
    if file.sampling == "sobol" and file.runs.bit_count() != 1:
        above = 1 << file.runs.bit_length()
        right = f"Sobol points are balanced in powers of two: give {above // 2} or {above}"
        raise InputError(f"{file.runs} is no power of two", where=f"{where}: runs", right=right)


def _scenario(table: ScenarioTable, file: StudyFile) -> Scenario:
    """What varies takes the place of a constant."""
    given = {key: getattr(table, key) for key in table.model_fields_set - {"name"}}
    for key in ("payload", "supply"):
        if f"scenario.{key}" in file.vary and isinstance(given.get(key), float):
            del given[key]
    return Scenario(**given)


def _metrics(names: tuple[str, ...] | None, where: str) -> tuple[str, ...]:
    from layflat.sim.ensemble.dataset import UNITS  # noqa: PLC0415  # xarray takes long to import

    known = [name for name in UNITS if name != "diverged"]
    unknown = [name for name in names or () if name not in known]
    if unknown:
        raise InputError(f"{unknown[0]!r} is no metric", where=f"{where}: metrics", right=f"use {', '.join(known)}")
    return tuple(name for name in known if names is None or name in names)
