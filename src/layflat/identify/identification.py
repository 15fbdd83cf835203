"""Identification from files to files: logs and a description in, a fitted description and its figures out.

Where several laws may explain the logs, each is fitted, and the simplest that predicts as well as any is chosen.
"""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import cached_property
from math import isfinite
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from layflat.arrays import Dataset
from layflat.errors import InputError
from layflat.files import check_folder, write_text
from layflat.identify.benches import BenchDescription, Logs
from layflat.identify.benches.loader import description_tables, load_description, parse_blocks, select_bench
from layflat.identify.fit import Fit, FittedParameter, fit
from layflat.identify.fit.result import choose_simplest, relative_error
from layflat.identify.fit.search import RANDOM_STARTS, Progress
from layflat.identify.fit.selection import fit_selected
from layflat.identify.identified_file import WrittenValue, identified_path, write_identified, written_values
from layflat.identify.logs import find_issues, raise_first_error, read_log, read_table
from layflat.identify.logs.checks.channels import Issue, merge_issues, name_several, prepare_log
from layflat.identify.logs.checks.presence import NOTHING_MOVES
from layflat.identify.model import Model
from layflat.machine import Machine


@dataclass(frozen=True)
class LawCandidate:
    """Law that logs may obey: its name, a description with it, and the model of that."""

    name: str
    described: Machine | BenchDescription
    model: Model
    replaces: Mapping[str, Any] = field(default_factory=dict)
    """Whole parts that replace those of the first description, by path; none for the first description itself."""


def compare_candidates(candidates: Sequence[LawCandidate], fit_candidate: Callable[[int, LawCandidate], Fit]) -> Fit:
    """Fit every candidate, the simplest first, and return the chosen fit; its model gets a remark on the choice.

    The simplest whose error is equivalent to the least (`choose_simplest`) is chosen, by errors in the validation, or
    in the fitted samples where there is none. A search that the user stops ends the comparison: its fit is returned.
    """
    fits: list[Fit] = []
    for number, candidate in enumerate(candidates):
        fits.append(fit_candidate(number, candidate))
        if fits[-1].partial:
            return fits[-1]
    if len(fits) == 1:
        return fits[0]
    errors = [relative_error(fit.predictions or fit.qualities()) for fit in fits]
    chosen = choose_simplest(errors)
    fits[chosen].model.remarks = (
        *fits[chosen].model.remarks,
        _comparison_remark([candidate.name for candidate in candidates], errors, chosen),
    )
    return fits[chosen]


def _comparison_remark(names: Sequence[str], errors: Sequence[float], chosen: int) -> str:
    """Return a sentence on the errors of all candidates and the chosen one."""
    each = ", ".join(f"{name} {100.0 * error:.2g} %" for name, error in zip(names, errors, strict=True))
    best = int(np.argmin(errors))
    if best == chosen:
        why = f"{names[chosen]} predicts best"
    else:
        why = f"{names[best]} predicts no better than the simpler {names[chosen]}: the logs can't tell them apart"
    return f"Kinds compared by what they miss of the validation's range: {each}. {why[0].upper()}{why[1:]}."


MAX_NAMED_VALUES = 3  # parameters, or excitations, named in a message
ESTIMATE_FIELDS = ("value", "low", "high", "identified", "at_bound", "partner")  # of an estimate in the JSON file


