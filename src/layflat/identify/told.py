"""What a fit says, as rows and sentences: the same on a terminal and on a page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from layflat.identify.fit import Fit, Quality
from layflat.identify.identified_file import Written
from layflat.identify.logs import Finding
from layflat.identify.logs.finding import SEVERITIES, several

SHOWN = {"Pa": ("bar", 1e5), "rad": ("deg", 0.017453292519943295), "m": ("mm", 1e-3), "N*m": ("N m", 1.0)}
"""Units in which people read what is SI inside, and their size."""

Row = list[str]

VALUE_COLUMNS = ["value", "found", "95 %", "before"]
"""Columns of `value_row`."""

DOUBTFUL_COLUMNS = ["value", "fits best", "95 %", "why"]
"""Columns of `doubtful_row`."""

RECORD_COLUMNS = ["record", "to tell"]
"""Columns of `record_rows`."""

QUALITY_COLUMNS = ["log", "signal", "", "rms error", "% range", "fit %", "bias", "white", "driven"]
"""Columns of `quality_row`."""

FINDING_COLUMNS = ["log", "", "channel", "found", "what is right, or follows"]
"""Columns of `finding_rows`."""


def shown(unit: str) -> tuple[str, float]:
    """The unit in which people read one of SI, and its size."""
    return SHOWN.get(unit, ("" if unit == "1" else unit, 1.0))


def value_row(value: Written) -> Row:
    """Where it stands, what was found, its interval, and what was there before."""
    before = "" if value.before is None else short(value.before)
    return [value.path, short(value.value), value.interval, before]


def doubtful_row(value: Written) -> Row:
    """Where it stands, what fits best, its interval, and why that is not told."""
    if value.at_bound:
        why = "at the end of its range"
    elif value.partner:
        why = f"only together with {value.partner}"
    else:
        why = "too wide an interval"
    return [value.path, short(value.value), value.interval, why]


def record_rows(values: Sequence[Written]) -> list[Row]:
    """What to record, and the values that it would tell."""
    missed: dict[str, list[str]] = {}
    for value in values:
        if not value.told and value.excitation:
            missed.setdefault(value.excitation, []).append(value.path)
    return [[excitation, ", ".join(paths)] for excitation, paths in missed.items()]


def quality_row(quality: Quality) -> Row:
    """Log, signal, fitted or judged, rms and bias in units, fit in %, and the tests of the residuals."""
    unit, size = shown(quality.unit)
    driven = "" if quality.driven is None else f"{quality.driven:.2f}"
    return [
        quality.log,
        quality.output,
        "judged" if quality.judged else "fitted",
        f"{quality.rms / size:.3g} {unit}".rstrip(),
        f"{100 * quality.share:.3g}",
        f"{100 * quality.fit:.1f}",
        f"{quality.bias / size:.2g}",
        f"{100 * quality.white:.0f} %",
        driven,
    ]


def finding_rows(findings: Mapping[str, Sequence[Finding]]) -> list[Row]:
    """What is doubtful in the logs, the worst first; what is alike in several logs is said once, as of the first."""
    together: dict[tuple[str, str, str], list[tuple[str, Finding]]] = {}
    for name, found in findings.items():
        for finding in found:
            together.setdefault((finding.severity, finding.channel, finding.right), []).append((name, finding))
    rows = sorted(together.values(), key=lambda alike: SEVERITIES.index(alike[0][1].severity))
    return [
        [several([log for log, _ in alike]), f.severity, f.channel, f.text, f.right]
        for alike in rows
        for f in [alike[0][1]]
    ]


def short(value: str | float) -> str:
    """A value with five digits."""
    number, _, unit = str(value).partition(" ")
    return f"{float(number):.5g} {unit}".rstrip()


def predicted(found: Fit) -> str:
    """How well what was not fitted is predicted, in one sentence: of every fitted signal, its worst."""
    outputs = found.model.outputs
    fitted = {output.name for output in outputs if output.fitted.any()}
    judged = [one for one in found.qualities() if one.judged and one.output in fitted]
    if not judged:
        return "Nothing was kept to judge it by."
    parts = []
    for name in dict.fromkeys(one.output for one in judged):
        mine = [one for one in judged if one.output == name]
        worst = max(mine, key=lambda one: one.rms)
        unit, size = shown(worst.unit)
        reach = next(
            np.ptp(o.measured[np.isfinite(o.measured)]) for o in outputs if (o.name, o.log) == (name, worst.log)
        )
        share = f" ({100 * worst.rms / reach:.2g} % of its range)" if reach > 0.0 else ""
        where = f" at worst, in {worst.log}" if len(mine) > 1 else ""
        parts.append(f"{name} within {f'{worst.rms / size:.3g} {unit}'.rstrip()} rms{share}{where}")
    return f"What was not fitted is predicted: {'; '.join(parts)}."


def told(values: Sequence[Written]) -> str:
    """How many values the logs tell, in one sentence."""
    sure = sum(value.told for value in values)
    return (
        f"The logs tell {'all' if sure == len(values) else sure} of {len(values)} values."
        if sure
        else f"The logs tell none of {len(values)} values."
    )


def distrusted(found: Fit, values: Sequence[Written]) -> str | None:
    """Why a fit is not to be trusted; None if it is."""
    if found.trusted:
        return None
    at = [value.path for value in values if value.at_bound]
    nuisances = [one.unknown.path for one in found.estimates if one.at_bound and one.unknown.nuisance]
    if at or nuisances:
        return f"{(at or nuisances)[0]} ran into the end of its range: the description or the log is far off"
    if found.astray is not None:
        miss = (
            f"{found.astray.output} is missed by {100 * found.astray.share:.0f} % of its range where it was not fitted"
        )
        return f"{miss}: begin with a description that is closer, or record slower moves within the stroke"
    return "the search came to no end"


def listed(names: Sequence[str]) -> str:
    """Names as in a sentence."""
    return f"{', '.join(names[:-1])} and {names[-1]}" if len(names) > 1 else names[0]
