"""Assemblies and their checks, made once for all tests of the checks."""

from functools import cache

from layflat.machine import load
from layflat.solids.assembly import Assembly, assemble
from layflat.solids.checks.findings import BuildChecks, check_build


@cache
def built(name: str = "paper-small-joint") -> Assembly:
    return assemble(load(name))


@cache
def checked() -> BuildChecks:
    return check_build(built())
