"""Find the machines that the paper allows: `python -m research.cloud --seed 1 --rounds 420 --out FILE`.

Machines begin near those that calibrations from anywhere find, and walk over all that is open, as far as the paper's
findings let them. Those with which every claim agrees become members. Each start has a walk of its own, and as many
members as the others, in turn: who walked together would end where the surest start lies. It takes an hour and a half
on two cores; the same seed finds the same if the time of the calibrations suffices.
"""

import argparse
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from layflat.arrays import Array
from layflat.experiments.bench import bench
from layflat.experiments.reproduction import disagreeing
from layflat.experiments.spread import at_once, names_in
from layflat.machine.cloud import PAPER
from research.calibration.effort import ONCE, ROUGHLY_CLAIMED, SURE, Effort
from research.calibration.evidence import Evidence
from research.calibration.findings import Findings
from research.calibration.stages import calibrated
from research.cloud.made import write
from research.cloud.open import ARM, BLOCKS, excluded, place, values
from research.cloud.pinned import effective
from research.cloud.walk import Walk, begun

SPREAD = 0.01  # of their shares at first
LEVEL = 0.55  # what machines may lack in the end: the findings' margins included
MEMBERS = 252  # that a cloud has at most, the same number from each start

EFFORTS = ((ROUGHLY_CLAIMED, 256, 0.7), (ONCE, 128, 0.5), (SURE, 128, LEVEL))
"""How closely machines are looked at one after the other, how many of them, and down to which level."""

Efforts = Sequence[tuple[Effort, int, float]]

KIND, MINUTES = "elasto-slip", 26.0  # of losses, and for each calibration


def starts(seed: int, count: int) -> Array:
    """Return where machines lie that so many calibrations from anywhere find, (machines, unknowns).

    Raises:
        SystemExit: with none of them all claims agree.
    """
    found = []
    for number in range(count):
        on, _, stages = calibrated(KIND, seed + number, MINUTES, anew=True)
        if all(best.agrees for best in stages):
            found.append(place({"paper-arm": on.arm, "paper-small-joint": on.axis_one, "earlier-actuator": on.earlier}))
    if not found:
        raise SystemExit(f"no calibration of {count} found a machine with which all claims agree: take other seeds")
    return np.stack(found)


def walked(
    findings: Findings, near: Array, *, seed: int, rounds: int, spread: float = SPREAD, efforts: Efforts = EFFORTS
) -> Iterator[tuple[Walk, bool]]:
    """Walk from machines near these (machines, unknowns), spread by so much of their ranges, for so many rounds.

    Yields the walk, and whether it is at the last level.
    """
    rng, ladder = np.random.default_rng(seed), iter(efforts)
    effort, machines, least = next(ladder)

    def lacks(shares: Array, part: int, noise: int, level: Array) -> Array:
        return findings.lack(
            shares, lambda some: values(some, part), arm=part == ARM, seed=noise, effort=effort, level=level
        )

    first = near[rng.integers(len(near), size=machines)]
    shares = np.clip(first + spread * rng.standard_normal(first.shape), 0.0, 1.0)
    walk = begun(shares, 2, lacks, seed)
    while walk.rounds < rounds:
        walk.goes_on(BLOCKS, lacks, least)
        sys.stderr.write(
            f"{walk.rounds} of {rounds} rounds: level {walk.level:.2f}, "
            f"{walk.taken:.1%} of steps taken, {walk.shares.std(axis=0).mean():.3f} of the ranges covered\n"
        )
        last = effort is efforts[-1][0]
        yield walk, last and walk.level <= least
        if walk.level <= least and not last:
            effort, machines, least = next(ladder)
            walk.keep(machines)
            walk.look_again(lacks)


def agrees_with_all(where: str) -> bool:
    """Tell whether every claim agrees with a member."""
    return not disagreeing(bench(where))


def checked(file: Path, walks: Sequence[Array], command: str, most: int) -> tuple[list[Array], int]:
    """Return machines with which every claim agrees, so many at most, and how many were asked.

    Asked is where machines were on their walk, in any order, until there are enough; all of them are written into a
    file on the way.
    """
    places = list({shares.tobytes(): shares for walk in walks for shares in walk}.values())
    np.random.default_rng(len(places)).shuffle(places)
    write(file, places, command)
    found, asked = list[Array](), 0
    for shares, agreeing in zip(places, at_once(agrees_with_all, names_in(file, len(places))), strict=True):
        found, asked = [*found, shares] if agreeing else found, asked + 1
        sys.stderr.write(f"\r{len(found)} of {asked} machines agree with every claim, {len(places)} in all ")
        if len(found) == most:
            break
    sys.stderr.write("\n")
    return found, asked


def main() -> None:
    """Walk, check, write."""
    asked = argparse.ArgumentParser(prog="python -m research.cloud", description=__doc__)
    asked.add_argument("--seed", type=int, default=1)
    asked.add_argument("--rounds", type=int, default=420, help="of steps")
    asked.add_argument("--starts", type=int, default=3, help="calibrations from anywhere, one seed after the other")
    asked.add_argument("--out", type=Path, default=PAPER)
    given = asked.parse_args()
    command = f"python -m research.cloud --seed {given.seed} --rounds {given.rounds} --starts {given.starts}"
    sys.stderr.writelines(f"{line}\n" for line in excluded())
    found, tried, worth = list[list[Array]](), 0, 0.0
    begins = starts(given.seed, given.starts)
    for number, start in enumerate(begins):
        walking = walked(Findings(Evidence(bench())), start[None], seed=given.seed + number, rounds=given.rounds)
        walks = [walk.shares.copy() for walk, last in walking if last]
        # Those of the first half may still remember where they began.
        later = walks[len(walks) // 2 :]
        if not later:
            sys.stderr.write(f"{given.rounds} rounds are too few for a start: no machine lacks {LEVEL:g} or less\n")
            continue
        with TemporaryDirectory() as folder:
            agreeing, count = checked(Path(folder) / given.out.name, later, command, MEMBERS // len(begins))
        found, tried, worth = [*found, agreeing], tried + count, worth + effective(later)
    members = [machine for each in zip(*filter(None, found), strict=False) for machine in each]
    if not members:
        raise SystemExit("no machine of any walk agrees with every claim")
    write(given.out, members, command, starts=sum(map(bool, found)), asked=tried, effective=round(worth, 1))


if __name__ == "__main__":
    main()