@dataclass(frozen=True)
class Identification:
    """Logs and a description, ready to be fitted."""

    source: str  # built-in name or file of the description
    described: Machine | BenchDescription  # description that the fit begins with
    logs: Logs  # fitted
    validation: Logs  # logs that are only predicted
    issues: Mapping[str, Sequence[Issue]]  # by log
    blocks: Sequence[str]  # groups of parameters that are fitted
    candidates: Sequence[LawCandidate]  # the description, or several that differ in a law
    path: Path  # of the fitted description

    @property
    def model(self) -> Model:
        """Model of the first description."""
        return next(candidate.model for candidate in self.candidates if not candidate.replaces)

    def fit(self, *, starts: int = RANDOM_STARTS, seed: int = 0, progress: Progress | None = None) -> Fit:
        """Fit the model, or several and choose the one that predicts best: see `compare_candidates`.

        Args:
            starts: random starts of the search, besides the description's values.
            seed: seed of the starts.
            progress: called with the fraction that is done and a text.
        """
        count = len(self.candidates)

        def fit_candidate(number: int, candidate: LawCandidate) -> Fit:
            """Fit the candidate of this number, and report its progress as a part of the whole."""

            def report_progress(fraction: float, text: str) -> None:
                if progress is not None:
                    progress((number + fraction) / count, f"{candidate.name}: {text}" if count > 1 else text)

            search = fit_selected if candidate.model.cross_validated else fit
            return search(candidate.model, starts=starts, seed=seed, progress=report_progress)

        return compare_candidates(self.candidates, fit_candidate)

    def fitted_candidate(self, result: Fit) -> LawCandidate:
        """Return the candidate of a fit; the first one where the fit chose among its own models."""
        return next((candidate for candidate in self.candidates if candidate.model is result.model), self.candidates[0])

    @cached_property
    def checksums(self) -> dict[str, str]:
        """Checksums of the fitted logs, by name."""
        return {name: str(log.attrs.get("log_sha256", "unknown")) for name, log in self.logs.items()}

    def values(self, result: Fit) -> list[WrittenValue]:
        """Return the fitted values in the units of the description."""
        return written_values(result, self.fitted_candidate(result).described, description_tables(self.source)[0])

    @property
    def figures_path(self) -> Path:
        """JSON file of all figures."""
        return self.path.with_suffix(".json")

    def write_figures(self, result: Fit) -> Path:
        """Write all figures of a fit as JSON, even those that no description holds, and return the path."""
        return write_text(self.figures_path, json.dumps(_json_values(self.figures(result)), indent=2, allow_nan=False))

    def write_results(self, result: Fit) -> Machine | BenchDescription:
        """Write all figures as JSON and the fitted description, and return the description as loaded again.

        Raises:
            InputError: the description can't be written, or can't hold the fitted values; the figures are kept.
        """
        self.write_figures(result)
        return self.write_description(result)

    def write_description(self, result: Fit) -> Machine | BenchDescription:
        """Write the fitted description and return it as loaded again; raise InputError as `write_results` does."""
        candidate = self.fitted_candidate(result)
        return write_identified(self.source, candidate.described, result, self.checksums, self.path, candidate.replaces)

    def check_writable(self) -> None:
        """Try to write each candidate's description, with its first values, to a temporary folder before a long fit.

        Raises:
            InputError: no description can be written for the result.
        """
        for candidate in self.candidates:
            model, guess = candidate.model, candidate.model.guess
            estimates = [
                FittedParameter(unknown, value, unknown.low, unknown.high, False)
                for unknown, value in zip(model.unknowns, guess, strict=True)
            ]
            trial = Fit(model, tuple(estimates), model.measured, True, 0)
            with TemporaryDirectory(prefix="layflat-") as folder:
                path = Path(folder) / self.path.name
                try:
                    write_identified(self.source, candidate.described, trial, self.checksums, path, candidate.replaces)
                except InputError as error:
                    problem = f"the result could not be written there ({str(error).replace(f'{path}: ', '')})"
                    right = "mend the description, or give a copy with another name"
                    raise InputError(problem, where=str(self.path), right=right) from None

    def figures(self, result: Fit) -> dict[str, Any]:
        """Return all figures of a fit, SI, by the keys of the JSON file.

        They are description, blocks, logs (checksums by name), converged, trusted, partial, simulations, remarks,
        values (by path: unit and `ESTIMATE_FIELDS`), errors (items of `Quality`) and expected (items of `Expected`).
        """
        return {
            "description": self.source,
            "blocks": list(self.blocks),
            "logs": self.checksums,
            "converged": result.converged,
            "trusted": result.trusted,
            "partial": result.partial,
            "simulations": result.simulations,
            "remarks": list(result.remarks),
            "values": {
                estimate.unknown.path: {"unit": estimate.unknown.unit}
                | {key: getattr(estimate, key) for key in ESTIMATE_FIELDS}
                for estimate in result.estimates
            },
            "errors": [vars(quality) for quality in result.qualities()],
            "expected": [asdict(error) for error in result.expected],
        }


