"""Plants that differ from the model of their controller, and the validation of controllers.

A controller that is tuned on its own model has to be judged on other plants. These differ in friction, losses,
conductance and supply, have static friction and delay, and in every second run another law of losses. The validation
has conditions that no search uses, the same for every method and seed.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import xarray

from layflat.arrays import Array
from layflat.description.change import changed_all, value_at
from layflat.machine import Machine, changed
from layflat.machine.parts import Joint
from layflat.physics.friction.stribeck import StribeckPart
from layflat.physics.hysteresis.bouc_wen import BoucWenPart
from layflat.sim.metrics import disturbance
from layflat.sim.run import rollout_as_far
from layflat.tune.conditions import REST_TIME, Conditions, candidate_costs
from layflat.tune.search import MakeConditions

ROBUST_SET_TEXT = (
    "friction and losses ±30 %, conductance and supply ±20 %, friction at rest 1 to 1.5 times that in motion, "
    "up to a control cycle of delay, and in every second run another law of losses (Bouc and Wen's)"
)
"""The robust set in words."""

FRICTION_VARIATION, FLOW_VARIATION, MAX_STATIC_RATIO = 0.3, 0.2, 1.5
STRIBECK_VELOCITY = "2 deg/s"  # velocity at which half of the excess of static over kinetic friction is left
LOSS_DEFLECTION = "1 deg"  # of the other law of losses


@dataclass(frozen=True)
class PlantGroup:
    """Group of plants that differ from one machine in the values of some paths."""

    machine: Machine
    vary: Mapping[str, Array]  # one value per run, by path (SI)


def robust_plant_groups(machine: Machine, runs: int, *, seed: int = 0) -> list[PlantGroup]:
    """Return two groups of plants with random deviations from a machine, both with stiction.

    The second has Bouc-Wen hysteresis in its joints.

    Args:
        machine: nominal model of the controller, with spool valves.
        runs: number of plants in both groups together; the first has the odd one.
        seed: seed of the deviations (`ROBUST_SET_TEXT` lists them).
    """
    half, draw = runs // 2, np.random.default_rng(seed)
    sticking = _with_stiction(machine)
    return [
        PlantGroup(sticking, _draw_variations(sticking, runs - half, draw)),
        PlantGroup(_with_bouc_wen_losses(sticking), _draw_variations(sticking, half, draw)),
    ]


def robust_plants(machine: Machine, count: int, *, seed: int = 0) -> list[Machine]:
    """Return plants of the `robust_plant_groups` as complete machines.

    Args:
        machine: the controller's model, with spool valves.
        count: number of plants.
        seed: seed of the deviations (`ROBUST_SET_TEXT` lists them).
    """
    machines = []
    for group in robust_plant_groups(machine, count, seed=seed):
        paths = {
            "supply.pressure_gauge" if path == "scenario.supply" else path: values
            for path, values in group.vary.items()
        }
        rows = zip(*(numbers.tolist() for numbers in paths.values()), strict=True)
        machines += [changed_all(group.machine, dict(zip(paths, row, strict=True))) for row in rows]
    return machines


def _with_stiction(machine: Machine) -> Machine:
    """Return the machine with Stribeck friction in joints with Coulomb friction or none."""
    for name, joint in machine.joints.items():
        if joint.friction is None or joint.friction.kind == "coulomb":
            sticks = StribeckPart(kind="stribeck", static_ratio=1.0, velocity=STRIBECK_VELOCITY)
            machine = changed(machine, f"joint.{name}.friction", sticks)
    return machine


def _with_bouc_wen_losses(machine: Machine) -> Machine:
    """Return a copy of a machine whose joints have Bouc-Wen losses with the reference pressure of their own."""
    for name, joint in machine.joints.items():
        kept = joint.losses.model_dump(include={"reference_pressure_gauge", "pressure_free", "damping_time"})
        units = {"reference_pressure_gauge": "Pa", "damping_time": "s"}
        fields = {key: f"{value!r} {units[key]}" if key in units else value for key, value in kept.items()}
        machine = changed(
            machine, f"joint.{name}.losses", BoucWenPart(kind="bouc-wen", deflection=LOSS_DEFLECTION, **fields)
        )
    return machine


def _draw_variations(machine: Machine, runs: int, draw: np.random.Generator) -> dict[str, Array]:
    """Return random values of friction, losses, flow, supply and delay, (runs,) each, by path.

    The supply is `scenario.supply`, gauge, Pa.
    """
    variations: dict[str, Array] = {}
    for name, joint in machine.joints.items():
        for path in ("brake.torque", *_loss_paths(joint)):
            key = f"joint.{name}.{path}"
            variations[key] = value_at(machine, key) * draw.uniform(
                1.0 - FRICTION_VARIATION, 1.0 + FRICTION_VARIATION, runs
            )
        if isinstance(joint.friction, StribeckPart):
            variations[f"joint.{name}.friction.static_ratio"] = draw.uniform(1.0, MAX_STATIC_RATIO, runs)
    variations["valve.conductance"] = value_at(machine, "valve.conductance") * draw.uniform(
        1.0 - FLOW_VARIATION, 1.0 + FLOW_VARIATION, runs
    )
    variations["scenario.supply"] = machine.supply.pressure_gauge * draw.uniform(
        1.0 - FLOW_VARIATION, 1.0 + FLOW_VARIATION, runs
    )
    variations["valve.delay"] = value_at(machine, "valve.delay") + draw.uniform(0.0, machine.cycle, runs)
    return variations


def _loss_paths(joint: Joint) -> list[str]:
    """Return the paths, below the joint, of the loss fractions that are not zero."""
    parts = {"hose": joint.hose.loss_fraction, "strap": joint.strap.loss_fraction}
    return [f"{part}.loss_fraction" for part, share in parts.items() if share > 0.0]


VALIDATION_RUNS, VALIDATION_SEED = 256, 2_000_000_000  # runs of the validation, and their seed
SETTLING_LIMIT = 1.5  # time in which the paper's arm settles, s: section 4.2
MIN_WARNED_DEFLECTION, WARNED_RATIO = np.radians(3.0), 2.0
"""Least deflection of a joint by another one's step (rad) that is warned of, and its least ratio to that of before."""


