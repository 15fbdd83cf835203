"""Study: machines, scenarios and varied values, read from its file and checked."""

from dataclasses import dataclass, replace
from math import prod
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from layflat.description.library import Library
from layflat.errors import InputError
from layflat.machine import Machine
from layflat.motion.scenario import SIGNALS, Scenario
from layflat.sim import STEP
from layflat.sim.ensemble.cases import prepare_cases
from layflat.sim.ensemble.parallel import MAX_SINGLE_DURATION
from layflat.sim.metrics import SETTLING_BAND, TIP_BAND
from layflat.study.built import BUILT_UNITS, check_built
from layflat.study.check import check_runs, locate_errors
from layflat.study.description import ScenarioTable, StudyFile, check_rules, explain_study_error
from layflat.study.sampling import draw_samples
from layflat.study.varied import StudyAxis, Variant, group_axes, load_variants, machine_values, resolve_axis

if TYPE_CHECKING:
    from layflat.solids.cost import Prices

BUILT_IN = Path(__file__).parent / "builtin"

STUDY_LIBRARY = Library(BUILT_IN, "study", "`layflat study list` lists them", 'low = "1 kg"', InputError)

MAX_SAMPLE_NUMBERS = (
    50_000_000  # numbers that the samples of a study may be: 400 MB, and as much again for each of some copies
)


@dataclass(frozen=True)
class Study:
    """Study that is checked and can be run."""

    file: StudyFile
    variants: tuple[Variant, ...]  # compared machines; a single one has no name
    scenarios: tuple[Scenario, ...]  # each sample runs in every one
    varied: tuple[StudyAxis, ...]  # what varies, by path in alphabetical order
    metrics: tuple[str, ...]  # names of the metrics to keep
    prices: "Prices | None" = None  # of the parts, for the cost

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
        """Number of samples of each machine."""
        if self.file.sampling == "grid":
            return prod(one.count for one in self.varied)
        assert self.file.runs is not None
        return self.file.runs * (2 + len(self.blocks) if self.file.sampling == "saltelli" else 1)

    @property
    def fits_in_memory(self) -> bool:
        """True if all samples can be held in memory."""
        return self.samples * len(self.varied) <= MAX_SAMPLE_NUMBERS

    @property
    def blocks(self) -> list[str]:
        """Names of axes and groups in the order of sensitivity indices: paths, then groups."""
        return [*(one.path for one in self.varied), *group_axes(self.varied)]

    @property
    def rows(self) -> int:
        """Number of runs: samples x machines x scenarios x noise seeds."""
        return len(self.variants) * self.samples * len(self.scenarios) * self.file.noise_seeds

    @property
    def step(self) -> float:
        """Step of the plant, s."""
        return self.file.step or STEP

    @property
    def precision(self) -> str:
        """Precision of the runs: the file's; by default single, unless they last too long for it."""
        return self.file.precision or ("single" if _longest_duration(self.file) <= MAX_SINGLE_DURATION else "double")

    @property
    def columns(self) -> int:
        """Upper bound of the number of columns of the table."""
        each = prepare_cases(self.machine, list(self.scenarios), {}, 1).max_moves * len(self.machine.joints)
        return 5 + len(self.varied) + len(self.metrics) * each

    @property
    def bands(self) -> tuple[float, float]:
        """Settling bands of joints (rad) and tip (m)."""
        return self.file.band or SETTLING_BAND, self.file.tip_band or TIP_BAND

    @property
    def scenario_names(self) -> list[str]:
        """Names of scenarios in the table: their indices if they have no names."""
        return [table.name or str(i) for i, table in enumerate(self.file.scenario)]

    def canonical(self) -> dict[str, Any]:
        """Return the content on which the table depends, in SI units: equal for equivalent files.

        Keys are study, and machine (its description) or variant (descriptions by name).
        """
        apart = {"vary", "machine", "metrics", "variant", "prices"}
        written = self.file.model_dump(mode="json", exclude_none=True, exclude=apart)
        written |= {"metrics": list(self.metrics), "precision": self.precision}
        written |= {} if self.prices is None else {"prices": self.prices.model_dump(mode="json")}
        written |= {"vary": {one.path: one.canonical() for one in self.varied}}
        # What the files of kinds hold counts, not where they are: see `made_with`.
        machines = {one.name: one.machine.model_dump(mode="json", exclude={"kinds"}) for one in self.variants}
        return {"study": written, **({"variant": machines} if self.file.variant else {"machine": machines[""]})}

    def thinned(self, points: int) -> "Study":
        """Return the study with fewer samples and one noise seed, for a first overview.

        Args:
            points: maximum on each axis of a grid; else of samples in all, with `saltelli` in each block.
        """
        runs = None if self.file.runs is None else min(points, self.file.runs)
        varied = tuple(one.thinned(points) if runs is None else one for one in self.varied)
        return replace(self, file=self.file.model_copy(update={"runs": runs, "noise_seeds": 1}), varied=varied)


def study_names() -> tuple[str, ...]:
    """Return the names of the built-in studies."""
    return STUDY_LIBRARY.names


