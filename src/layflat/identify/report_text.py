"""Results of a fit as tables and sentences, for terminal and page; and the page itself."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from layflat._version import __version__
from layflat.files import write_text
from layflat.identify.fit import Fit, Quality
from layflat.identify.identification import Identification
from layflat.identify.identified_file import WrittenValue
from layflat.identify.logs.checks.channels import SEVERITIES, Issue, name_several
from layflat.identify.logs.vocabulary import DISPLAY_UNITS
from layflat.plot import CaptionedFigure, render_page
from layflat.plot.runs import ComparedSignal, measured_and_simulated
from layflat.plot.style import to_svg

Row = list[str]


class ReportTable(NamedTuple):
    """Table of a report: texts of all cells."""

    title: str
    columns: Row
    rows: list[Row]


def report_tables(fit: Fit, values: Sequence[WrittenValue]) -> list[ReportTable]:
    """Return the tables about a fit, without empty ones."""
    identified = [[v.path, format_short(v.value), v.interval, format_short(v.before)] for v in values if v.identified]
    doubtful = [[v.path, format_short(v.value), v.interval, _doubt_reason(v)] for v in values if not v.identified]
    errors = ["log", "signal", "", "rms error", "% range", "fit %", "bias", "white", "driven"]
    every = [
        ReportTable("Identified parameters", ["parameter", "found", "95 %", "before"], identified),
        ReportTable("Parameters that are not identifiable", ["parameter", "best fit", "95 %", "why"], doubtful),
        ReportTable("Suggested experiments", ["record", "to identify"], experiment_rows(values)),
        ReportTable("Prediction errors", errors, [_quality_row(quality) for quality in fit.qualities()]),
    ]
    return [section for section in every if section.rows]


def issue_table(issues: Mapping[str, Sequence[Issue]]) -> ReportTable:
    """Return the issues of logs as a table, the worst first; those of several logs are one row, with the first text."""
    alike_by_text: dict[tuple[str, str, str], list[tuple[str, Issue]]] = {}
    for name, issues_of_log in issues.items():
        for issue in issues_of_log:
            alike_by_text.setdefault((issue.severity, issue.channel, issue.right), []).append((name, issue))
    rows = [
        [name_several([log for log, _ in alike]), severity, channel, alike[0][1].text, right]
        for (severity, channel, right), alike in sorted(
            alike_by_text.items(), key=lambda one: SEVERITIES.index(one[0][0])
        )
    ]
    return ReportTable("Issues in the logs", ["log", "severity", "channel", "found", "action"], rows)


def experiment_rows(values: Sequence[WrittenValue]) -> list[Row]:
    """Return rows of an experiment to record, and the unidentified parameters that it would identify."""
    missed: dict[str, list[str]] = {}
    for value in values:
        if value.estimate is not None and not value.identified and value.estimate.unknown.excitation:
            missed.setdefault(value.estimate.unknown.excitation, []).append(value.path)
    return [[excitation, ", ".join(paths)] for excitation, paths in missed.items()]


def describe_prediction(fit: Fit) -> str:
    """Return a sentence on the prediction errors of samples that were not fitted, or that there are none.

    It has the worst log of each signal.
    """
    if not fit.predictions:
        return "No samples were kept for validation."
    parts = []
    for name in dict.fromkeys(quality.output for quality in fit.predictions):
        qualities = [quality for quality in fit.predictions if quality.output == name]
        worst = max(qualities, key=lambda quality: quality.rms)
        where = f" at worst, in {worst.log}" if len(qualities) > 1 else ""
        within = f"within {_format_rms(worst)} rms ({format_percent(worst.relative_rms)} % of its range)"
        parts.append(f"{name} {'not at all: the run diverged' if worst.diverged else within}{where}")
    return f"Validation: what was not fitted is predicted, {'; '.join(parts)}."


def describe_expected_errors(fit: Fit) -> str:
    """Return a sentence on the expected errors of a new log; "" where they were not estimated."""
    if not fit.expected:
        return ""
    parts = []
    for error in fit.expected:
        unit, size = display_unit(error.unit)
        between = f"{error.low / size:.2g} to {error.high / size:.2g}"
        value = f"{error.output} {error.rms / size:.2g} {unit}".rstrip()
        parts.append(
            f"{value} rms, {format_percent(error.relative_rms)} % of its range (eight of ten between {between})"
        )
    count = len(fit.expected[0].held_out_rms)
    return f"Expected of a new log of the same kind: {'; '.join(parts)}; from {count} logs or parts, left out in turn."


def count_identified(values: Sequence[WrittenValue]) -> str:
    """Return a sentence on the number of identified parameters."""
    sure = sum(value.identified for value in values)
    counted = {0: "None", len(values): "All"}.get(sure, str(sure))
    return f"{counted} of {len(values)} parameters {'is' if sure == 1 else 'are'} identified by the logs."


def distrust_reason(fit: Fit, values: Sequence[WrittenValue]) -> str | None:
    """Return the first reason why a fit is not to be trusted; None if it is."""
    if fit.trusted:
        return None
    at_bounds = [value.path for value in values if value.at_bound]
    nuisances = [estimate.unknown.path for estimate in fit.estimates if estimate.at_bound and estimate.unknown.nuisance]
    if at_bounds or nuisances:
        return f"{(at_bounds or nuisances)[0]} hit its bound: the description or the log is far off"
    missed = fit.mispredicted
    if missed is not None:
        amount = (
            "altogether, as the run diverged,"
            if missed.diverged
            else f"by {format_percent(missed.relative_rms)} % of its range"
        )
        error = f"{missed.output} is missed {amount} where it was not fitted"
        return f"{error}: begin with a description that is closer, or record slower moves within the stroke"
    return "the search was stopped" if fit.partial else "the search did not converge"


def display_unit(unit: str) -> tuple[str, float]:
    """Return the display unit for an SI unit, and its size in SI; the unit itself and 1 where it has none."""
    return DISPLAY_UNITS.get(unit, ("" if unit == "1" else unit.replace("*", " "), 1.0))


def format_short(value: str | float | None) -> str:
    """Return a value with five significant digits and its unit; "" for None."""
    if value is None:
        return ""
    number, _, unit = str(value).partition(" ")
    return f"{float(number):.5g} {unit}".rstrip()


def format_percent(share: float) -> str:
    """Return a fraction in per cent with three significant digits, without "%"."""
    return f"{100.0 * share:.3g}"


def _doubt_reason(value: WrittenValue) -> str:
    """Return why a parameter is not identified."""
    partner = value.estimate.partner if value.estimate is not None else None
    apart = f"only together with {partner}" if partner else "the interval is too wide"
    return "hit its bound" if value.at_bound else apart


def _format_rms(quality: Quality) -> str:
    """Return an rms error with its display unit."""
    unit, size = display_unit(quality.unit)
    return f"{quality.rms / size:.3g} {unit}".rstrip()


def _quality_row(quality: Quality) -> Row:
    """Return log, signal, use, rms error with unit, error and fit in %, bias, and the tests of the residuals."""
    begin = [quality.log, quality.output, "validation" if quality.validation else "fitted"]
    if quality.diverged:
        return [*begin, "diverged", *[""] * 5]
    return [
        *begin,
        _format_rms(quality),
        format_percent(quality.relative_rms),
        f"{100 * quality.fit:.1f}",
        f"{quality.bias / display_unit(quality.unit)[1]:.2g}",
        f"{100 * quality.white:.0f} %",
        "" if quality.driven is None else f"{quality.driven:.2f}",
    ]


MAX_FIGURES = 9  # logs that are drawn, those for validation first


def write_page(session: Identification, fit: Fit, path: Path) -> Path:
    """Write the report of a fit as a page.

    Args:
        session: logs and description of the fit.
        fit: its result.
        path: path of the page.

    Returns:
        The path.

    Raises:
        OutputError: the page can't be written there.
    """
    values = session.values(fit)
    html = render_page(
        "layflat.identify",
        "identified.html.j2",
        version=__version__,
        name=session.path.stem,
        session=session,
        fit=fit,
        description=Path(session.source).stem,
        distrust=distrust_reason(fit, values),
        summary=" ".join(
            [
                *filter(None, [describe_expected_errors(fit)]),
                describe_prediction(fit),
                count_identified(values),
                *fit.remarks,
            ]
        ),
        tables=report_tables(fit, values),
        issues=issue_table(session.issues),
        undrawn=max(len({output.log for output in fit.model.outputs}) - MAX_FIGURES, 0),
        figures=draw_logs(fit),
    )
    return write_text(path, html)


def draw_logs(fit: Fit) -> list[CaptionedFigure]:
    """Return figures of the signals of up to `MAX_FIGURES` logs, measured and simulated; logs not fitted come first."""
    outputs = fit.model.outputs
    logs = list(dict.fromkeys(output.log for output in outputs))
    logs.sort(key=lambda log: any(output.fitted.any() for output in outputs if output.log == log))
    figures = []
    for log in logs[:MAX_FIGURES]:
        signals = compared_signals(fit, log)
        svg = to_svg(measured_and_simulated(signals))
        figures.append(CaptionedFigure(log, f"{log}.", describe_figure(signals), svg))
    return figures


def compared_signals(fit: Fit, log: str) -> list[ComparedSignal]:
    """Return the signals of a log, with their simulation, in display units."""
    signals = []
    for place, output in zip(fit.model.slices, fit.model.outputs, strict=True):
        if output.log == log:
            unit, size = display_unit(output.unit)
            both = output.measured / size, fit.simulated[place] / size
            signals.append(ComparedSignal(output.name, unit, output.time, *both, output.fitted))
    return signals


def describe_figure(signals: list[ComparedSignal]) -> str:
    """Return the caption of the figure of a log's signals, which states whether all, part or none was fitted."""
    fitted = np.concatenate([signal.fitted for signal in signals])
    some = "On a grey ground, what was not fitted but predicted."
    kept = (
        "All of it was fitted."
        if fitted.all()
        else some
        if fitted.any()
        else "None of it was fitted: all is predicted."
    )
    return f"Measured, and simulated from the log's start on; on the right the error, simulated less measured. {kept}"
