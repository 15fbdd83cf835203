"""Bench logs: read from a file by a mapping, resampled to an even clock, and checked."""

from layflat.identify.logs.checks import find_issues
from layflat.identify.logs.checks.channels import raise_first_error
from layflat.identify.logs.formats import read_table
from layflat.identify.logs.guess import guess_mapping
from layflat.identify.logs.lerobot import write_lerobot
from layflat.identify.logs.mapping import read_mapping, write_mapping
from layflat.identify.logs.read import read_log
from layflat.sim.dataset import save_run

__all__ = [
    "find_issues",
    "guess_mapping",
    "raise_first_error",
    "read_log",
    "read_mapping",
    "read_table",
    "save_run",
    "write_lerobot",
    "write_mapping",
]