def read_study(path: str | Path) -> Study:
    """Return a study from its TOML file, or a built-in one by its name.

    The samples of a file's study that fit in memory are drawn and checked, too.

    Raises:
        InputError: in one line, which file, key and value is wrong and what would be right.
    """
    where = str(path)
    try:
        file = StudyFile.model_validate(STUDY_LIBRARY.raw(path))
    except ValidationError as error:
        raise explain_study_error(error, where) from None
    compared = load_variants(file, Path(path).parent, where)
    axes = [
        tuple(
            resolve_axis(key, value, variant.machine, file.sampling, f"{where}: vary.{key}")
            for key, value in sorted(file.vary.items())
        )
        for variant in compared
    ]
    _check_runs(file, axes[0], where)
    scenarios = tuple(_build_scenario(table, file, f"{where}: scenario.{i}.") for i, table in enumerate(file.scenario))
    metrics, prices = _check_metrics(file.metrics, where), _read_prices(file, Path(path).parent)
    study = Study(file, compared, scenarios, axes[0], metrics, prices)
    for variant in compared:
        check_built(variant.machine, prices, metrics, where)
    if (
        where not in study_names() and study.fits_in_memory
    ):  # the built-in ones are checked by tests; others than these never run
        check_samples(study, where)
    return study


def _read_prices(file: StudyFile, folder: Path) -> "Prices | None":
    """Return the prices of a study whose file is in a folder, if it has any."""
    if file.prices is None:
        return None
    from layflat.solids.cost import read_prices  # noqa: PLC0415  # most studies have none

    return read_prices(folder / file.prices)


def check_samples(study: Study, where: str) -> None:
    """Refuse a study with invalid runs, or with a varied value without effect."""
    drawn = draw_samples(study.varied, study.file)
    built = bool(BUILT_UNITS.keys() & study.metrics)
    along = [path for axis in study.varied for path in axis.members or (axis.paths if built else ())]
    for variant in study.variants:
        check_runs(
            variant.machine,
            study.scenarios,
            machine_values(study.varied, drawn, variant.machine),
            study.step,
            where,
            along,
        )


def _longest_duration(file: StudyFile) -> float:
    """Return the duration of the longest scenario, s."""
    return max(table.duration for table in file.scenario)


def _check_runs(file: StudyFile, varied: tuple[StudyAxis, ...], where: str) -> None:
    """Raise InputError for the first rule of sampling, seeds and names that a study breaks."""
    paths = [path for one in varied for path in one.paths]
    twice = [path for i, path in enumerate(paths) if path in paths[:i]]
    named = [table.name or str(i) for i, table in enumerate(file.scenario)]
    drawn, count = file.sampling != "grid", file.runs or 0
    above = 1 << count.bit_length()
    odd = file.sampling in {"sobol", "saltelli"} and count.bit_count() != 1
    balanced = f"Sobol points are balanced in powers of two: give {above // 2} or {above}"
    noisy = all(table.noise for table in file.scenario)
    coarse = file.precision == "single" and _longest_duration(file) > MAX_SINGLE_DURATION
    check_rules(
        f"{where}: ",
        (
            coarse,
            "precision",
            f"single is too coarse for runs of {_longest_duration(file):g} s; leave it out, or say double",
        ),
        (file.noise_seeds > 1 and not noisy, "noise_seeds", "has no effect on runs without noise; leave it out"),
        (bool(twice), "vary", f"{''.join(twice[:1])} varies twice; vary it once"),
        (drawn and not varied, "vary", 'nothing varies; say what, or use sampling = "grid"'),
        (drawn and file.runs is None, "runs", "is missing; say how many samples, such as 1024"),
        (odd, "runs", f"{file.runs} is not a power of two; {balanced}"),
        (len(set(named)) < len(named), "scenario.name", "two have the same name; give each its own"),
    )


def _build_scenario(table: ScenarioTable, file: StudyFile, where: str) -> Scenario:
    """Return a scenario without the constants that varied values replace (InputError: naming the key)."""
    varied = {*file.vary, *(path for one in file.vary.values() for path in one.also)}
    signals = {key: getattr(table, key) for key in table.model_fields_set - {"name"}}
    replaced = [name for name, row in SIGNALS.items() if row.varies == "replaces"]
    hidden = [key for key in replaced if f"scenario.{key}" in varied and isinstance(signals.get(key), float)]
    with locate_errors(where, set(ScenarioTable.model_fields)):
        return Scenario(**{key: value for key, value in signals.items() if key not in hidden})


def _check_metrics(names: tuple[str, ...] | None, where: str) -> tuple[str, ...]:
    """Return the chosen metrics in their order, all of runs for None; InputError for an unknown one, or none."""
    from layflat.sim.results import METRICS  # noqa: PLC0415  # xarray takes long to import

    if names is not None and not names:
        right = "give one or more, or leave it out for all"
        raise InputError("is empty", where=f"{where}: metrics", right=right)
    known = (*METRICS, *BUILT_UNITS)
    unknown = [name for name in names or () if name not in known]
    if unknown:
        what = f"{unknown[0]!r} is not a metric"
        raise InputError(what, where=f"{where}: metrics", right=f"use {', '.join(known)}")
    return METRICS if names is None else tuple(name for name in known if name in names)