@dataclass(frozen=True)
class Validation:
    """Results of a machine under the conditions of the validation."""

    settling: Array  # of joints or tip in every move of every run, s; infinite for moves that do not settle
    nominal: Array  # settling time of all joints in each move, mean of nominal runs, s
    cost: float  # s
    response: "xarray.Dataset"  # the first nominal run
    deflections: dict[str, float]  # of a joint by another one's step in this run, rad, by both in words

    @property
    def worst(self) -> float:
        """Longest settling time, s."""
        return float(self.settling.max())

    @property
    def late(self) -> int:
        """Return the number of moves that do not settle within the limit."""
        return int((self.settling > SETTLING_LIMIT).sum())


def validation_conditions(make_conditions: MakeConditions) -> Conditions:
    """Return the conditions of the validation."""
    return make_conditions(VALIDATION_RUNS, VALIDATION_SEED)


def validate(machine: Machine, make_conditions: MakeConditions) -> Validation:
    """Return the results of a machine, as it is described, under the conditions of the validation.

    Settling times of runs that diverge are infinite.
    """
    by = validation_conditions(make_conditions)
    runs = by.simulate(machine, by.repeat_varied(1))
    settling = by.measure.settling(runs)
    settling = np.where(np.isnan(settling), np.inf, settling)
    nominal: Array = settling[: by.nominal].max(axis=2).mean(axis=0)
    response = rollout_as_far(machine, scenario=by.scenarios[0], seed=int(by.vary["seed"][0]))
    cost, deflections = float(candidate_costs(runs, by, 1)[0]), _coupling_deflections(machine, response, by.window)
    return Validation(settling, nominal, cost, response, deflections)


def _coupling_deflections(machine: Machine, response: xarray.Dataset, window: float) -> dict[str, float]:
    """Return the maximum deflection of each joint by moves of another, in the nominal sequence, rad, by both in words.

    In an arm of more than two joints, the words only say "another one", and the largest of these deflections counts.
    """
    names, last, deflections = list(machine.joints), float(response["time"][-1]), dict[str, float]()
    for number, mover in enumerate(names):
        since = REST_TIME + window * number
        for name in names if since < last else ():
            if name != mover:
                what = f"{name} joint pushed by {'another' if len(names) > 2 else f'the {mover}'} one"
                deflections[what] = max(disturbance(response, name, since, since + window), deflections.get(what, 0.0))
    return deflections


def coupling_warnings(before: Validation | None, after: Validation) -> list[str]:
    """Return a warning for each joint that another's step deflects by over 3 deg, and over twice as far as before.

    Without `before`, 3 deg alone count.
    """
    messages = []
    for what, now in after.deflections.items():
        was = 0.0 if before is None else before.deflections.get(what, 0.0)
        if now > MIN_WARNED_DEFLECTION and now > WARNED_RATIO * was:
            than = "" if before is None else f", {np.degrees(was):.1f} deg before"
            messages.append(
                f"Coupling: {what} by {np.degrees(now):.1f} deg{than}. Only settling counts in the cost; where the "
                "path matters keep the gains of before, or tune from them, not from neutral values."
            )
    return messages
