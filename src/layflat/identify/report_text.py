"""Results of a fit as tables and sentences, the same on a terminal and on a page; and the page itself."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from layflat._version import __version__
from layflat.files import write_text
from layflat.identify.fit import Fit, Quality
from layflat.identify.identification import Identification
from layflat.identify.identified_file import Written
from layflat.identify.logs.checks.channels import SEVERITIES, Issue, several
from layflat.identify.logs.vocabulary import SHOWN
from layflat.plot.fits import Compared, measured_and_simulated
from layflat.plot.page import Drawn, page
from layflat.plot.style import to_svg

Row = list[str]


class Section(NamedTuple):
    """A table of a report."""

    title: str
    columns: Row
    rows: list[Row]


def sections(found: Fit, values: Sequence[Written]) -> list[Section]:
    """The tables about a fit, those without any row left out."""
    identified = [[v.path, short(v.value), v.interval, short(v.before)] for v in values if v.identified]
    doubtful = [[v.path, short(v.value), v.interval, _why(v)] for v in values if not v.identified]
    errors = ["log", "signal", "", "rms error", "% range", "fit %", "bias", "white", "driven"]
    every = [
        Section("Identified parameters", ["parameter", "found", "95 %", "before"], identified),
        Section("Parameters that are not identifiable", ["parameter", "best fit", "95 %", "why"], doubtful),
        Section("Suggested experiments", ["record", "to identify"], experiment_rows(values)),
        Section("Prediction errors", errors, [_quality_row(one) for one in found.qualities()]),
    ]
    return [section for section in every if section.rows]


def issue_section(issues: Mapping[str, Sequence[Issue]]) -> Section:
    """Return doubts in the logs, the worst first; what is alike in several logs is said once, as of the first."""
    together: dict[tuple[str, str, str], list[tuple[str, Issue]]] = {}
    for name, found in issues.items():
        for issue in found:
            together.setdefault((issue.severity, issue.channel, issue.right), []).append((name, issue))
    rows = [
        [several([log for log, _ in alike]), severity, channel, alike[0][1].text, right]
        for (severity, channel, right), alike in sorted(together.items(), key=lambda one: SEVERITIES.index(one[0][0]))
    ]
    return Section("Issues in the logs", ["log", "severity", "channel", "found", "action"], rows)


def experiment_rows(values: Sequence[Written]) -> list[Row]:
    """Return what to record, and the parameters that it would identify."""
    missed: dict[str, list[str]] = {}
    for value in values:
        if value.estimate is not None and not value.identified and value.estimate.unknown.excitation:
            missed.setdefault(value.estimate.unknown.excitation, []).append(value.path)
    return [[excitation, ", ".join(paths)] for excitation, paths in missed.items()]


def prediction(found: Fit) -> str:
    """Return how well what was not fitted is predicted, in one sentence: of every fitted signal, its worst."""
    if not found.predictions:
        return "No samples were kept for validation."
    parts = []
    for name in dict.fromkeys(one.output for one in found.predictions):
        mine = [one for one in found.predictions if one.output == name]
        worst = max(mine, key=lambda one: one.rms)
        where = f" at worst, in {worst.log}" if len(mine) > 1 else ""
        within = f"within {_rms(worst)} rms ({percent(worst.share)} % of its range)"
        parts.append(f"{name} {'not at all: the run diverged' if worst.diverged else within}{where}")
    return f"Validation: what was not fitted is predicted, {'; '.join(parts)}."


def expected(found: Fit) -> str:
    """Return the error to expect of a new log as a sentence, empty where it was not estimated."""
    if not found.expected:
        return ""
    parts = []
    for one in found.expected:
        unit, size = shown(one.unit)
        between = f"{one.low / size:.2g} to {one.high / size:.2g}"
        value = f"{one.output} {one.rms / size:.2g} {unit}".rstrip()
        parts.append(f"{value} rms, {percent(one.share)} % of its range (eight of ten between {between})")
    count = len(found.expected[0].left_out)
    return f"Expected of a new log of the same kind: {'; '.join(parts)}; from {count} logs or parts, left out in turn."


def count_identified(values: Sequence[Written]) -> str:
    """Return how many parameters are identified, in one sentence."""
    sure = sum(value.identified for value in values)
    counted = {0: "None", len(values): "All"}.get(sure, str(sure))
    return f"{counted} of {len(values)} parameters {'is' if sure == 1 else 'are'} identified by the logs."


def untrusted(found: Fit, values: Sequence[Written]) -> str | None:
    """Why a fit is not to be trusted; None if it is."""
    if found.trusted:
        return None
    at = [value.path for value in values if value.at_bound]
    nuisances = [one.unknown.path for one in found.estimates if one.at_bound and one.unknown.nuisance]
    if at or nuisances:
        return f"{(at or nuisances)[0]} hit its bound: the description or the log is far off"
    missed = found.mispredicted
    if missed is not None:
        by = "altogether, as the run diverged," if missed.diverged else f"by {percent(missed.share)} % of its range"
        error = f"{missed.output} is missed {by} where it was not fitted"
        return f"{error}: begin with a description that is closer, or record slower moves within the stroke"
    return "the search was stopped" if found.partial else "the search did not converge"


def shown(unit: str) -> tuple[str, float]:
    """The unit in which people read one of SI, and its size."""
    return SHOWN.get(unit, ("" if unit == "1" else unit.replace("*", " "), 1.0))


def short(value: str | float | None) -> str:
    """A value with five digits, empty for None."""
    if value is None:
        return ""
    number, _, unit = str(value).partition(" ")
    return f"{float(number):.5g} {unit}".rstrip()


def percent(share: float) -> str:
    """A share in per cent with three digits, the same wherever it stands."""
    return f"{100.0 * share:.3g}"


def _why(value: Written) -> str:
    """Why a parameter is not identified."""
    partner = value.estimate.partner if value.estimate is not None else None
    apart = f"only together with {partner}" if partner else "the interval is too wide"
    return "hit its bound" if value.at_bound else apart


def _rms(quality: Quality) -> str:
    unit, size = shown(quality.unit)
    return f"{quality.rms / size:.3g} {unit}".rstrip()


def _quality_row(quality: Quality) -> Row:
    """Log, signal, fitted or validation, rms and bias in units, fit in %, and the tests of the residuals."""
    begin = [quality.log, quality.output, "validation" if quality.validation else "fitted"]
    if quality.diverged:
        return [*begin, "diverged", *[""] * 5]
    return [
        *begin,
        _rms(quality),
        percent(quality.share),
        f"{100 * quality.fit:.1f}",
        f"{quality.bias / shown(quality.unit)[1]:.2g}",
        f"{100 * quality.white:.0f} %",
        "" if quality.driven is None else f"{quality.driven:.2f}",
    ]


MOST = 9  # logs that are drawn; those for validation first


def write_page(session: Identification, found: Fit, path: Path) -> Path:
    """Write the page; raise OutputError if it can't be written there."""
    values = session.values(found)
    html = page(
        "layflat.identify",
        "identified.html.j2",
        version=__version__,
        name=session.path.stem,
        session=session,
        found=found,
        given=Path(session.given).stem,
        untrusted=untrusted(found, values),
        summary=" ".join(
            [*filter(None, [expected(found)]), prediction(found), count_identified(values), *found.remarks]
        ),
        sections=sections(found, values),
        issues=issue_section(session.issues),
        left=max(len({output.log for output in found.model.outputs}) - MOST, 0),
        drawn=drawn(found),
    )
    return write_text(path, html)


def drawn(found: Fit) -> list[Drawn]:
    """Measured and simulated signals, a figure a log; logs that were not fitted come first."""
    outputs = found.model.outputs
    logs = list(dict.fromkeys(output.log for output in outputs))
    logs.sort(key=lambda log: any(output.fitted.any() for output in outputs if output.log == log))
    figures = []
    for log in logs[:MOST]:
        signals = []
        for place, output in zip(found.model.slices, outputs, strict=True):
            if output.log == log:
                unit, size = shown(output.unit)
                both = output.measured / size, found.simulated[place] / size
                signals.append(Compared(output.name, unit, output.time, *both, output.fitted))
        figures.append(Drawn(log, f"{log}.", _caption(signals), to_svg(measured_and_simulated(signals))))
    return figures


def _caption(signals: list[Compared]) -> str:
    """Return the caption of a figure."""
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
