"""What a check finds in a log."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from layflat.errors import InputError

Severity = Literal["error", "warning", "note"]

SEVERITIES: tuple[Severity, ...] = ("error", "warning", "note")


@dataclass(frozen=True)
class Issue:
    """Something in a log that is wrong, doubtful or worth knowing."""

    severity: Severity  # "error" (no fit makes sense), "warning" (look at it) or "note"
    channel: str  # signal and joint, such as "pressure_a.elbow"; "log" for the whole
    text: str  # what was found, with values
    right: str = ""  # what would be right, or follows


def ordered(issues: Iterable[Issue]) -> list[Issue]:
    """The worst first; what is the same of several channels is said once."""
    together: dict[Issue, list[str]] = {}
    for issue in issues:
        together.setdefault(replace(issue, channel=""), []).append(issue.channel)
    merged = [replace(issue, channel=several(channels)) for issue, channels in together.items()]
    return sorted(merged, key=lambda issue: SEVERITIES.index(issue.severity))


def several(channels: Sequence[str]) -> str:
    """Several channels in a few words."""
    return " and ".join(channels) if len(channels) <= 2 else f"{channels[0]} and {len(channels) - 1} more"


def refuse(issues: Sequence[Issue], where: str = "log") -> None:
    """Stop at a log with errors: raise InputError with the first one, and how many there are."""
    errors = [issue for issue in issues if issue.severity == "error"]
    if errors:
        first, more = errors[0], len(errors) - 1
        told = f" (and {more} more error{'s' if more > 1 else ''})" if more else ""
        raise InputError(f"{first.text}{told}", where=f"{where}: {first.channel}", right=first.right)
