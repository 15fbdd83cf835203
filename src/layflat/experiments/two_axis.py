"""The two-axis arm: steps of each axis in turn, coupling, repeatability (Fig. 14, section 4.2)."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, radians
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from layflat.errors import DivergedError
from layflat.experiments.bench import Bench
from layflat.experiments.claim import Claim
from layflat.sim import rollout
from layflat.sim.kinematics import tip_position
from layflat.sim.metrics import BAND, move, settling_time, tip_settling

if TYPE_CHECKING:
    import xarray

STEP = 40.0
"""deg"""
FIRST, SECOND, END = 0.5, 4.0, 7.5
"""Times of the large joint's step, of the small joint's, and of the end, s."""
REPEATS = 20
REPEAT_TIME = 2.5
FINAL_BAND = radians(0.1)
TIP_BAND = 2e-3


Steps = list[tuple[str | float, tuple[float, float]]]


@dataclass(frozen=True)
class TwoAxis:
    """The steps; and the rest positions (rad, approaches x joints) with the tip's (m), from alternate sides."""

    steps: xarray.Dataset
    rest: NDArray[np.float64]
    tip: NDArray[np.float64]


def perform(bench: Bench) -> TwoAxis:
    """Step each axis in turn, then approach one place from both sides."""
    half = radians(STEP / 2)
    demand: Steps = [(0.0, (-half, -half)), (FIRST, (half, -half)), (SECOND, (half, half))]
    steps = _run(bench, demand, END, seed=2)
    rest = _approaches(bench)
    return TwoAxis(steps, rest, tip_position(bench.arm, rest))


def _run(bench: Bench, demand: Steps, duration: float, seed: int) -> xarray.Dataset:
    try:
        return rollout(bench.arm, demand, duration=duration, brake=bench.brake, seed=seed)
    except DivergedError as error:
        return error.run  # type: ignore[return-value]


def _approaches(bench: Bench) -> NDArray[np.float64]:
    """Mean angles over the last 0.2 s of each approach to mid-stroke, from -20 and +20 deg by turns."""
    side = radians(STEP / 2)
    demand: Steps = []
    for i in range(REPEATS):
        away = side if i % 2 else -side
        demand += [(2 * i * REPEAT_TIME, (away, away)), ((2 * i + 1) * REPEAT_TIME, (0.0, 0.0))]
    run = _run(bench, demand, 2 * REPEATS * REPEAT_TIME, seed=3)
    ends = 2 * REPEAT_TIME * (1 + np.arange(REPEATS))
    return np.array(
        [
            run["angle"].sel(time=slice(end - 0.2, end)).mean("time").to_numpy()
            for end in ends
            if end <= run.time[-1] + 1.0
        ]
    )


def claims(arm: TwoAxis) -> list[Claim]:
    """What the paper says of the arm."""
    return [_settling(arm), _repeatability(arm), _coupling(arm)]


MOVES = {"large": (FIRST, SECOND - 0.005), "small": (SECOND, END)}
"""From when to when each joint's move lasts, s."""


def final_settling(run: xarray.Dataset, joint: str, since: float, until: float) -> float:
    """Time until a joint stays within 0.1 deg of its own final value, s."""
    part = run.sel(joint=joint, time=slice(since, until))
    angle = part["angle"].to_numpy()
    final = float(angle[int(0.9 * len(angle)) :].mean())
    return settling_time(part["time"].to_numpy(), angle - final, FINAL_BAND)


def _settling(arm: TwoAxis) -> Claim:
    found: dict[str, float] = {}
    if float(arm.steps["time"][-1]) < END - 0.01:
        found = {"diverged after": float(arm.steps["time"][-1])}
        worst = inf
    else:
        for name, (since, until) in MOVES.items():
            found[f"{name} step: demand"] = max(
                move(arm.steps, joint, since, until, BAND).settling for joint in ("large", "small")
            )
            found[f"{name} step: final"] = max(
                final_settling(arm.steps, joint, since, until) for joint in ("large", "small")
            )
            found[f"{name} step: tip"] = tip_settling(arm.steps, since, until, TIP_BAND)
        worst = max(found.values())
    return Claim(
        "two-axis-settling",
        "4.2, Fig. 14",
        "reached within about 1.5 s with 1.5 kg, to +-0.1 deg on each joint and +-2 mm at the tip",
        found,
        "s",
        worst <= 1.5,
        "both joints within 0.3 deg of demand and 0.1 deg of their final value, tip within 2 mm, in 1.5 s",
    )


def _repeatability(arm: TwoAxis) -> Claim:
    whole = len(arm.rest) == REPEATS
    spread = np.degrees(np.ptp(arm.rest, axis=0)) / 2 if whole else np.array([inf, inf])
    tip = arm.tip - arm.tip.mean(axis=0) if whole else np.array([[inf, inf]])
    reach = float(np.linalg.norm(tip, axis=1).max()) * 1000
    return Claim(
        "repeatability",
        "4.2",
        "+-0.1 deg on each joint, +-1 to 2 mm at the tip",
        {"large (deg)": float(spread[0]), "small (deg)": float(spread[1]), "tip (mm)": reach},
        "half the spread of 20 approaches",
        bool(spread.max() <= 0.1 and reach <= 2.0),
        "within 0.1 deg and 2 mm",
    )


def disturbance(run: xarray.Dataset, joint: str, since: float, until: float) -> float:
    """How far a joint is pushed from where it stood when the other one began to move, rad."""
    angle = run["angle"].sel(joint=joint, time=slice(since, until)).to_numpy()
    return float(np.abs(angle - angle[0]).max())


def _coupling(arm: TwoAxis) -> Claim:
    large = disturbance(arm.steps, "large", *MOVES["small"])
    small = disturbance(arm.steps, "small", *MOVES["large"])
    ends = [abs(move(arm.steps, joint, *MOVES[name]).steady_error) for name in MOVES for joint in ("large", "small")]
    return Claim(
        "coupling",
        "4.2, Fig. 14",
        "the small joint's motion has little effect on the large one, not so the reverse; accuracy is not affected",
        {
            "large disturbed": float(np.degrees(large)),
            "small disturbed": float(np.degrees(small)),
            "worst error at rest": float(np.degrees(max(ends))),
        },
        "deg",
        large <= 0.35 * small and max(ends) <= BAND,
        "the large joint's peak at most 0.35 of the small one's; both end within 0.3 deg",
    )
