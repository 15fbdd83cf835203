"""The paper's experiments and its claims."""

from layflat.experiments.bench import ReproductionBench, load_bench
from layflat.experiments.claim import Claim, ClaimQuantity
from layflat.experiments.report import write_claims, write_report
from layflat.experiments.reproduction import Reproduction, reproduce

__all__ = [
    "Claim",
    "ClaimQuantity",
    "Reproduction",
    "ReproductionBench",
    "load_bench",
    "reproduce",
    "write_claims",
    "write_report",
]
