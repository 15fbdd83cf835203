"""Report of a fit, as one page that needs nothing else."""

from pathlib import Path

import numpy as np

from layflat._version import __version__
from layflat.files import write_text
from layflat.identify.fit import Fit
from layflat.identify.identification import Identification
from layflat.identify.report_text import (
    count_identified,
    expected,
    issue_section,
    prediction,
    sections,
    shown,
    untrusted,
)
from layflat.plot.fits import Compared, measured_and_simulated
from layflat.plot.page import Drawn, page
from layflat.plot.style import to_svg

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