def prepare_identification(
    logs: Sequence[str | Path],
    described: str | Path,
    out: Path,
    *,
    blocks: str | None = None,
    validate: Sequence[str | Path] = (),
    mapping: str | Path | None = None,
) -> Identification:
    """Read and check logs and description, and return the session that fits them.

    For a bench on an even clock each log begins where all its signals are known; a warning states the cut.

    Args:
        logs: files to fit.
        described: built-in name or file of a machine or a bench.
        out: folder for the results.
        blocks: groups of parameters to fit, such as "valve, hose"; default: those of the bench.
        validate: logs that are only predicted; without any, the last third of each log is.
        mapping: mapping of the logs' columns, or its file.

    Raises:
        InputError: a log, the description or an argument is wrong.
        OutputError: the folder can't be written to.
    """
    start = load_description(described)
    path = identified_path(str(described), start, out)
    check_folder(out, path.name, *(path.with_suffix(suffix).name for suffix in (".json", ".html")), costly=True)
    machine = start if isinstance(start, Machine) else None
    joints = list(machine.joints) if machine is not None else None
    tables = {name: read_table(file) for name, file in _index_files([*map(Path, logs), *map(Path, validate)]).items()}
    whole_logs = {name: read_log(table, mapping, joints=joints) for name, table in tables.items()}
    fitted = list(whole_logs)[: len(logs)]
    bench = select_bench(start, {name: whole_logs[name] for name in fitted})
    chosen = parse_blocks(bench, blocks)
    read, issues = {}, {}
    for name, table in tables.items():
        found_issues = find_issues(whole_logs[name], machine)
        if [issue for issue in found_issues if issue.severity == "error"] == [NOTHING_MOVES]:
            sequence = " (`layflat excite` writes such a sequence)" if machine is not None else ""
            _refuse_stationary(
                bench.model(start, {name: whole_logs[name]}, {}, blocks=chosen), sequence, str(table.path)
            )
        raise_first_error(found_issues, str(table.path))
        cycle = machine.cycle if machine is not None and bench.even else None
        log = read_log(table, mapping, joints=joints, cycle=cycle, as_recorded=not bench.even)
        read[name], late = _cut_unknown_start(log) if bench.even else (log, [])
        issues[name] = merge_issues([*found_issues, *late])
    of_fit = {name: log for name, log in read.items() if name in fitted}
    others = {name: log for name, log in read.items() if name not in fitted}
    kinds = bench.alternatives(start, of_fit, chosen) or {"": (start, {})}
    candidates = [
        LawCandidate(name, description, bench.model(description, of_fit, others, blocks=chosen), replaces)
        for name, (description, replaces) in kinds.items()
    ]
    session = Identification(str(described), start, of_fit, others, issues, chosen, candidates, path)
    session.check_writable()
    return session


def _index_files(files: Sequence[Path]) -> dict[str, Path]:
    """Return files by the names of their logs, without folder and suffix; raise InputError if two have one name."""
    file_by_name: dict[str, Path] = {}
    for file in files:
        if file.stem in file_by_name:
            problem = (
                "is given twice"
                if file == file_by_name[file.stem]
                else f"has the same name as {file_by_name[file.stem]}"
            )
            raise InputError(problem, where=str(file), right="give every log once, under a name of its own")
        file_by_name[file.stem] = file
    return file_by_name


def _cut_unknown_start(log: Dataset) -> tuple[Dataset, list[Issue]]:
    """Return a log from where every signal is known, its time from 0, and a warning; as it is where no cut helps."""
    channels = [channel for channel in prepare_log(log, None).channels.values() if channel.samples.size]
    finite = np.isfinite(np.stack([channel.values for channel in channels]))
    if finite[:, 0].all() or not finite.all(axis=0).any():
        return log, []
    first = int(np.argmax(finite.all(axis=0)))
    late_channels = [channel.name for channel, row in zip(channels, finite, strict=True) if not row[:first].all()]
    cut = float(log["time"][first])
    rest = log.isel(time=slice(first, None))
    rest = rest.assign_coords(time=("time", rest["time"].to_numpy() - cut, log["time"].attrs))
    rest.attrs["log_start"] = float(log.attrs["log_start"]) + cut
    text = f"is not known from the log's start on; its first {cut:.3g} s are left out"
    return rest, [Issue("warning", name_several(late_channels), text, "a simulation begins with all signals")]


def _refuse_stationary(model: Model, sequence: str, file: str) -> None:
    """Raise InputError for a log in which nothing moves, naming parameters, experiments to record, and `sequence`."""
    unknowns = [unknown for unknown in model.unknowns if not unknown.nuisance]
    excitations = list(dict.fromkeys(unknown.excitation for unknown in unknowns if unknown.excitation))
    problem = f"{NOTHING_MOVES.text}: it can't identify {_name_first([unknown.path for unknown in unknowns])}"
    raise InputError(problem, where=file, right=f"record {_name_first(excitations, '; ')}{sequence}")


def _json_values(figures: Any) -> Any:
    """Return figures with None for numbers that are not finite, which JSON can't hold."""
    if isinstance(figures, dict):
        return {key: _json_values(value) for key, value in figures.items()}
    if isinstance(figures, (list, tuple)):
        return [_json_values(value) for value in figures]
    return None if isinstance(figures, float) and not isfinite(figures) else figures


def _name_first(names: Sequence[str], between: str = ", ") -> str:
    """Return the first `MAX_NAMED_VALUES` names as one text, with the number of the others."""
    more = len(names) - MAX_NAMED_VALUES
    return between.join(names[:MAX_NAMED_VALUES]) + (f" and {more} more" if more > 0 else "")
