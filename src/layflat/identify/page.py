"""What a fit is worth, as one page that needs nothing else."""

from __future__ import annotations

from pathlib import Path

import layflat
from layflat.files import whole_file
from layflat.identify.fit import Fit, Quality
from layflat.identify.identification import Identification
from layflat.identify.identified_file import Written
from layflat.plot.fits import Compared, measured_and_simulated
from layflat.plot.page import Drawn, page
from layflat.plot.style import to_svg

SHOWN = {"Pa": ("bar", 1e5), "rad": ("deg", 0.017453292519943295), "m": ("mm", 1e-3)}
"""Units in which people read what is SI inside, and their size."""

MOST = 6
"""Logs that are drawn; judged ones first."""

Row = list[str]


def write_page(session: Identification, found: Fit, path: Path) -> Path:
    """Write the page.

    Raises:
        OutputError: it can't be written there.
    """
    values = session.values(found)
    html = page(
        "layflat.identify",
        "identified.html.j2",
        name=session.path.stem,
        title=session.described.title,
        version=layflat.__version__,
        file=session.path.name,
        blocks=", ".join(session.blocks),
        logs=session.checksums,
        judged=list(session.judged),
        trusted=found.trusted,
        converged=found.converged,
        simulations=found.simulations,
        values=[value_row(value) for value in values if value.told],
        doubtful=[doubtful_row(value) for value in values if not value.told],
        errors=[quality_row(quality) for quality in found.qualities()],
        findings=[
            [name, f.severity, f.channel, f.text, f.right] for name, all_ in session.findings.items() for f in all_
        ],
        drawn=drawn(found),
    )
    with whole_file(path) as temporary:
        temporary.write_text(html, encoding="utf-8")
    return path


def value_row(value: Written) -> Row:
    """Where it stands, what was found, its interval, and what was there before."""
    before = "" if value.before is None else str(value.before)
    return [value.path, short(value.value), value.interval, before]


def doubtful_row(value: Written) -> Row:
    """Where it stands, what fits best, its interval, why it is not told and what would tell it."""
    why = (
        "at the end of its range" if value.at_bound else f"not apart from {value.partner}" if value.partner else "weak"
    )
    return [value.path, short(value.value), value.interval, why, value.excitation]


def quality_row(quality: Quality) -> Row:
    """Log, signal, fitted or judged, rms and bias in units, fit in %, and the tests of the residuals."""
    unit, size = SHOWN.get(quality.unit, (quality.unit, 1.0))
    driven = "" if quality.driven is None else f"{quality.driven:.2f}"
    return [
        quality.log,
        quality.output,
        "judged" if quality.judged else "fitted",
        f"{quality.rms / size:.3g} {unit}",
        f"{100 * quality.share:.3g}",
        f"{100 * quality.fit:.1f}",
        f"{quality.bias / size:.2g}",
        f"{100 * quality.white:.0f}",
        driven,
    ]


QUALITY_COLUMNS = ["log", "signal", "", "rms error", "% of range", "fit %", "bias", "white %", "driven"]
"""Columns of `quality_row`."""


def short(value: str | float) -> str:
    """A value with four digits."""
    number, _, unit = str(value).partition(" ")
    return f"{float(number):.4g} {unit}".rstrip()


def drawn(found: Fit) -> list[Drawn]:
    """Measured and simulated signals, a figure a log."""
    outputs = found.model.outputs
    logs = list(dict.fromkeys(output.log for output in outputs))
    logs.sort(key=lambda log: any(output.fitted.any() for output in outputs if output.log == log))
    figures = []
    for log in logs[:MOST]:
        signals = []
        for place, output in zip(found.model.slices, outputs, strict=True):
            if output.log == log:
                unit, size = SHOWN.get(output.unit, (output.unit, 1.0))
                both = output.measured / size, found.simulated[place] / size
                signals.append(Compared(output.name, unit, output.time, *both, output.fitted))
        caption = (
            "Measured and simulated from the log's start with its inputs alone; on a grey ground, what was not fitted."
        )
        figures.append(Drawn(log, f"{log}.", caption, to_svg(measured_and_simulated(signals))))
    return figures
