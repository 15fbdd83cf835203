"""An identification from files to files: logs and a description in, a fitted description and what it is worth out."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from math import isfinite
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from layflat.arrays import Dataset
from layflat.errors import InputError
from layflat.files import check_folder, write_text
from layflat.identify.benches.contract import BenchDescription, Logs
from layflat.identify.benches.loader import bench_of, chosen_blocks, described_tables, load_described
from layflat.identify.fit import Estimate, Fit, fit
from layflat.identify.fit.search import STARTS, Progress
from layflat.identify.fit.selection import fit_selected
from layflat.identify.identified_file import Written, identified_path, write_identified, written_values
from layflat.identify.kinds import Candidate, compared
from layflat.identify.logs import check, read_log, read_table, refuse
from layflat.identify.logs.checks.channels import Issue, checked_log, ordered, several
from layflat.identify.logs.checks.presence import NOTHING_MOVES
from layflat.identify.model import Model
from layflat.machine import Machine

NAMED = 3  # values, and motions, that are named where there are more
KEPT = ("value", "low", "high", "identified", "at_bound", "partner")  # what the JSON says of an estimate


@dataclass(frozen=True)
class Identification:
    """Logs and a description, ready to be fitted."""

    given: str  # built-in name or file of the description
    described: Machine | BenchDescription  # what it says
    logs: Logs  # to fit
    validation: Logs  # logs that are only predicted
    issues: Mapping[str, Sequence[Issue]]  # what is doubtful in each log
    blocks: Sequence[str]  # what is fitted
    candidates: Sequence[Candidate]  # what is fitted: the description, or several that differ in a law
    path: Path  # where the description that is found is put

    @property
    def model(self) -> Model:
        """The model of the description that was given."""
        return next(one.model for one in self.candidates if not one.replaces)

    def fit(self, *, starts: int = STARTS, seed: int = 0, progress: Progress | None = None) -> Fit:
        """Fit the model, or several and take the one that predicts best: see `layflat.identify.fit` and `compared`."""
        count = len(self.candidates)

        def one(number: int, candidate: Candidate) -> Fit:
            def tell(share: float, text: str) -> None:
                if progress is not None:
                    progress((number + share) / count, f"{candidate.name}: {text}" if count > 1 else text)

            chosen = fit_selected if candidate.model.cross_validated else fit
            return chosen(candidate.model, starts=starts, seed=seed, progress=tell)

        return compared(self.candidates, one)

    def taken(self, found: Fit) -> Candidate:
        """The candidate that a fit is of; the only one where its unknowns were chosen."""
        return next((one for one in self.candidates if one.model is found.model), self.candidates[0])

    @cached_property
    def checksums(self) -> dict[str, str]:
        """Checksums of the fitted logs, by name."""
        return {name: str(log.attrs.get("log_sha256", "unknown")) for name, log in self.logs.items()}

    def values(self, found: Fit) -> list[Written]:
        """Values that were found, in the units of the description."""
        return written_values(found, self.taken(found).described, described_tables(self.given)[0])

    @property
    def figures_path(self) -> Path:
        """The file of all figures."""
        return self.path.with_suffix(".json")

    def keep_figures(self, found: Fit) -> Path:
        """Write all figures of a fit as JSON, first of all: nothing in them has to fit a description."""
        return write_text(self.figures_path, json.dumps(_finite(self.figures(found)), indent=2, allow_nan=False))

    def keep(self, found: Fit) -> Machine | BenchDescription:
        """Write all figures as JSON, and beside them the description, which is loaded again.

        Raises:
            InputError: the description can't be written, or can't hold what was found; the figures are kept.
        """
        self.keep_figures(found)
        return self.keep_description(found)

    def keep_description(self, found: Fit) -> Machine | BenchDescription:
        """Write the description that was found and load it; raise InputError as `keep` does."""
        taken = self.taken(found)
        return write_identified(self.given, taken.described, found, self.checksums, self.path, taken.replaces)

    def try_to_keep(self) -> None:
        """Write what is begun with as if it had been found, elsewhere, so that nothing is lost after a long fit.

        Raises:
            InputError: no description can be written of what will be found.
        """
        for candidate in self.candidates:
            model, guess = candidate.model, candidate.model.guess
            estimates = [
                Estimate(one, at, one.low, one.high, False) for one, at in zip(model.unknowns, guess, strict=True)
            ]
            trial = Fit(model, tuple(estimates), model.measured, True, 0)
            with TemporaryDirectory(prefix="layflat-") as folder:
                path = Path(folder) / self.path.name
                try:
                    write_identified(self.given, candidate.described, trial, self.checksums, path, candidate.replaces)
                except InputError as error:
                    what = f"what will be found could not be written there ({str(error).replace(f'{path}: ', '')})"
                    right = "mend the description, or give a copy with another name"
                    raise InputError(what, where=str(self.path), right=right) from None

    def figures(self, found: Fit) -> dict[str, Any]:
        """All figures of a fit, SI."""
        return {
            "description": self.given,
            "blocks": list(self.blocks),
            "logs": self.checksums,
            "converged": found.converged,
            "trusted": found.trusted,
            "partial": found.partial,
            "simulations": found.simulations,
            "remarks": list(found.remarks),
            "values": {
                one.unknown.path: {"unit": one.unknown.unit} | {key: getattr(one, key) for key in KEPT}
                for one in found.estimates
            },
            "errors": [vars(quality) for quality in found.qualities()],
            "expected": [asdict(one) for one in found.expected],
        }


def begin(
    logs: Sequence[str | Path],
    described: str | Path,
    out: Path,
    *,
    blocks: str | None = None,
    validate: Sequence[str | Path] = (),
    mapping: str | Path | None = None,
) -> Identification:
    """Read and check everything before any work is done.

    Args:
        logs: files to fit.
        described: built-in name or file of a machine or a bench.
        out: folder for the results.
        blocks: what to fit, such as "valve, hose"; default: those of the bench.
        validate: logs that are only predicted; without any, the last third of each log is.
        mapping: what the logs' columns are.

    Raises:
        InputError: in one line, what is wrong with a log, the description or an option.
    """
    start = load_described(described)
    path = identified_path(str(described), start, out)
    check_folder(out, path.name, *(path.with_suffix(suffix).name for suffix in (".json", ".html")), costly=True)
    machine = start if isinstance(start, Machine) else None
    joints = list(machine.joints) if machine is not None else None
    tables = {name: read_table(file) for name, file in _named([*map(Path, logs), *map(Path, validate)]).items()}
    whole = {name: read_log(table, mapping, joints=joints) for name, table in tables.items()}
    fitted = list(whole)[: len(logs)]
    bench = bench_of(start, {name: whole[name] for name in fitted})
    chosen = chosen_blocks(bench, blocks)
    taken, issues = {}, {}
    for name, table in tables.items():
        found = check(whole[name], machine)
        if [issue for issue in found if issue.severity == "error"] == [NOTHING_MOVES]:
            sequence = " (`layflat excite` writes such a sequence)" if machine is not None else ""
            _refuse_rest(bench.model(start, {name: whole[name]}, {}, blocks=chosen), sequence, str(table.path))
        refuse(found, str(table.path))
        cycle = machine.cycle if machine is not None and bench.even else None
        log = read_log(table, mapping, joints=joints, cycle=cycle, as_recorded=not bench.even)
        taken[name], late = _begun(log) if bench.even else (log, [])
        issues[name] = ordered([*found, *late])
    of_fit = {name: log for name, log in taken.items() if name in fitted}
    others = {name: log for name, log in taken.items() if name not in fitted}
    kinds = bench.kinds(start, of_fit, chosen) or {"": (start, {})}
    candidates = [
        Candidate(name, of, bench.model(of, of_fit, others, blocks=chosen), replaces)
        for name, (of, replaces) in kinds.items()
    ]
    session = Identification(str(described), start, of_fit, others, issues, chosen, candidates, path)
    session.try_to_keep()
    return session


def _named(files: Sequence[Path]) -> dict[str, Path]:
    """Files by the names of their logs, each its own."""
    found: dict[str, Path] = {}
    for file in files:
        if file.stem in found:
            what = "is given twice" if file == found[file.stem] else f"has the same name as {found[file.stem]}"
            raise InputError(what, where=str(file), right="give every log once, under a name of its own")
        found[file.stem] = file
    return found


def _begun(log: Dataset) -> tuple[Dataset, list[Issue]]:
    """Cut a log to begin where every signal is known, as a simulation begins with all of them; and say what is cut."""
    channels = [channel for channel in checked_log(log, None).channels.values() if channel.known.size]
    known = np.isfinite(np.stack([channel.values for channel in channels]))
    if known[:, 0].all() or not known.all(axis=0).any():
        return log, []
    first = int(np.argmax(known.all(axis=0)))
    late = [channel.name for channel, row in zip(channels, known, strict=True) if not row[:first].all()]
    left = float(log["time"][first])
    rest = log.isel(time=slice(first, None))
    rest = rest.assign_coords(time=("time", rest["time"].to_numpy() - left, log["time"].attrs))
    rest.attrs["log_start"] = float(log.attrs["log_start"]) + left
    text = f"is not known from the log's start on; its first {left:.3g} s are left out"
    return rest, [Issue("warning", several(late), text, "a simulation begins with all signals")]


def _refuse_rest(model: Model, sequence: str, file: str) -> None:
    """Refuse a log in which nothing moves: say what it can't identify, and what to record."""
    unknowns = [one for one in model.unknowns if not one.nuisance]
    excitations = list(dict.fromkeys(one.excitation for one in unknowns if one.excitation))
    what = f"{NOTHING_MOVES.text}: it can't identify {_first([one.path for one in unknowns])}"
    raise InputError(what, where=file, right=f"record {_first(excitations, '; ')}{sequence}")


def _finite(figures: Any) -> Any:
    """Figures as JSON holds them: what is no finite number is null."""
    if isinstance(figures, dict):
        return {key: _finite(value) for key, value in figures.items()}
    if isinstance(figures, (list, tuple)):
        return [_finite(value) for value in figures]
    return None if isinstance(figures, float) and not isfinite(figures) else figures


def _first(names: Sequence[str], between: str = ", ") -> str:
    more = len(names) - NAMED
    return between.join(names[:NAMED]) + (f" and {more} more" if more > 0 else "")
