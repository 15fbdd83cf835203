"""The paper's experiments and its claims."""

from layflat.experiments.bench import Bench, bench
from layflat.experiments.claim import Claim
from layflat.experiments.report import write_claims, write_report
from layflat.experiments.reproduction import EXPERIMENTS, Reproduction, reproduce

__all__ = [
    "EXPERIMENTS",
    "Bench",
    "Claim",
    "Reproduction",
    "bench",
    "reproduce",
    "write_claims",
    "write_report",
]
