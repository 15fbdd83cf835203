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
from layflat.identify.benches.kinds import bench_of, chosen_blocks
from layflat.identify.benches.loader import described_tables, load_described
from layflat.identify.fit import Fit, fit
from layflat.identify.fit.search import STARTS, Progress
from layflat.identify.identified_file import Written, identified_path, write_identified, written_values
from layflat.identify.logs import Issue, check, read_log, read_table, refuse
from layflat.identify.logs.checks.excited import NOTHING_MOVES
from layflat.identify.logs.issue import ordered
from layflat.identify.model import Model
from layflat.identify.reading import begun, named, refuse_rest
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
    machine = start if isinstance(start, Machine) else None
    joints = list(machine.joints) if machine is not None else None
    tables = {name: read_table(file) for name, file in named([*map(Path, logs), *map(Path, validate)]).items()}
    whole = {name: read_log(table, mapping, joints=joints) for name, table in tables.items()}
    fitted = list(whole)[: len(logs)]
    bench = bench_of(start, {name: whole[name] for name in fitted})
    chosen = chosen_blocks(bench, blocks)
    taken, issues = {}, {}
    for name, table in tables.items():
        found = check(whole[name], machine)
        if [issue for issue in found if issue.severity == "error"] == [NOTHING_MOVES]:
            sequence = " (`layflat excite` writes such a sequence)" if machine is not None else ""
            refuse_rest(bench.model(start, {name: whole[name]}, {}, blocks=chosen), sequence, str(table.path))
        refuse(found, str(table.path))
        cycle = machine.cycle if machine is not None and bench.even else None
        log = read_log(table, mapping, joints=joints, cycle=cycle, as_recorded=not bench.even)
        taken[name], late = begun(log) if bench.even else (log, [])
        issues[name] = ordered([*found, *late])
    of_fit = {name: log for name, log in taken.items() if name in fitted}
    others = {name: log for name, log in taken.items() if name not in fitted}
    model = bench.model(start, of_fit, others, blocks=chosen)
    return Identification(str(described), start, of_fit, others, issues, chosen, model, path)
