"""Bench logs: read from a file by a mapping, brought to an even clock, and checked."""

from layflat.identify.logs.checks import check
from layflat.identify.logs.checks.channels import refuse
from layflat.identify.logs.formats import read_table
from layflat.identify.logs.guess import guess_mapping
from layflat.identify.logs.mapping import read_mapping, write_mapping
from layflat.identify.logs.read import read_log
from layflat.sim.dataset import save

__all__ = ["check", "guess_mapping", "read_log", "read_mapping", "read_table", "refuse", "save", "write_mapping"]
