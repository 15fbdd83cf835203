"""Settling of the tip under a controller, its rest and its repeated moves: on the arm it models, and on others."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, get_args

import numpy as np
from numpy.typing import ArrayLike

from layflat.arrays import Array
from layflat.control.tracking import LawPart, TrackingControllerPart
from layflat.description.change import changed_all, value_at
from layflat.experiments.beyond.moves import CONFIGURATION_COUNT, FIRST_MOVE_TIME, first_moves, move_sequences
from layflat.machine import Machine
from layflat.motion.optimal import plan_time_optimal
from layflat.motion.path import JointLine
from layflat.motion.scenario import Scenario
from layflat.sim import rollout
from layflat.sim.ensemble import ensemble
from layflat.sim.repeats import learnt_error_ratio
from layflat.tune.robust import robust_plant_groups, robust_plants

MOVE_COUNT = 5  # consecutive moves, over which the payload is estimated
PLANAR_MAX_PAYLOAD = 2.0  # of a planar arm, kg: the paper's
SPATIAL_PAYLOAD_RATIO = 2.0  # greatest payload of an arm in space over that of its description
PAYLOAD_DEVIATION = 0.3  # standard deviation of an unknown payload over the greatest payload


@dataclass(frozen=True)
class Settling:
    """Settling times of the tip under one law, s; infinite where it did not settle in `moves.MOVE_INTERVAL`."""

    law: str
    case: str
    times: Array

    @property
    def median(self) -> float:
        """Median settling time, s."""
        return float(np.median(self.times))

    @property
    def late(self) -> float:
        """Time within which 95 of 100 steps settle, s."""
        return float(np.quantile(self.times, 0.95, method="higher"))

    @property
    def unsettled(self) -> int:
        """Number of steps that did not settle."""
        return int((~np.isfinite(self.times)).sum())


NOMINAL_CASE, DELAYED_CASE, ROBUST_CASE = "as described", "a control cycle of delay, known", "plants that differ"
FIRST_MOVE_CASE, LATER_MOVES_CASE = "payload unknown, first move", "payload unknown, later moves"
ROBUST_PAYLOAD_CASE = "plants that differ, payload unknown"


def settle_nominal(law: str, machine: Machine, runs: int) -> Settling:
    """Return the tip's settling times (s) of simulated steps of a machine with its own controller.

    Args:
        law: label of the control law.
        machine: machine with that law.
        runs: number of simulated steps, with one move each.
    """
    return Settling(
        law, NOMINAL_CASE, _settling_times(machine, move_sequences(machine, 1), _vary_runs(runs), machine)[:, 0]
    )


def settle_delayed(law: str, machine: Machine, runs: int) -> Settling:
    """Return the tip's settling times (s) of steps with valves a control cycle slower, as the controller knows.

    Args:
        law: label of the control law.
        machine: machine with that law.
        runs: number of simulated steps, with one move each.
    """
    delay = value_at(machine, "valve.delay") + machine.cycle
    return Settling(law, DELAYED_CASE, settle_nominal(law, changed_all(machine, {"valve.delay": delay}), runs).times)


def settle_robust(law: str, machine: Machine, runs: int, *, unknown_payload: bool = False) -> Settling:
    """Return the tip's settling times (s) of steps of plants that differ from the model (see `tune.robust`).

    Args:
        law: label of the control law.
        machine: model, with that law.
        runs: number of simulated steps, with one move each.
        unknown_payload: whether the payload varies and the controller does not know it.
    """
    driver, draw, times = with_unknown_payload(machine) if unknown_payload else machine, np.random.default_rng(3), []
    for plant_set in robust_plant_groups(machine, runs):
        count = len(plant_set.vary["valve.delay"])
        vary: dict[str, ArrayLike] = _vary_runs(count) | dict(plant_set.vary)
        if unknown_payload:
            vary["scenario.payload"] = draw.uniform(0.0, max_payload(machine), count)
        times.append(_settling_times(plant_set.machine, move_sequences(machine, 1), vary, driver)[:, 0])
    return Settling(law, ROBUST_PAYLOAD_CASE if unknown_payload else ROBUST_CASE, np.concatenate(times))


def settle_unknown_payload(law: str, machine: Machine, runs: int, *, gravity: float = 0.0) -> tuple[Settling, Settling]:
    """Return the tip's settling times (s) of consecutive moves with a payload that the controller does not know.

    Args:
        law: label of the control law.
        machine: machine with that law.
        runs: number of runs.
        gravity: acceleration in the arm's plane, m/s2; 0: the machine's own.

    Returns:
        Settling of the first move, and of the moves after the second.
    """
    arm = changed_all(with_unknown_payload(machine), {"arm.gravity": gravity} if gravity else {})
    vary: dict[str, ArrayLike] = _vary_runs(runs)
    vary["scenario.payload"] = np.random.default_rng(12).uniform(0.0, max_payload(machine), runs)
    times = _settling_times(arm, move_sequences(machine, MOVE_COUNT), vary, arm)
    return Settling(law, FIRST_MOVE_CASE, times[:, 0]), Settling(law, LATER_MOVES_CASE, times[:, 2:].ravel())


def with_unknown_payload(machine: Machine) -> Machine:
    """Return the machine with a tracking law that estimates the payload; a machine with another law is unchanged.

    The described payload, where the estimate begins, becomes half of `max_payload`.
    """
    if not isinstance(machine.controller, TrackingControllerPart):
        return machine
    upper = max_payload(machine)
    return changed_all(machine, {"arm.payload": upper / 2, "controller.payload_std": PAYLOAD_DEVIATION * upper})


def max_payload(machine: Machine) -> float:
    """Return the greatest payload of an arm, kg."""
    return SPATIAL_PAYLOAD_RATIO * machine.arm.payload if machine.arm.own_links else PLANAR_MAX_PAYLOAD


def settle_ablations(machine: Machine, runs: int) -> list[Settling]:
    """Return the settling times (s) of `settle_robust` under the tracking law without each of its parts in turn."""
    results = []
    for part in get_args(LawPart):
        lacking = changed_all(machine, {"controller.disabled": (part,)})
        results.append(settle_robust(f"tracking, without {part}", lacking, runs))
    return results


def _vary_runs(runs: int) -> dict[str, ArrayLike]:
    return {"scenario": np.arange(runs) % CONFIGURATION_COUNT, "seed": np.arange(runs)}


def _settling_times(
    machine: Machine, scenarios: Sequence[Scenario], vary: Mapping[str, ArrayLike], driver: Machine
) -> Array:
    """Return the tip's settling times (s), (runs, moves), under the driver's controller; infinite: not settled."""
    runs = ensemble(machine, scenarios, vary, controller=driver, metrics=("tip_settling",))
    times: Array = runs["tip_settling"].to_numpy()
    return np.where(np.isnan(times), np.inf, times)


REST_START = 2.5  # after the step, s; from then on the arm has to rest


class RestBehaviour(NamedTuple):
    """Motion and air consumption of an arm at rest."""

    moved: float  # greatest displacement of any joint, rad
    air: float  # ratio of its air to that with dither on all the time


def measure_rest(machine: Machine, seconds: float) -> RestBehaviour:
    """Return motion in a rest of so many seconds after a move, and air over that with dither all the time (10 s)."""
    moved, air = _simulate_rest(machine, seconds)
    _, always = _simulate_rest(changed_all(machine, {"valve.dither.min": 1.0}), min(seconds, 10.0))
    return RestBehaviour(moved, air / always)


def _simulate_rest(machine: Machine, seconds: float) -> tuple[float, float]:
    """Simulate a move and so many seconds of rest, from `REST_START` after it.

    Returns:
        Greatest displacement of a joint from the start of the rest, rad, and mean consumption of air, kg/s.
    """
    before, after = first_moves(machine)[0]
    demand = [(0.0, before.tolist()), (FIRST_MOVE_TIME, after.tolist())]
    run = rollout(machine, demand, duration=FIRST_MOVE_TIME + REST_START + seconds, seed=1)
    first = round((FIRST_MOVE_TIME + REST_START) / machine.cycle)
    angles, air = run["angle"].to_numpy()[first:], run["air_taken"].sum("joint").to_numpy()[first:]
    return float(np.abs(angles - angles[0]).max()), float(air[-1] - air[0]) / seconds


REPEAT_COUNT = 5  # of each move in learning


def median_learnt_ratio(machine: Machine, count: int) -> float:
    """Return the median ratio, over plants, of the error along a move after five learnt repeats to that before.

    Each of `count` plants that differ from the machine makes a time-optimal step of its own; errors are the tip's rms.
    """
    ratios = []
    for plant, (before, after) in zip(robust_plants(machine, count), first_moves(machine) * count, strict=False):
        motion = plan_time_optimal(machine, JointLine(before, after))
        ratios.append(learnt_error_ratio(machine, plant, motion, REPEAT_COUNT))
    return float(np.median(ratios))
