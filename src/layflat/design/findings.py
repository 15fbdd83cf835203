"""Findings of the design rules: what can't be made, works badly, or should be known to the maker."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from layflat.errors import DesignError

Severity = Literal["error", "warning", "note"]
ORDER: tuple[Severity, ...] = ("error", "warning", "note")


@dataclass(frozen=True)
class Finding:
    """One thing that was found."""

    severity: Severity  # "error", "warning" or "note"
    rule: str  # short name of the rule
    where: str  # machine, joint and key
    what: str  # what is so, with its value
    right: str = ""  # what would be right, or what it leads to

    def __str__(self) -> str:
        text = f"{self.where}: {self.what}"
        return f"{text}; {self.right}" if self.right else text


def refuse_errors(findings: Sequence[Finding]) -> None:
    """Raise the first error among findings, if there is one, as DesignError with its text."""
    for finding in findings:
        if finding.severity == "error":
            raise DesignError(finding.what, where=finding.where, right=finding.right)
