"""Comparison of controllers beyond the paper's: settling, belt following, rest, stiffness, and lower bounds."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from layflat.arrays import Array
from layflat.control import paper
from layflat.control import tracking as law_kind
from layflat.errors import LayflatError, MachineError
from layflat.experiments.beyond import settling, settling_bound
from layflat.experiments.beyond.moves import CONFIGURATION_COUNT, BeltFollowing, first_moves, measure_belt_following
from layflat.experiments.beyond.settling import RestBehaviour, Settling, measure_rest, median_learnt_ratio
from layflat.experiments.beyond.stiffness import Stiffness, measure_stiffness, with_stiffness_actuators
from layflat.machine import Machine, load
from layflat.machine.exchanged import with_tracking
from layflat.physics.arms.planar import PlanarArmPart

DEFAULT_MACHINE = "paper-arm-fast"  # with the larger valve, which is the builder's choice
BELT_SPEEDS = (0.3, 0.5)  # of the belt, m/s
TRACKING_LABEL, PAPER_LABEL, TUNED_LABEL = "tracking", "the paper's", "the paper's, tuned"
PAPERS_KIND, TRACKING_KIND = paper.KIND.name, law_kind.KIND.name  # any other kind is a user's
GRAVITY = 9.81  # of an upright arm, m/s2


@dataclass(frozen=True)
class Effort:
    """Amount of simulation in a comparison."""

    runs: int = 1024
    seeds: int = 3
    rest_time: float = 3600.0  # simulated time at rest, s
    bounds: int = CONFIGURATION_COUNT  # steps whose lower bound is searched
    plants: int = 24  # on which moves are repeated


QUICK_EFFORT = Effort(runs=128, seeds=1, rest_time=60.0, bounds=2, plants=6)


@dataclass
class Comparison:
    """Results of several control laws on a machine; None or empty: not possible, or not run yet."""

    machine: Machine  # with the tracking law
    effort: Effort
    laws: dict[str, Machine]  # machines with the compared controllers, by label
    settling: list[Settling] = field(default_factory=list)
    ablations: list[Settling] = field(default_factory=list)
    upright: Settling | None = None
    following: list[BeltFollowing] = field(default_factory=list)
    resting: RestBehaviour | None = None
    stiffness: Stiffness | None = None
    learnt: float | None = None  # error along repeated moves after five repeats, over that before them
    bounds: Array = field(default_factory=lambda: np.zeros(0))  # least times of the first steps, s
    ratios: Array = field(default_factory=lambda: np.zeros(0))  # times of the tracking law over these, (runs, steps)

    def settling_of(self, law: str, case: str) -> Settling | None:
        """Return the settling times of a law in a case; None if it was not simulated."""
        return next((one for one in self.settling if (one.law, one.case) == (law, case)), None)

    def belt_following_of(self, law: str, speed: float) -> BeltFollowing | None:
        """Return the belt following of a law at a speed (m/s); None if it was not simulated."""
        return next((one for one in self.following if (one.law, one.speed) == (law, speed)), None)

    def stages(self) -> list[tuple[str, Callable[[], None]]]:
        """Return the stages of the comparison in order: text for a progress bar, and the function to call."""
        stages: list[tuple[str, Callable[[], None]]] = []
        for law, machine in self.laws.items():
            stages.append((f"steps, {law}", partial(self._add_settling_times, law, machine)))
            if _is_planar(machine) and len(machine.joints) == 2:
                stages.append((f"belts, {law}", partial(self._add_belt_following, law, machine)))
        stages += [("parts left out", self._ablate), ("rest", self._measure_rest), ("repeats", self._repeat)]
        if _is_planar(self.machine):
            stages += [("gravity", self._settle_upright), ("stiffness", self._measure_stiffness)]
            stages += [("optimum", self._compute_bounds)]
        return stages

    def _add_settling_times(self, law: str, machine: Machine) -> None:
        """Simulate steps under a control law in all cases, and add the tip's settling times."""
        runs = self.effort.runs
        self.settling += [
            settling.settle_nominal(law, machine, runs),
            settling.settle_delayed(law, machine, runs),
            settling.settle_robust(law, machine, runs),
            *settling.settle_unknown_payload(law, machine, runs),
            settling.settle_robust(law, machine, runs, unknown_payload=True),
        ]

    def _ablate(self) -> None:
        self.ablations = settling.settle_ablations(self.machine, self.effort.runs // 2)

    def _settle_upright(self) -> None:
        """Simulate moves of the arm upright with unknown payloads; keep the settling of the later ones."""
        _, self.upright = settling.settle_unknown_payload(
            TRACKING_LABEL, self.machine, self.effort.runs // 2, gravity=GRAVITY
        )

    def _add_belt_following(self, law: str, machine: Machine) -> None:
        self.following += [measure_belt_following(law, machine, speed, self.effort.seeds) for speed in BELT_SPEEDS]

    def _measure_rest(self) -> None:
        self.resting = measure_rest(self.machine, self.effort.rest_time)

    def _repeat(self) -> None:
        self.learnt = median_learnt_ratio(self.machine, self.effort.plants)

    def _measure_stiffness(self) -> None:
        self.stiffness = measure_stiffness(with_stiffness_actuators(self.machine), min(self.effort.seeds, 2))

    def _compute_bounds(self) -> None:
        """Compute lower bounds of the settling time of the first moves, and the tracking law's ratios to them."""
        nominal = self.settling_of(TRACKING_LABEL, settling.NOMINAL_CASE)
        first = first_moves(self.machine)[: self.effort.bounds]
        self.bounds = np.array([settling_bound(self.machine, a.tolist(), b.tolist()).settling for a, b in first])
        if nominal is not None:
            times = nominal.times.reshape(-1, CONFIGURATION_COUNT)[:, : len(first)]
            self.ratios = times / self.bounds


def prepare_comparison(name: str = DEFAULT_MACHINE, effort: Effort | None = None) -> Comparison:
    """Return a comparison, not yet run, of the control laws that a machine can have.

    Args:
        name: name of a built-in machine, or its file; a user's control law in it is compared, too.
        effort: amount of simulation.

    Raises:
        InputError: there is no such machine.
        KindError: its control law is plain Python, which is too slow for so many runs.
        MachineError: the tracking law can't model it.
    """
    machine = load(name)
    tracking = with_tracking(machine)
    if tracking is None:
        raise MachineError(
            "the tracking law can't model its joints or valves",
            where=machine.origin,
            right="give a machine with spool valves and two hoses at each joint",
        )
    laws = {TRACKING_LABEL: tracking}
    if machine.controller is not None and machine.control_law.name not in {PAPERS_KIND, TRACKING_KIND}:
        machine.control_law.check_compiled("in comparisons")
        laws = {machine.control_law.name: machine, TRACKING_LABEL: tracking}
    if machine.control_law.gains is not None and all(joint.gains is not None for joint in machine.joints.values()):
        laws = {PAPER_LABEL: machine, **_tuned_variants(name), TRACKING_LABEL: tracking}
    return Comparison(tracking, effort or Effort(), laws)


def _tuned_variants(name: str) -> dict[str, Machine]:
    """Return a built-in machine's variant with tuned gains, by its label; empty if there is none."""
    try:
        return {TUNED_LABEL: load(f"{name}-tuned")}
    except LayflatError:
        return {}


def _is_planar(machine: Machine) -> bool:
    return isinstance(machine.arm, PlanarArmPart)
