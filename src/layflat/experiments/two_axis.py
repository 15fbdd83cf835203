"""Two-axis arm: steps of each axis in turn, coupling, repeatability (Fig. 14, section 4.2)."""

from functools import cached_property
from math import inf, radians

import numpy as np
import xarray

from layflat.arrays import Array
from layflat.experiments.claim import ClaimQuantity, Evaluation, Experiment, claim
from layflat.experiments.open_loop import TORQUE_PERCENT, hysteresis_percent
from layflat.motion.kinematics import tip_position
from layflat.sim.metrics import SETTLING_BAND, TIP_BAND, disturbance, measure_move, settling_time, tip_settling
from layflat.sim.run import rollout_as_far

HALF_STEP = radians(20.0)  # half of a step, rad
LARGE_STEP_TIME, SMALL_STEP_TIME, END_TIME = 0.5, 4.0, 7.5  # of each joint's step, and of the end of the run, s
MOVE_SPANS = {
    "large": (LARGE_STEP_TIME, SMALL_STEP_TIME - 0.005),
    "small": (SMALL_STEP_TIME, END_TIME),
}  # start and end of each joint's move, s
APPROACH_COUNT = 20
APPROACH_TIME, REST_WINDOW = 2.5, 0.2  # of a move to or from mid-stroke, and of rest at its end, s
FINAL_BAND = radians(0.1)

DemandSteps = list[tuple[str | float, tuple[float, float]]]


def approach_demands() -> tuple[DemandSteps, Array]:
    """Return demands of approaches to mid-stroke from -20 and +20 deg alternately, and the time each ends, s."""
    demand: DemandSteps = []
    for i in range(APPROACH_COUNT):
        start = HALF_STEP if i % 2 else -HALF_STEP
        demand += [(2 * i * APPROACH_TIME, (start, start)), ((2 * i + 1) * APPROACH_TIME, (0.0, 0.0))]
    return demand, np.asarray(2 * APPROACH_TIME * (1.0 + np.arange(APPROACH_COUNT)))


def settling_to_final(run: xarray.Dataset, joint: str, since: float, until: float) -> float:
    """Return the time until a joint stays within 0.1 deg of its own final angle, s.

    Args:
        run: simulation run.
        joint: name of the joint.
        since: start of the move, s.
        until: end of the move, s; the final angle is the mean of the last tenth before it.
    """
    part = run.sel(joint=joint, time=slice(since, until))
    angle = part["angle"].to_numpy()
    final = float(angle[int(0.9 * len(angle)) :].mean())
    return settling_time(part["time"].to_numpy(), angle - final, FINAL_BAND)


class TwoAxisExperiment(Experiment):
    """Steps of each axis in turn, approaches of mid-stroke from both sides, and the hysteresis of both joints."""

    @cached_property
    def steps(self) -> xarray.Dataset:
        """Run with a step of the large joint, then one of the small joint."""
        demand: DemandSteps = [
            (0.0, (-HALF_STEP, -HALF_STEP)),
            (LARGE_STEP_TIME, (HALF_STEP, -HALF_STEP)),
            (SMALL_STEP_TIME, (HALF_STEP, HALF_STEP)),
        ]
        return self._run(demand, END_TIME, seed=2)

    @cached_property
    def rest_angles(self) -> Array:
        """Mean angles (rad, approaches x joints) over the last 0.2 s of each approach to mid-stroke.

        The approaches come from -20 and +20 deg alternately.
        """
        demand, ends = approach_demands()
        run = self._run(demand, float(ends[-1]), seed=3)
        return np.array(
            [
                run["angle"].sel(time=slice(end - REST_WINDOW, end)).mean("time").to_numpy()
                for end in ends
                if end <= run.time[-1] + 1.0
            ]
        )

    @cached_property
    def tip(self) -> Array:
        """Positions at which the tip comes to rest, m, (approaches, 2)."""
        return tip_position(self.bench.arm, self.rest_angles)

    def _run(self, demand: DemandSteps, duration: float, seed: int) -> xarray.Dataset:
        """Simulate the arm with its brakes, up to a divergence; raise MachineError if it lacks a joint."""
        for name in MOVE_SPANS:
            self.bench.joint(name)
        return rollout_as_far(self.bench.arm, demand, duration=duration, brake=self.bench.brake, seed=seed)

    @claim("two-axis-settling")
    def settling(self) -> Evaluation:
        """Measure the settling of the slower joint and of the tip after a step of either joint."""
        run = self.steps
        if float(run["time"][-1]) < END_TIME - 0.01:
            return [ClaimQuantity("diverged after", float(run["time"][-1]), "s")], False
        quantities: list[ClaimQuantity] = []
        for name, span in MOVE_SPANS.items():
            times = {
                "demand": max(measure_move(run, joint, *span, SETTLING_BAND).settling for joint in MOVE_SPANS),
                "final": max(settling_to_final(run, joint, *span) for joint in MOVE_SPANS),
                "tip": tip_settling(run, *span, TIP_BAND),
            }
            quantities += [
                ClaimQuantity(f"{name} step: {reference}", time, "s", "about 1.5") for reference, time in times.items()
            ]
        return quantities, max(quantity.value for quantity in quantities) <= 1.5

    @claim("repeatability")
    def repeatability(self) -> Evaluation:
        """Measure half the range of each joint's rest angles, and the tip's greatest distance from its mean."""
        complete = len(self.rest_angles) == APPROACH_COUNT
        half_range = np.degrees(np.ptp(self.rest_angles, axis=0)) / 2 if complete else np.array([inf, inf])
        tip = self.tip - self.tip.mean(axis=0) if complete else np.array([[inf, inf]])
        reach = float(np.linalg.norm(tip, axis=1).max()) * 1000
        return [
            ClaimQuantity("large", float(half_range[0]), "deg", "0.1"),
            ClaimQuantity("small", float(half_range[1]), "deg", "0.1"),
            ClaimQuantity("tip", reach, "mm", "1 to 2"),
        ], half_range.max() <= 0.1 and reach <= 2.0

    @claim("coupling")
    def coupling(self) -> Evaluation:
        """Compare the disturbance of each joint by the other's step."""
        large = disturbance(self.steps, "large", *MOVE_SPANS["small"])
        small = disturbance(self.steps, "small", *MOVE_SPANS["large"])
        ends = [
            abs(measure_move(self.steps, joint, *span).steady_error)
            for span in MOVE_SPANS.values()
            for joint in MOVE_SPANS
        ]
        return [
            ClaimQuantity("large disturbed", float(np.degrees(large)), "deg", "little"),
            ClaimQuantity("small disturbed", float(np.degrees(small)), "deg", "more"),
            ClaimQuantity("worst error at rest", float(np.degrees(max(ends))), "deg"),
        ], large <= 0.35 * small and max(ends) <= SETTLING_BAND

    @claim("overall-hysteresis")
    def overall(self) -> Evaluation:
        """Measure the hysteresis of both joints with their brakes."""
        both = {name: hysteresis_percent(self.bench.curve(name, brake=self.bench.brake)) for name in MOVE_SPANS}
        quantities = [ClaimQuantity(name, value, TORQUE_PERCENT, "about 25") for name, value in both.items()]
        return quantities, all(23.0 <= value <= 27.0 for value in both.values())
