"""What another process does of a reproduction, while the command's own does the rest."""

from collections.abc import Iterator

from layflat.experiments.bench import bench
from layflat.experiments.claim import Claim
from layflat.experiments.report import figures
from layflat.experiments.reproduction import Reproduction
from layflat.plot.page import Drawn


def perform(machine: str) -> Iterator[Claim | Drawn]:
    """Evaluate the claims of a machine that another process does not, then draw their figures, one by one."""
    found = Reproduction.on(bench(machine))
    for rule, experiment in found.rules(aside=True):
        found.claims.append(rule.evaluated(experiment))
        yield found.claims[-1]
    yield from figures(found)
