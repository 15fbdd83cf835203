"""Logs fitted in one call: from files and a description to the fitted description and what it is worth."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from layflat.errors import InputError
from layflat.identify.benches import BenchDescription
from layflat.identify.fit import Fit
from layflat.identify.fit.search import RANDOM_STARTS, Progress
from layflat.identify.identification import Identification, prepare_identification
from layflat.machine import Machine
from layflat.plot.tables import html_table

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class FittedLogs:
    """Fit of a description to logs."""

    session: Identification
    fit: Fit
    described: Machine | BenchDescription  # with the fitted values

    @property
    def path(self) -> Path:
        """File with the fitted description."""
        return self.session.path

    def plot(self, log: str | None = None) -> "Figure":
        """Draw the signals of a log beside their simulation, and the error; by default of the first log.

        Raises:
            InputError: there is no log of this name.
        """
        from layflat.identify.report_text import compared_signals, describe_figure  # noqa: PLC0415  # matplotlib
        from layflat.plot.runs import measured_and_simulated  # noqa: PLC0415
        from layflat.plot.style import add_caption  # noqa: PLC0415

        names = list(dict.fromkeys(output.log for output in self.fit.model.outputs))
        chosen = names[0] if log is None else log
        if chosen not in names:
            raise InputError(f"there is no log {chosen!r}", where="log", right=f"give {' or '.join(names)}")
        signals = compared_signals(self.fit, chosen)
        return add_caption(measured_and_simulated(signals), f"{chosen}. {describe_figure(signals)}")

    def _repr_html_(self) -> str:
        """Return the tables of the report, for notebooks."""
        from layflat.identify.report_text import report_tables  # noqa: PLC0415  # matplotlib takes long to import

        tables = report_tables(self.fit, self.session.values(self.fit))
        return "".join(html_table(table.title, table.columns, table.rows) for table in tables)


def fit_logs(
    logs: str | Path | Sequence[str | Path],
    machine: str | Path,
    *,
    out: str | Path = "build/identify",
    blocks: str | None = None,
    validate: Sequence[str | Path] = (),
    mapping: str | Path | None = None,
    starts: int = RANDOM_STARTS,
    seed: int = 0,
    progress: Progress | None = None,
) -> FittedLogs:
    """Find the parameters of a machine or a test bench that explain logs, and write the description that has them.

    Args:
        logs: one file or several: CSV, Parquet, NetCDF or MCAP.
        machine: built-in name or file of the description to begin with.
        out: folder for the fitted description, NAME-identified.toml, and all figures as JSON.
        blocks: groups of parameters to fit, such as "valve, hose"; default: those of the bench.
        validate: logs that are only predicted; without any, the last third of each log is.
        mapping: file with the signal, unit and sign of each column; not needed for the names that layflat writes.
        starts: random starts of the search, besides the description's values.
        seed: seed of the starts and intervals.
        progress: called with the fraction that is done and a text.

    Raises:
        InputError: a log, the description or an argument is wrong.
        OutputError: the folder can't be written to.
    """
    files = [logs] if isinstance(logs, (str, Path)) else list(logs)
    session = prepare_identification(files, machine, Path(out), blocks=blocks, validate=validate, mapping=mapping)
    fit = session.fit(starts=starts, seed=seed, progress=progress)
    return FittedLogs(session, fit, session.write_results(fit))
