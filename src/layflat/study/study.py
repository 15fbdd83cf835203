"""A study: what is simulated, and what varies, read from its file and checked."""

from dataclasses import dataclass, replace
from math import prod
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from layflat.description.library import Library
from layflat.errors import InputError
from layflat.machine import Machine
from layflat.motion.scenario import SIGNALS, Scenario
from layflat.sim import STEP
from layflat.sim.ensemble.cases import cases
from layflat.sim.ensemble.parallel import LONGEST_SINGLE, TIP_BAND
from layflat.sim.metrics import BAND
from layflat.study.check import check, inside
from layflat.study.description import ScenarioTable, StudyFile, explained_study, refuse
from layflat.study.sampling import samples
from layflat.study.varied import Variant, Varied, applied, groups, resolved, variants

BUILT_IN = Path(__file__).parent / "builtin"

STUDIES = Library(BUILT_IN, "study", "`layflat studies` lists them", 'low = "1 kg"', InputError)

MOST_HELD = 50_000_000  # numbers that the samples of a study may be: 400 MB, and as much again for each of some copies


@dataclass(frozen=True)
class Study:
    """A study that can be run."""

    file: StudyFile  # as it was written
    variants: tuple[Variant, ...]  # the machines that it compares; one of no name where it has but one
    scenarios: tuple[Scenario, ...]  # each sample runs in every one
    varied: tuple[Varied, ...]  # what varies, by path in alphabetical order
    metrics: tuple[str, ...]  # names of the metrics to keep

    @property
    def name(self) -> str:
        """Name of the study."""
        return self.file.name

    @property
    def machine(self) -> Machine:
        """The first of its machines."""
        return self.variants[0].machine

    @property
    def samples(self) -> int:
        """Return how many there are of each machine."""
        if self.file.sampling == "grid":
            return prod(one.count for one in self.varied)
        assert self.file.runs is not None
        return self.file.runs * (2 + len(self.blocks) if self.file.sampling == "saltelli" else 1)

    @property
    def fits(self) -> bool:
        """True if all samples can be held in memory at once, as they are drawn."""
        return self.samples * len(self.varied) <= MOST_HELD

    @property
    def blocks(self) -> list[str]:
        """Return what has sensitivity indices, in their order: everything that varies, then the groups."""
        return [*(one.path for one in self.varied), *groups(self.varied)]

    @property
    def rows(self) -> int:
        """Runs in all: every sample of every machine in every scenario with every seed of the noise."""
        return len(self.variants) * self.samples * len(self.scenarios) * self.file.noise_seeds

    @property
    def step(self) -> float:
        """Step of the plant, s."""
        return self.file.step or STEP

    @property
    def precision(self) -> str:
        """In which the runs are computed: single unless the file asks for another or they last too long for it."""
        return self.file.precision or ("single" if _lasting(self.file) <= LONGEST_SINGLE else "double")

    @property
    def columns(self) -> int:
        """Columns of the table, at most: every metric of every joint in every move."""
        each = cases(self.machine, list(self.scenarios), {}, 1).most_moves * len(self.machine.joints)
        return 5 + len(self.varied) + len(self.metrics) * each

    @property
    def bands(self) -> tuple[float, float]:
        """Within these of its goal a joint (rad) and the tip (m) have settled."""
        return self.file.band or BAND, self.file.tip_band or TIP_BAND

    @property
    def scenario_names(self) -> list[str]:
        """Names of scenarios as they stand in the table: their numbers where they have no names."""
        return [table.name or str(i) for i, table in enumerate(self.file.scenario)]

    def canonical(self) -> dict[str, Any]:
        """All that decides about the table, in SI units: equal for files that say the same in other words."""
        apart = {"vary", "machine", "metrics", "variant"}
        written = self.file.model_dump(mode="json", exclude_none=True, exclude=apart)
        written |= {"metrics": list(self.metrics), "precision": self.precision}
        written |= {"vary": {one.path: one.canonical() for one in self.varied}}
        # What the files of kinds hold counts, not where they are: see `made_with`.
        machines = {one.name: one.machine.model_dump(mode="json", exclude={"kinds"}) for one in self.variants}
        return {"study": written, **({"variant": machines} if self.file.variant else {"machine": machines[""]})}

    def thinned(self, points: int) -> "Study":
        """The same with at most so many samples of each thing that varies, and without repetitions: for a first look.

        Args:
            points: on each axis of a grid; otherwise samples in all, of `saltelli` in each of its blocks.
        """
        runs = None if self.file.runs is None else min(points, self.file.runs)
        varied = tuple(one.thinned(points) if runs is None else one for one in self.varied)
        return replace(self, file=self.file.model_copy(update={"runs": runs, "noise_seeds": 1}), varied=varied)


