"""The two-axis arm: steps of each axis in turn, coupling, repeatability (Fig. 14, section 4.2)."""

from functools import cached_property
from math import inf, radians

import numpy as np
import xarray

from layflat.arrays import Array
from layflat.experiments.claim import Evaluated, Experiment, Quantity, claim
from layflat.experiments.open_loop import OF_TORQUE, percent
from layflat.motion.kinematics import tip_position
from layflat.sim.ensemble.parallel import TIP_BAND
from layflat.sim.metrics import BAND, disturbance, move, settling_time, tip_settling
from layflat.sim.run import rollout_as_far

HALF = radians(20.0)  # half of a step, rad
FIRST, SECOND, END = 0.5, 4.0, 7.5  # times of the large joint's step, of the small joint's, and of the end, s
MOVES = {"large": (FIRST, SECOND - 0.005), "small": (SECOND, END)}  # from when to when each joint's move lasts, s
REPEATS = 20
REPEAT_TIME, RESTS = 2.5, 0.2  # of a move when approaches are repeated, and over how much of it the arm is at rest, s
FINAL_BAND = radians(0.1)

Steps = list[tuple[str | float, tuple[float, float]]]


def approaches() -> tuple[Steps, Array]:
    """Return demands of approaches to mid-stroke from -20 and +20 deg by turns, and when each of them ends, s."""
    demand: Steps = []
    for i in range(REPEATS):
        away = HALF if i % 2 else -HALF
        demand += [(2 * i * REPEAT_TIME, (away, away)), ((2 * i + 1) * REPEAT_TIME, (0.0, 0.0))]
    return demand, np.asarray(2 * REPEAT_TIME * (1.0 + np.arange(REPEATS)))


def final_settling(run: xarray.Dataset, joint: str, since: float, until: float) -> float:
    """Return the time until a joint stays within 0.1 deg of its own final value, s."""
    part = run.sel(joint=joint, time=slice(since, until))
    angle = part["angle"].to_numpy()
    final = float(angle[int(0.9 * len(angle)) :].mean())
    return settling_time(part["time"].to_numpy(), angle - final, FINAL_BAND)


class TwoAxis(Experiment):
    """Steps of each axis in turn, approaches of one place from both sides, and the hysteresis of both joints."""

    @cached_property
    def steps(self) -> xarray.Dataset:
        """A step of the large joint, then one of the small joint."""
        demand: Steps = [(0.0, (-HALF, -HALF)), (FIRST, (HALF, -HALF)), (SECOND, (HALF, HALF))]
        return self._run(demand, END, seed=2)

    @cached_property
    def rest(self) -> Array:
        """Mean angles (rad, approaches x joints) over the last 0.2 s of each approach to mid-stroke.

        The approaches come from -20 and +20 deg by turns.
        """
        demand, ends = approaches()
        run = self._run(demand, float(ends[-1]), seed=3)
        return np.array(
            [
                run["angle"].sel(time=slice(end - RESTS, end)).mean("time").to_numpy()
                for end in ends
                if end <= run.time[-1] + 1.0
            ]
        )

    @cached_property
    def tip(self) -> Array:
        """Where the tip comes to rest, m, (approaches, 2)."""
        return tip_position(self.bench.arm, self.rest)

    def _run(self, demand: Steps, duration: float, seed: int) -> xarray.Dataset:
        for name in MOVES:
            self.bench.joint(name)
        return rollout_as_far(self.bench.arm, demand, duration=duration, brake=self.bench.brake, seed=seed)

    @claim("two-axis-settling")
    def settling(self) -> Evaluated:
        """Settle joints and tip after a step of either joint."""
        run = self.steps
        if float(run["time"][-1]) < END - 0.01:
            return [Quantity("diverged after", float(run["time"][-1]), "s")], False
        found: list[Quantity] = []
        for name, span in MOVES.items():
            times = {
                "demand": max(move(run, joint, *span, BAND).settling for joint in MOVES),
                "final": max(final_settling(run, joint, *span) for joint in MOVES),
                "tip": tip_settling(run, *span, TIP_BAND),
            }
            found += [Quantity(f"{name} step: {what}", time, "s", "about 1.5") for what, time in times.items()]
        return found, max(one.value for one in found) <= 1.5

    @claim("repeatability")
    def repeatability(self) -> Evaluated:
        """Compare where the arm comes to rest."""
        whole = len(self.rest) == REPEATS
        spread = np.degrees(np.ptp(self.rest, axis=0)) / 2 if whole else np.array([inf, inf])
        tip = self.tip - self.tip.mean(axis=0) if whole else np.array([[inf, inf]])
        reach = float(np.linalg.norm(tip, axis=1).max()) * 1000
        return [
            Quantity("large", float(spread[0]), "deg", "0.1"),
            Quantity("small", float(spread[1]), "deg", "0.1"),
            Quantity("tip", reach, "mm", "1 to 2"),
        ], spread.max() <= 0.1 and reach <= 2.0

    @claim("coupling")
    def coupling(self) -> Evaluated:
        """Compare how far each joint's step pushes the other joint."""
        large = disturbance(self.steps, "large", *MOVES["small"])
        small = disturbance(self.steps, "small", *MOVES["large"])
        ends = [abs(move(self.steps, joint, *span).steady_error) for span in MOVES.values() for joint in MOVES]
        return [
            Quantity("large disturbed", float(np.degrees(large)), "deg", "little"),
            Quantity("small disturbed", float(np.degrees(small)), "deg", "more"),
            Quantity("worst error at rest", float(np.degrees(max(ends))), "deg"),
        ], large <= 0.35 * small and max(ends) <= BAND

    @claim("overall-hysteresis")
    def overall(self) -> Evaluated:
        """Compare the curves of both joints with their brakes."""
        both = {name: percent(self.bench.curve(name, brake=self.bench.brake)) for name in MOVES}
        quantities = [Quantity(name, value, OF_TORQUE, "about 25") for name, value in both.items()]
        return quantities, all(23.0 <= value <= 27.0 for value in both.values())
