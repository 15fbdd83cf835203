"""What a controller has to stand, and what it costs.

It has to stand payloads, supplies, losses, drifts and noise that differ from run to run, in several moves. It costs the
seconds until moves settle, over all conditions, the worst of them and the nominal ones most. A move costs the time
until the joint stays within 0.3 deg of its goal, or the tip within 2 mm of its. Where it does not, it costs the whole
window, 0.3 s, and 0.1 s for every such distance that error and swing remain (2 s at most). Overshoot of a joint beyond
1 deg costs 0.05 s per degree. A run that diverges costs 5 s a move. To the mean of all moves come half the mean of the
worst twentieth, and the slowest move under nominal conditions.
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
from layflat.motion.dynamics import room_at_rest
from layflat.motion.limits import abilities
from layflat.motion.scenario import Scenario
from layflat.sim.ensemble import ensemble
from layflat.sim.ensemble.parallel import TIP_BAND
from layflat.sim.metrics import BAND

FEW = {
    1: (((-1 / 3,), (1 / 3,), (0.36,)), ((1 / 3,), (-1 / 3,), (-1 / 2,)), ((0.0,), (1 / 6,), (-2 / 3,))),
    2: (
        ((-1 / 3, -1 / 3), (1 / 3, -1 / 3), (1 / 3, 1 / 3)),
        ((1 / 3, 1 / 3), (-1 / 3, 1 / 3), (-1 / 3, -1 / 3)),
        ((0.0, 0.0), (1 / 6, 1 / 6), (-1 / 2, 1 / 2)),
        ((1 / 3, 0.0), (0.36, -1 / 2), (-2 / 3, -0.54)),
    ),
}
"""Sequences of postures of one joint and of two, angles as shares of half a stroke."""

FAR, TURN = (1 / 6, -1 / 2, 0.36, -0.54), (1 / 3, -1 / 6, -0.4, 1 / 2)
"""Where joints go all at once, and where every other one goes; what there are more of begins anew."""

REST = 0.3  # time at the first posture, s
PULL = 0.15  # shares of a range that count as its ends: there the worst is met
NOMINAL = 8  # one run in so many is nominal
METRICS = ("settling", "overshoot", "steady_error", "ripple", "tip_settling", "tip_error")  # that any cost asks for


NEVER, REMAINS, MOST = 0.3, 0.1, 2.0
OVERSHOOT, FREE = 0.05, 1.0
DIVERGED = 5.0
WORST, WEIGHT = 20, 0.5


@dataclass(frozen=True)
class Measure:
    """By what moves are judged; arrays are (run, move, joint), or (run, move, 1) where it is the tip."""

    within: str  # distance from the goal within which a move has settled, for people
    what: str  # settles, for people
    settling: Callable[[xarray.Dataset], Array]  # s
    remains: Callable[[xarray.Dataset], Array]  # error and swing at the end of a move, over that distance
    overshoot: Callable[[xarray.Dataset], Array]  # deg

    @property
    def statement(self) -> str:
        """Return what it costs, in a sentence, for people."""
        return (
            f"The cost: seconds until {self.what} within {self.within}, as a mean over all conditions, plus half the "
            "mean of the worst twentieth, plus the slowest move under nominal conditions; moves that never settle or "
            "overshoot cost more."
        )


JOINTS = Measure(
    f"{np.degrees(BAND):g} deg",
    "moves settle",
    lambda runs: runs["settling"].to_numpy(),
    lambda runs: (np.abs(runs["steady_error"].to_numpy()) + runs["ripple"].to_numpy()) / BAND,
    lambda runs: np.degrees(runs["overshoot"].to_numpy()),
)
TIP = Measure(
    f"{1e3 * TIP_BAND:g} mm",
    "the tip settles",
    lambda runs: runs["tip_settling"].to_numpy()[..., None],
    lambda runs: runs["tip_error"].to_numpy()[..., None] / TIP_BAND,
    lambda runs: np.zeros((*runs["tip_settling"].shape, 1)),
)


@dataclass(frozen=True)
class Spread:
    """Spread of conditions about nominal."""

    payload: float = 4 / 3  # from nothing to this share of the nominal one: the paper's arm carries up to 2 kg
    supply: float = 0.1  # share of the gauge supply pressure, either way
    losses: float = 0.3  # share of the losses in hoses and straps, either way
    drift: float = 0.1  # of the valves' centres, V, either way
    window: float = 1.7  # time that a move is given, s
    # Numbers (SI) by path of machines that take the place of the nominal one, an item a machine; none: only that.
    members: Mapping[str, Array] = field(default_factory=dict)


@dataclass(frozen=True)
class Conditions:
    """Runs that a candidate is judged by, each with its own conditions and one of the sequences of moves."""

    scenarios: list[Scenario]  # the sequences
    vary: Mapping[str, Array]  # one number a run, by path (see `sim.ensemble`)
    nominal: int  # so many runs, the first ones, are nominal; they make the first sequence
    window: float  # time that a move is given, s
    measure: Measure = JOINTS
    # Plants that are driven by the controller of the machine that is judged, and which of them each run has; none: that
    # machine is the plant.
    plants: tuple[Machine, ...] = ()
    which: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    device: str = "cpu"  # that makes the runs: see `ensemble`

    @property
    def runs(self) -> int:
        """Number of runs of one candidate."""
        return len(self.vary["seed"])

    def of(self, candidates: int) -> dict[str, Array]:
        """Return what varies over the runs of so many candidates, one candidate after the other."""
        return {path: np.tile(values, candidates) for path, values in self.vary.items()}

    def simulate(self, machine: Machine, vary: Mapping[str, Array], **options: Any) -> xarray.Dataset:
        """Return what becomes of these runs of so many candidates (see `of`)."""
        options |= {"device": self.device, "metrics": METRICS}
        if not self.plants:
            return ensemble(machine, self.scenarios, vary, **options)
        which = np.tile(self.which, len(vary["seed"]) // self.runs)
        found = []
        for number, plant in enumerate(self.plants):
            own = {path: values[which == number] for path, values in vary.items()}
            found.append(ensemble(plant, self.scenarios, own, controller=machine, **options))
        order = np.argsort(np.argsort(which, kind="stable"), kind="stable")
        return xarray.concat(found, "run").isel(run=order)


def conditions(machine: Machine, runs: int, spread: Spread | None = None, seed: int = 0) -> Conditions:
    """Return so many runs (a power of two) that fill the spread about a nominal machine evenly, its ends included.

    The seed is that of the choice, and of the first run's noise.
    """
    from scipy.stats import qmc  # noqa: PLC0415  # takes long to import

    spread, names, nominal = spread or Spread(), list(machine.joints), max(1, runs // NOMINAL)
    share = qmc.Sobol(3 + len(names), seed=seed).random(runs)
    share = np.where(share < PULL, 0.0, np.where(share > 1.0 - PULL, 1.0, share))
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
            vary[f"joint.{name}.{part}.loss_share"] = usual.loss_share * (1.0 + spread.losses * about[:, 2])
    for path, values in vary.items():
        values[:nominal] = 0.0 if path.startswith("scenario.") else value_at(machine, path)
    scenarios = sequences(machine, spread.window)
    sequence = np.arange(runs) % len(scenarios)
    sequence[:nominal] = 0
    vary |= {"seed": seed + np.arange(runs, dtype=float), "scenario": sequence.astype(float)}
    return Conditions(scenarios, vary, nominal, spread.window)


def sequences(machine: Machine, window: float) -> list[Scenario]:
    """Return the sequences of moves of a machine, each given so much time, s."""
    return [_moves(machine, postures, window) for postures in sequences_of(len(machine.joints))]


Posture = tuple[float, ...]


def sequences_of(joints: int) -> Sequence[Sequence[Posture]]:
    """Return sequences of postures, equally many in each, angles as shares of half a stroke.

    The first takes one joint after the other from one side to the other, the second back; then all move at once. Of
    120 deg that makes steps of 40 deg of single joints, and others of all together, from 2 to 60 deg.
    """
    if joints in FEW:
        return FEW[joints]
    there = [tuple(1 / 3 if j < moved else -1 / 3 for j in range(joints)) for moved in range(joints + 1)]
    back = [tuple(-share for share in posture) for posture in there]
    far, turn = ((0.0, *(ways[i % len(ways)] for i in range(joints))) for ways in (FAR, TURN))
    opposed = [tuple((-1) ** j * share for j in range(joints)) for share in far]
    mixed = [tuple(b if j % 2 else a for j in range(joints)) for a, b in zip(far, turn, strict=True)]
    return there, back, opposed, mixed


def nominal_postures(joints: int) -> Array:
    """Return the postures of the first sequence, in which one joint moves at a time, (postures, joints)."""
    return np.array(sequences_of(joints)[0])


def _moves(machine: Machine, postures: Sequence[Posture], window: float) -> Scenario:
    halves = [0.5 * joint.stops.working_stroke for joint in machine.joints.values()]
    rows = [[share * half for share, half in zip(posture, halves, strict=True)] for posture in postures]
    times = [0.0, *(REST + window * i for i in range(len(rows) - 1))]
    return Scenario(demand=list(zip(times, rows, strict=True)), duration=REST + window * (len(rows) - 1))


def check_carried(machine: Machine, by: Conditions) -> None:
    """Raise MachineError if a joint can't hold itself in a posture that it is asked for, with all that it has to stand.

    Args:
        machine: that is judged.
        by: the conditions.
    """
    vary = by.vary
    payload = max(float(np.max(vary.get(f"{of}.payload", machine.arm.payload))) for of in ("arm", "scenario"))
    least = machine.supply.pressure_gauge
    least = min(float(np.min(vary.get(path, least))) for path in ("supply.pressure_gauge", "scenario.supply"))
    able = abilities(changed(machine, "supply.pressure_gauge", least))
    halves = np.array([0.5 * joint.stops.working_stroke for joint in machine.joints.values()])
    postures = halves * np.concatenate([np.array(sequence) for sequence in sequences_of(len(halves))])
    room, _ = room_at_rest(machine, able, postures, payload)
    if room.min() <= 0.0:
        name = list(machine.joints)[int(np.argmin(room / able.torque))]
        what = f"joint {name!r} can't hold {payload:.3g} kg at {least / 1e5:.3g} bar in the moves that tuning judges by"
        raise MachineError(what, where=machine.origin, right="a smaller payload, a wider hose or more pressure")


def move_costs(runs: xarray.Dataset, window: float, measure: Measure = JOINTS) -> Array:
    """Return the cost of every move, s, (run, move, joint), or (run, move, 1) of the tip."""
    settling, overshoot = measure.settling(runs), measure.overshoot(runs)
    never = window + NEVER + np.minimum(REMAINS * measure.remains(runs), MOST)
    cost = np.where(np.isfinite(settling), settling, never) + OVERSHOOT * np.maximum(overshoot - FREE, 0.0)
    return np.where(np.isnan(settling), DIVERGED, cost)


def candidate_costs(runs: xarray.Dataset, by: Conditions, candidates: int) -> Array:
    """Return the cost of every candidate, s: its runs follow each other."""
    costs = move_costs(runs, by.window, by.measure).reshape(candidates, by.runs, -1)
    nominal = costs[:, : by.nominal].max(axis=2).mean(axis=1)
    ordered = np.sort(costs.reshape(candidates, -1), axis=1)
    worst = ordered[:, -max(1, ordered.shape[1] // WORST) :].mean(axis=1)
    return np.asarray(ordered.mean(axis=1) + WEIGHT * worst + nominal)