def names() -> tuple[str, ...]:
    """Return the names of the built-in studies."""
    return STUDIES.names


def read(path: str | Path) -> Study:
    """Return a study from its TOML file, or a built-in one by its name.

    Raises:
        InputError: in one line, which file, key and value is wrong and what would be right.
    """
    where = str(path)
    try:
        file = StudyFile.model_validate(STUDIES.raw(path))
    except ValidationError as error:
        raise explained_study(error, where) from None
    compared = variants(file, Path(path).parent, where)
    found = [
        tuple(
            resolved(key, value, one.machine, file.sampling, f"{where}: vary.{key}")
            for key, value in sorted(file.vary.items())
        )
        for one in compared
    ]
    _check_runs(file, found[0], where)
    scenarios = tuple(_scenario(table, file, f"{where}: scenario.{i}.") for i, table in enumerate(file.scenario))
    study = Study(file, compared, scenarios, found[0], _metrics(file.metrics, where))
    if where not in names() and study.fits:  # the built-in ones are checked by tests; others than these never run
        check_samples(study, where)
    return study


def check_samples(study: Study, where: str) -> None:
    """Refuse a study whose runs can't all be, or in which something varies that does not matter."""
    drawn = samples(study.varied, study.file)
    along = [path for one in study.varied for path in one.members]
    for one in study.variants:
        check(one.machine, study.scenarios, applied(study.varied, drawn, one.machine), study.step, where, along)


def _lasting(file: StudyFile) -> float:
    """Return how long its longest runs are, s."""
    return max(table.duration for table in file.scenario)


def _check_runs(file: StudyFile, varied: tuple[Varied, ...], where: str) -> None:
    paths = [path for one in varied for path in one.paths]
    twice = [path for i, path in enumerate(paths) if path in paths[:i]]
    named = [table.name or str(i) for i, table in enumerate(file.scenario)]
    drawn, count = file.sampling != "grid", file.runs or 0
    above = 1 << count.bit_length()
    odd = file.sampling in {"sobol", "saltelli"} and count.bit_count() != 1
    balanced = f"Sobol points are balanced in powers of two: give {above // 2} or {above}"
    noisy = all(table.noise for table in file.scenario)
    coarse = file.precision == "single" and _lasting(file) > LONGEST_SINGLE
    refuse(
        f"{where}: ",
        (coarse, "precision", f"single is too coarse for runs of {_lasting(file):g} s; leave it out, or say double"),
        (file.noise_seeds > 1 and not noisy, "noise_seeds", "has no effect on runs without noise; leave it out"),
        (bool(twice), "vary", f"{''.join(twice[:1])} varies twice; vary it once"),
        (drawn and not varied, "vary", 'nothing varies; say what, or use sampling = "grid"'),
        (drawn and file.runs is None, "runs", "is missing; say how many samples, such as 1024"),
        (odd, "runs", f"{file.runs} is not a power of two; {balanced}"),
        (len(set(named)) < len(named), "scenario.name", "two have the same name; give each its own"),
    )


def _scenario(table: ScenarioTable, file: StudyFile, where: str) -> Scenario:
    """Return a scenario, in which what varies takes the place of a constant (InputError: naming the key)."""
    varied = {*file.vary, *(path for one in file.vary.values() for path in one.also)}
    given = {key: getattr(table, key) for key in table.model_fields_set - {"name"}}
    replaced = [name for name, row in SIGNALS.items() if row.varies == "replaces"]
    hidden = [key for key in replaced if f"scenario.{key}" in varied and isinstance(given.get(key), float)]
    with inside(where, set(ScenarioTable.model_fields)):
        return Scenario(**{key: value for key, value in given.items() if key not in hidden})


def _metrics(names: tuple[str, ...] | None, where: str) -> tuple[str, ...]:
    from layflat.sim.ensemble.dataset import METRICS  # noqa: PLC0415  # xarray takes long to import

    if names is not None and not names:
        right = "give one or more, or leave it out for all"
        raise InputError("is empty", where=f"{where}: metrics", right=right)
    unknown = [name for name in names or () if name not in METRICS]
    if unknown:
        what = f"{unknown[0]!r} is not a metric"
        raise InputError(what, where=f"{where}: metrics", right=f"use {', '.join(METRICS)}")
    return tuple(name for name in METRICS if names is None or name in names)
