"""What a controller beyond the paper's is compared by: settling, following, resting, stiffness, and what is best."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from layflat.arrays import Array
from layflat.control import paper
from layflat.control import tracking as law_kind
from layflat.errors import LayflatError, MachineError
from layflat.experiments.beyond import settling
from layflat.experiments.beyond.belts import Following, following
from layflat.experiments.beyond.moves import POSTURES, steps
from layflat.experiments.beyond.optimum import settling_bound
from layflat.experiments.beyond.settling import Resting, Settling, learnt_ratio, resting
from layflat.experiments.beyond.stiffness import Stiffness, adjustable, stiffnesses
from layflat.machine import Machine, load
from layflat.machine.exchanged import with_tracking
from layflat.physics.arms.planar import PlanarArmPart

USUAL = "paper-arm-fast"  # machine that is compared on: the larger valve is the builder's choice
SPEEDS = (0.3, 0.5)  # of the belt, m/s
TRACKING, PAPERS, TUNED = "tracking", "the paper's", "the paper's, tuned"
PAPERS_KIND, TRACKING_KIND = paper.KIND.name, law_kind.KIND.name  # others are a user's own
EARTH = 9.81  # m/s2


@dataclass(frozen=True)
class Effort:
    """Amount that is simulated."""

    runs: int = 1024
    seeds: int = 3
    rest: float = 3600.0  # s
    bounds: int = POSTURES  # steps for which an optimum is sought
    plants: int = 24  # on which moves are repeated


QUICK = Effort(runs=128, seeds=1, rest=60.0, bounds=2, plants=6)


@dataclass
class Comparison:
    """Findings for a machine with several laws; what it can't do is not there."""

    machine: Machine  # with the tracking law
    effort: Effort
    laws: dict[str, Machine]  # whose controllers are compared
    settling: list[Settling] = field(default_factory=list)
    ablations: list[Settling] = field(default_factory=list)
    upright: Settling | None = None
    following: list[Following] = field(default_factory=list)
    resting: Resting | None = None
    stiffness: Stiffness | None = None
    learnt: float | None = None  # error along repeated moves after five repeats, over that before them
    bounds: Array = field(default_factory=lambda: np.zeros(0))  # least times of the first steps, s
    ratios: Array = field(default_factory=lambda: np.zeros(0))  # times of the tracking law over these, (runs, steps)

    def of(self, law: str, case: str) -> Settling | None:
        """Return the settling times of a law in a case, if they were found."""
        return next((one for one in self.settling if (one.law, one.case) == (law, case)), None)

    def belt(self, law: str, speed: float) -> Following | None:
        """Return how a law followed a belt, if it was found."""
        return next((one for one in self.following if (one.law, one.speed) == (law, speed)), None)

    def stages(self) -> list[tuple[str, Callable[[], None]]]:
        """Return what is to be done, in order, with words for a progress bar."""
        found: list[tuple[str, Callable[[], None]]] = []
        for law, machine in self.laws.items():
            found.append((f"steps, {law}", partial(self._settle, law, machine)))
            if _is_planar(machine) and len(machine.joints) == 2:
                found.append((f"belts, {law}", partial(self._follow, law, machine)))
        found += [("parts left out", self._ablate), ("rest", self._rest), ("repeats", self._repeat)]
        if _is_planar(self.machine):
            found += [("gravity", self._hang), ("stiffness", self._push), ("optimum", self._bound)]
        return found

    def _settle(self, law: str, machine: Machine) -> None:
        runs = self.effort.runs
        self.settling += [
            settling.nominal(law, machine, runs),
            settling.late(law, machine, runs),
            settling.robust(law, machine, runs),
            *settling.unknown_payload(law, machine, runs),
            settling.robust(law, machine, runs, unknown_payload=True),
        ]

    def _ablate(self) -> None:
        self.ablations = settling.ablations(self.machine, self.effort.runs // 2)

    def _hang(self) -> None:
        _, self.upright = settling.unknown_payload(TRACKING, self.machine, self.effort.runs // 2, gravity=EARTH)

    def _follow(self, law: str, machine: Machine) -> None:
        self.following += [following(law, machine, speed, self.effort.seeds) for speed in SPEEDS]

    def _rest(self) -> None:
        self.resting = resting(self.machine, self.effort.rest)

    def _repeat(self) -> None:
        self.learnt = learnt_ratio(self.machine, self.effort.plants)

    def _push(self) -> None:
        self.stiffness = stiffnesses(adjustable(self.machine), min(self.effort.seeds, 2))

    def _bound(self) -> None:
        nominal = self.of(TRACKING, settling.NOMINAL)
        first = steps(self.machine)[: self.effort.bounds]
        self.bounds = np.array([settling_bound(self.machine, a.tolist(), b.tolist()).settling for a, b in first])
        if nominal is not None:
            times = nominal.times.reshape(-1, POSTURES)[:, : len(first)]
            self.ratios = times / self.bounds


def comparison(name: str = USUAL, effort: Effort | None = None) -> Comparison:
    """Return a comparison that is to be made of the laws that a machine can have.

    Args:
        name: of a built-in machine, or its file; a control law of its own is compared, too.
        effort: how much is simulated.

    Raises:
        InputError: there is no such machine.
        KindError: its own control law is plain Python, too slow for so many runs.
        MachineError: the tracking law can't have it.
    """
    machine = load(name)
    tracking = with_tracking(machine)
    if tracking is None:
        raise MachineError(
            "the tracking law can't model its joints or valves",
            where=machine.origin,
            right="give a machine with spool valves and two hoses at each joint",
        )
    laws = {TRACKING: tracking}
    if machine.controller is not None and machine.control_law.name not in {PAPERS_KIND, TRACKING_KIND}:
        machine.control_law.check_compiled("in comparisons")
        laws = {machine.control_law.name: machine, TRACKING: tracking}
    if machine.control_law.gains is not None and all(joint.gains is not None for joint in machine.joints.values()):
        laws = {PAPERS: machine, **_tuned(name), TRACKING: tracking}
    return Comparison(tracking, effort or Effort(), laws)


def _tuned(name: str) -> dict[str, Machine]:
    """Return the same machine with tuned gains, where one is built in."""
    try:
        return {TUNED: load(f"{name}-tuned")}
    except LayflatError:
        return {}


def _is_planar(machine: Machine) -> bool:
    return isinstance(machine.arm, PlanarArmPart)
