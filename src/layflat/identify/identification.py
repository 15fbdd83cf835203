"""An identification from files to files: logs and a description in, a fitted description and what it is worth out."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from layflat.files import check_folder, whole_file
from layflat.identify.benches.contract import BenchDescription
from layflat.identify.benches.loader import described_tables, load_described
from layflat.identify.fit import Fit, fit
from layflat.identify.fit.search import STARTS, Progress
from layflat.identify.identified_file import Written, identified_path, write_identified, written_values
from layflat.identify.logs import Issue
from layflat.identify.model import Model
from layflat.identify.reading import recorded
from layflat.machine import Machine

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True)
class Identification:
    """Logs and a description, ready to be fitted.

    Args:
        given: built-in name or file of the description.
        described: what it says.
        logs: to fit, by name.
        validation: logs that are only predicted.
        issues: what is doubtful in each log.
        blocks: what is fitted.
        model: that is fitted.
        path: where the description that is found is put.
    """

    given: str
    described: Machine | BenchDescription
    logs: Mapping[str, xarray.Dataset]
    validation: Mapping[str, xarray.Dataset]
    issues: Mapping[str, Sequence[Issue]]
    blocks: Sequence[str]
    model: Model
    path: Path

    def fit(self, *, starts: int = STARTS, seed: int = 0, progress: Progress | None = None) -> Fit:
        """Fit the model: see `layflat.identify.fit`."""
        return fit(self.model, starts=starts, seed=seed, progress=progress)

    @cached_property
    def checksums(self) -> dict[str, str]:
        """Of the fitted logs, by name."""
        return {name: str(log.attrs.get("log_sha256", "unknown")) for name, log in self.logs.items()}

    def values(self, found: Fit) -> list[Written]:
        """What was found, in the units of the description."""
        return written_values(found, described_tables(self.given)[0])

    def keep(self, found: Fit) -> Machine | BenchDescription:
        """Write the description, and beside it all figures as JSON.

        Raises:
            OutputError: they can't be written there.
        """
        kept = write_identified(self.given, self.described, found, self.checksums, self.path)
        with whole_file(self.path.with_suffix(".json")) as temporary:
            temporary.write_text(json.dumps(self.figures(found), indent=2), encoding="utf-8")
        return kept

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
            "values": {
                e.unknown.path: {
                    "unit": e.unknown.unit,
                    "value": e.value,
                    "low": e.low,
                    "high": e.high,
                    "identified": bool(e.identified),
                    "at_bound": bool(e.at_bound),
                    "partner": e.partner,
                }
                for e in found.estimates
            },
            "errors": [vars(quality) for quality in found.qualities()],
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
    check_folder(out)
    start = load_described(described)
    path = identified_path(str(described), start, out)
    found = recorded(start, list(map(Path, logs)), list(map(Path, validate)), blocks, mapping)
    model = found.bench.model(start, found.fitted, found.blocks, found.validation)
    return Identification(
        str(described), start, found.fitted, found.validation, found.issues, found.blocks, model, path
    )
