"""Conditions under which a controller is judged, and its cost.

Payload, supply pressure, losses, drift and noise differ from run to run, in several sequences of moves. A move costs
its settling time: until the joint stays within 0.3 deg of its goal, or the tip within 2 mm. A move that does not settle
costs the whole window, 0.3 s, and 0.1 s per such distance of remaining error and oscillation (at most 2 s). Overshoot
of a joint beyond 1 deg costs 0.05 s per degree. A move of a run that diverges costs 5 s. The cost of a controller is
the mean of all moves, plus half the mean of the worst twentieth, plus the slowest move under nominal conditions.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import xarray
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.description.change import changed, value_at
from layflat.errors import MachineError
from layflat.machine import Machine
from layflat.motion.dynamics import torque_margin_at_rest
from layflat.motion.limits import joint_capabilities
from layflat.motion.path import half_strokes
from layflat.motion.scenario import Scenario
from layflat.sim.ensemble import ensemble
from layflat.sim.metrics import SETTLING_BAND, TIP_BAND

MOVE_SEQUENCES = {
    1: (((-1 / 3,), (1 / 3,), (0.36,)), ((1 / 3,), (-1 / 3,), (-1 / 2,)), ((0.0,), (1 / 6,), (-2 / 3,))),
    2: (
        ((-1 / 3, -1 / 3), (1 / 3, -1 / 3), (1 / 3, 1 / 3)),
        ((1 / 3, 1 / 3), (-1 / 3, 1 / 3), (-1 / 3, -1 / 3)),
        ((0.0, 0.0), (1 / 6, 1 / 6), (-1 / 2, 1 / 2)),
        ((1 / 3, 0.0), (0.36, -1 / 2), (-2 / 3, -0.54)),
    ),
}
"""Sequences of configurations of one joint and of two, angles as fractions of half a stroke."""

FAR_TARGETS, ALTERNATE_TARGETS = (1 / 6, -1 / 2, 0.36, -0.54), (1 / 3, -1 / 6, -0.4, 1 / 2)
"""Targets of simultaneous moves of all joints, and of every other joint, repeated for more joints than targets."""

REST_TIME = 0.3  # at the first configuration, s
END_FRACTION = 0.15  # of a range at either end that counts as the end itself: the worst cases lie there
RUNS_PER_NOMINAL = 8  # runs of which one is nominal
METRICS = ("settling", "overshoot", "steady_error", "ripple", "tip_settling", "tip_error")  # needed by the measures


UNSETTLED_COST, RESIDUAL_COST, MAX_RESIDUAL_COST = 0.3, 0.1, 2.0
OVERSHOOT_COST, FREE_OVERSHOOT = 0.05, 1.0
DIVERGENCE_COST = 5.0
TAIL_DIVISOR, TAIL_WEIGHT = 20, 0.5


@dataclass(frozen=True)
class SettlingMeasure:
    """Measure of moves, by joints or by the tip; arrays are (run, move, joint), or (run, move, 1) for the tip."""

    within: str  # settling band in words
    what: str  # subject and verb in words, such as "moves settle"
    settling: Callable[[xarray.Dataset], Array]  # settling time, s
    remains: Callable[[xarray.Dataset], Array]  # error and oscillation at the end of a move, over the settling band
    overshoot: Callable[[xarray.Dataset], Array]  # deg

    @property
    def statement(self) -> str:
        """Return the definition of the cost in a sentence."""
        return (
            f"The cost: seconds until {self.what} within {self.within}, as a mean over all conditions, plus half the "
            "mean of the worst twentieth, plus the slowest move under nominal conditions; moves that never settle or "
            "overshoot cost more."
        )


JOINT_MEASURE = SettlingMeasure(
    f"{np.degrees(SETTLING_BAND):g} deg",
    "moves settle",
    lambda runs: runs["settling"].to_numpy(),
    lambda runs: (np.abs(runs["steady_error"].to_numpy()) + runs["ripple"].to_numpy()) / SETTLING_BAND,
    lambda runs: np.degrees(runs["overshoot"].to_numpy()),
)
TIP_MEASURE = SettlingMeasure(
    f"{1e3 * TIP_BAND:g} mm",
    "the tip settles",
    lambda runs: runs["tip_settling"].to_numpy()[..., None],
    lambda runs: runs["tip_error"].to_numpy()[..., None] / TIP_BAND,
    lambda runs: np.zeros((*runs["tip_settling"].shape, 1)),
)


@dataclass(frozen=True)
class ConditionRanges:
    """Ranges of conditions about nominal."""

    payload: float = 4 / 3  # upper end over the nominal payload, the lower is 0: the paper's arm carries up to 2 kg
    supply: float = 0.1  # deviation either way, as a fraction of the gauge supply pressure
    losses: float = 0.3  # deviation either way, as a fraction of the losses in hoses and straps
    drift: float = 0.1  # of the valves' centres either way, V
    window: float = 1.7  # duration of a move, s
    # Values (SI) by path of machines that replace the nominal one, an item per machine; empty: none.
    members: Mapping[str, Array] = field(default_factory=dict)


@dataclass(frozen=True)
class Conditions:
    """Runs by which a candidate is judged, each with its conditions and one of the sequences of moves."""

    scenarios: list[Scenario]  # the sequences of moves
    vary: Mapping[str, Array]  # one value per run, by path (see `sim.ensemble`)
    nominal: int  # number of nominal runs, which come first and have the first sequence
    window: float  # duration of a move, s
    measure: SettlingMeasure = JOINT_MEASURE
    # Plants that the judged controller drives, and the index of each run's plant; empty: the judged machine itself.
    plants: tuple[Machine, ...] = ()
    which: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    device: str = "cpu"  # for the runs: see `ensemble`

    @property
    def runs(self) -> int:
        """Number of runs of one candidate."""
        return len(self.vary["seed"])

    def repeat_varied(self, candidates: int) -> dict[str, Array]:
        """Return the varied values over the runs of so many candidates, one candidate after the other."""
        return {path: np.tile(values, candidates) for path, values in self.vary.items()}

    def simulate(self, machine: Machine, vary: Mapping[str, Array], **options: Any) -> xarray.Dataset:
        """Return the metrics of these runs for one or more candidates, in the order of `vary`.

        Args:
            machine: machine with the controller; it is also the plant, unless `plants` has others.
            vary: one value per run, as of `repeat_varied`.
            options: other options of `ensemble` than device and metrics.
        """
        options |= {"device": self.device, "metrics": METRICS}
        if not self.plants:
            return ensemble(machine, self.scenarios, vary, **options)
        which = np.tile(self.which, len(vary["seed"]) // self.runs)
        results = []
        for number, plant in enumerate(self.plants):
            plant_vary = {path: values[which == number] for path, values in vary.items()}
            results.append(ensemble(plant, self.scenarios, plant_vary, controller=machine, **options))
        order = np.argsort(np.argsort(which, kind="stable"), kind="stable")
        return xarray.concat(results, "run").isel(run=order)


def sample_conditions(machine: Machine, runs: int, spread: ConditionRanges | None = None, seed: int = 0) -> Conditions:
    """Return conditions that fill the ranges about a nominal machine evenly (Sobol sequence), ends included.

    Members of a cloud are drawn at random. The first runs, one in `RUNS_PER_NOMINAL`, are nominal.

    Args:
        machine: the nominal one.
        runs: number of runs, a power of two.
        spread: ranges; default: those of `ConditionRanges`.
        seed: seed of the sequence, and of the first run's noise.
    """
    from scipy.stats import qmc  # noqa: PLC0415  # takes long to import

    spread, names, nominal = spread or ConditionRanges(), list(machine.joints), max(1, runs // RUNS_PER_NOMINAL)
    share = qmc.Sobol(3 + len(names), seed=seed).random(runs)
    share = np.where(share < END_FRACTION, 0.0, np.where(share > 1.0 - END_FRACTION, 1.0, share))
    about = 2.0 * share - 1.0
    drawn = np.random.default_rng(seed).integers(max(map(len, spread.members.values()), default=1), size=runs)
    vary = {path: numbers[drawn] for path, numbers in spread.members.items()}
    vary |= {
        "arm.payload": machine.arm.payload * spread.payload * share[:, 0],
        "supply.pressure_gauge": machine.supply.pressure_gauge * (1.0 + spread.supply * about[:, 1]),
    }
    for j, name in enumerate(names):
        vary[f"scenario.drift.{name}"] = spread.drift * about[:, 3 + j]
        for part, usual in (("hose", machine.joint[name].hose), ("strap", machine.joint[name].strap)):
            vary[f"joint.{name}.{part}.loss_fraction"] = usual.loss_fraction * (1.0 + spread.losses * about[:, 2])
    for path, values in vary.items():
        values[:nominal] = 0.0 if path.startswith("scenario.") else value_at(machine, path)
    scenarios = sequence_scenarios(machine, spread.window)
    return Conditions(scenarios, vary | assign_sequences(len(scenarios), runs, nominal, seed), nominal, spread.window)


def assign_sequences(sequences: int, runs: int, nominal: int, seed: int) -> dict[str, Array]:
    """Return scenario and seed of each run: the sequences in turn, and the first one for nominal runs.

    Args:
        sequences: number of sequences.
        runs: number of runs.
        nominal: number of nominal runs, which come first.
        seed: seed of the first run.
    """
    sequence = np.arange(runs) % sequences
    sequence[:nominal] = 0
    return {"seed": seed + np.arange(runs, dtype=float), "scenario": sequence.astype(float)}


def sequence_scenarios(machine: Machine, window: float) -> list[Scenario]:
    """Return scenarios with the sequences of moves of a machine, `window` (s) for each move."""
    return [
        _sequence_scenario(machine, configurations, window)
        for configurations in configuration_sequences(len(machine.joints))
    ]


StrokeFractions = tuple[float, ...]


def configuration_sequences(joints: int) -> Sequence[Sequence[StrokeFractions]]:
    """Return sequences of configurations, equally many in each, angles as fractions of half a stroke.

    In the first, one joint after the other moves from one side to the other, in the second back; then all move at once.
    For strokes of 120 deg, single joints make steps of 40 deg, and all together steps of 2 to 60 deg.
    One joint and two have `MOVE_SEQUENCES`.
    """
    if joints in MOVE_SEQUENCES:
        return MOVE_SEQUENCES[joints]
    forward = [tuple(1 / 3 if j < moved else -1 / 3 for j in range(joints)) for moved in range(joints + 1)]
    back = [tuple(-fraction for fraction in fractions) for fractions in forward]
    far, alternate = (
        (0.0, *(targets[i % len(targets)] for i in range(joints))) for targets in (FAR_TARGETS, ALTERNATE_TARGETS)
    )
    opposed = [tuple((-1) ** j * fraction for j in range(joints)) for fraction in far]
    mixed = [tuple(b if j % 2 else a for j in range(joints)) for a, b in zip(far, alternate, strict=True)]
    return forward, back, opposed, mixed


def nominal_configurations(joints: int) -> Array:
    """Return the first sequence, in which one joint moves at a time, (configurations, joints), in half strokes."""
    return np.array(configuration_sequences(joints)[0])


def _sequence_scenario(machine: Machine, configurations: Sequence[StrokeFractions], window: float) -> Scenario:
    """Return the scenario of steps: `REST_TIME` at the first configuration, then the next one every `window`, s."""
    rows = (np.array(configurations) * half_strokes(machine)).tolist()
    times = [0.0, *(REST_TIME + window * i for i in range(len(rows) - 1))]
    return Scenario(demand=list(zip(times, rows, strict=True)), duration=REST_TIME + window * (len(rows) - 1))


def check_joints_hold(machine: Machine, by: Conditions) -> None:
    """Refuse conditions whose largest payload and lowest supply pressure a joint can't bear at rest.

    Args:
        machine: machine that is judged.
        by: the conditions.

    Raises:
        MachineError: naming the joint.
    """
    vary = by.vary
    payload = max(float(np.max(vary.get(f"{of}.payload", machine.arm.payload))) for of in ("arm", "scenario"))
    supply = machine.supply.pressure_gauge
    supply = min(float(np.min(vary.get(path, supply))) for path in ("supply.pressure_gauge", "scenario.supply"))
    capabilities = joint_capabilities(changed(machine, "supply.pressure_gauge", supply))
    halves = half_strokes(machine)
    configurations = halves * np.concatenate([np.array(sequence) for sequence in configuration_sequences(len(halves))])
    margin, _ = torque_margin_at_rest(machine, capabilities, configurations, payload)
    if margin.min() <= 0.0:
        name = list(machine.joints)[int(np.argmin(margin / capabilities.torque))]
        what = (
            f"joint {name!r} can't hold {payload:.3g} kg at {supply / 1e5:.3g} bar in the moves that tuning judges by"
        )
        raise MachineError(what, where=machine.origin, right="give a smaller payload, a wider hose or more pressure")


def move_costs(runs: xarray.Dataset, window: float, measure: SettlingMeasure = JOINT_MEASURE) -> Array:
    """Return the cost of every move: its settling time, plus that of overshoot.

    A move that does not settle (infinite) costs the window and more, one that diverged (NaN) `DIVERGENCE_COST`.

    Args:
        runs: results with the metrics.
        window: duration of a move, s.
        measure: measure of settling, by joints or by the tip.

    Returns:
        Costs, s, (run, move, joint), or (run, move, 1) for the tip.
    """
    settling, overshoot = measure.settling(runs), measure.overshoot(runs)
    unsettled = window + UNSETTLED_COST + np.minimum(RESIDUAL_COST * measure.remains(runs), MAX_RESIDUAL_COST)
    cost = np.where(np.isfinite(settling), settling, unsettled) + OVERSHOOT_COST * np.maximum(
        overshoot - FREE_OVERSHOOT, 0.0
    )
    return np.where(np.isnan(settling), DIVERGENCE_COST, cost)


def candidate_costs(runs: xarray.Dataset, by: Conditions, candidates: int) -> Array:
    """Return the cost of every candidate, from the `move_costs` of its runs.

    It is the mean of all moves and joints, plus `TAIL_WEIGHT` times the mean of the worst twentieth, plus the mean over
    nominal runs of each one's costliest move.

    Args:
        runs: results, one candidate's runs after the other's.
        by: conditions of each candidate's runs.
        candidates: their number.

    Returns:
        Costs, s, (candidates,).
    """
    costs = move_costs(runs, by.window, by.measure).reshape(candidates, by.runs, -1)
    nominal = costs[:, : by.nominal].max(axis=2).mean(axis=1)
    ordered = np.sort(costs.reshape(candidates, -1), axis=1)
    worst = ordered[:, -max(1, ordered.shape[1] // TAIL_DIVISOR) :].mean(axis=1)
    return np.asarray(ordered.mean(axis=1) + TAIL_WEIGHT * worst + nominal)
