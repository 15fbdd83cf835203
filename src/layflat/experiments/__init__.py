"""The paper's experiments and its claims."""

from layflat.experiments.bench import Bench, bench
from layflat.experiments.claim import Claim, Quantity
from layflat.experiments.report import write_claims, write_report
from layflat.experiments.reproduction import Reproduction, reproduce

__all__ = ["Bench", "Claim", "Quantity", "Reproduction", "bench", "reproduce", "write_claims", "write_report"]
