"""What a check finds in a log."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from layflat.errors import InputError

Severity = Literal["error", "warning", "note"]

SEVERITIES: tuple[Severity, ...] = ("error", "warning", "note")


@dataclass(frozen=True)
class LogFinding:
    """Something in a log that is wrong, doubtful or worth knowing.

    Attributes:
        severity: "error" (no fit makes sense), "warning" (look at it) or "note".
        channel: signal and joint, such as "pressure_a.elbow"; "log" for the whole.
        text: what was found, with values.
        right: what would be right, or follows.
    """

    severity: Severity
    channel: str
    text: str
    right: str = ""


def ordered(findings: Iterable[LogFinding]) -> list[LogFinding]:
    """The worst first; what is the same of several channels is said once."""
    together: dict[LogFinding, list[str]] = {}
    for finding in findings:
        together.setdefault(replace(finding, channel=""), []).append(finding.channel)
    merged = [replace(finding, channel=several(channels)) for finding, channels in together.items()]
    return sorted(merged, key=lambda finding: SEVERITIES.index(finding.severity))


def several(channels: Sequence[str]) -> str:
    """Several channels in a few words."""
    return " and ".join(channels) if len(channels) <= 2 else f"{channels[0]} and {len(channels) - 1} more"


def refuse(findings: Sequence[LogFinding], where: str = "log") -> None:
    """Stop at a log with errors.

    Raises:
        InputError: the first error, and how many there are.
    """
    errors = [finding for finding in findings if finding.severity == "error"]
    if errors:
        first, more = errors[0], len(errors) - 1
        told = f" (and {more} more error{'s' if more > 1 else ''})" if more else ""
        raise InputError(f"{first.text}{told}", where=f"{where}: {first.channel}", right=first.right)
