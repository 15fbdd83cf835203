"""Open-loop characteristics: torque-angle loops of the rigs and joints (Figs 2 to 5 and 10 to 12)."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

from layflat.experiments.bench import RIGS, Bench
from layflat.experiments.claim import Claim
from layflat.sim.sweep import Loop, sweep

BAR = 1e5
RIG_PRESSURE = 3 * BAR
PRESSURES = (1 * BAR, 2 * BAR, 3 * BAR, 4 * BAR)
SMALL_SWEEP = 0.05
"""Share of the stroke over which loops of small motions are compared."""


@dataclass(frozen=True)
class OpenLoop:
    """Loops of the rigs by name and pressure (Pa), of axis one, of the earlier actuator, and of small sweeps."""

    rigs: dict[str, dict[float, Loop]]
    unbraked: Loop
    braked: Loop
    earlier: Loop
    large_braked: Loop
    small_unbraked: Loop
    small_braked: Loop
    small_earlier: Loop


def perform(bench: Bench) -> OpenLoop:
    """Sweep every rig at 1 to 4 bar and the joints at supply pressure."""
    rigs = {
        name: {pressure: sweep(rig, "small", pressure) for pressure in PRESSURES} for name, rig in bench.rigs.items()
    }
    at = bench.arm.supply.pressure_gauge
    short = SMALL_SWEEP * bench.arm.joint["small"].stops.working_stroke
    return OpenLoop(
        rigs,
        sweep(bench.arm, "small", at, brake=0.0),
        sweep(bench.arm, "small", at, brake=bench.brake),
        sweep(bench.earlier, "small", at),
        sweep(bench.arm, "large", at, brake=bench.brake),
        sweep(bench.arm, "small", at, brake=0.0, stroke=short),
        sweep(bench.arm, "small", at, brake=bench.brake, stroke=short),
        sweep(bench.earlier, "small", at, stroke=short),
    )


def claims(loops: OpenLoop) -> list[Claim]:
    """What the paper says of its loops."""
    return [_hysteresis(loops), _character(loops), _variants(loops), _overall(loops)]


def _percent(loop: Loop) -> float:
    return 100.0 * loop.hysteresis


def _hysteresis(loops: OpenLoop) -> Claim:
    before, now, braked = _percent(loops.earlier), _percent(loops.unbraked), _percent(loops.braked)
    return Claim(
        "open-loop-hysteresis",
        "4.1, Figs 10-12",
        "25 % for the earlier actuator, 7 % for the new joint, 25 % with its brake",
        {"earlier": before, "new": now, "new with brake": braked},
        "% of maximum torque",
        23.0 <= before <= 27.0 and 6.0 <= now <= 8.0 and 23.0 <= braked <= 27.0,
        "25 +- 2, 7 +- 1, 23 to 27",
    )


def _character(loops: OpenLoop) -> Claim:
    full = loops.braked.height - loops.unbraked.height
    small = loops.small_braked.height - loops.small_unbraked.height
    # A brake that adds nothing keeps nothing.
    brake = 100.0 * small / full if full > 1e-6 * loops.unbraked.height else 0.0
    earlier = 100.0 * loops.small_earlier.height / loops.earlier.height
    return Claim(
        "loop-character",
        "4.1",
        "Coulomb friction opposes small motions fully, the earlier actuator's hysteresis less",
        {"brake": brake, "earlier": earlier},
        "% of loop height kept over 5 % of the stroke",
        brake >= 95.0 and earlier <= 60.0,
        "brake at least 95, earlier actuator at most 60",
    )


def _variants(loops: OpenLoop) -> Claim:
    at = {name: _percent(loops.rigs[name][RIG_PRESSURE]) for name in RIGS}
    ordered = ("rig-polyester", "rig-polyester-plate", "rig-kevlar-plate", "rig-shell-steel")
    falling = all(
        all(_percent(rig[low]) > _percent(rig[high]) for low, high in pairwise(PRESSURES))
        for rig in loops.rigs.values()
    )
    plain = at["rig-polyester"]
    return Claim(
        "rig-variants",
        "2.1, Figs 2-5",
        "polyester 21 %, rigid shell with steel 8 % at 3 bar; plate and Kevlar between; falls with pressure",
        {name.removeprefix("rig-"): value for name, value in at.items()},
        "% of maximum torque",
        19.0 <= plain <= 23.0
        and 7.0 <= at["rig-shell-steel"] <= 9.0
        and all(at[a] > at[b] for a, b in pairwise(ordered))
        and abs(at["rig-single-thickness"] - plain) <= 1.0
        and abs(at["rig-polyester-polythene"] - plain) <= 1.0
        and falling,
        "21 +- 2, 8 +- 1; polyester > + plate > Kevlar + plate > shell; others within 1; falling from 1 to 4 bar",
    )


def _overall(loops: OpenLoop) -> Claim:
    both = {"large": _percent(loops.large_braked), "small": _percent(loops.braked)}
    return Claim(
        "overall-hysteresis",
        "4.2",
        "brakes at +-8 % of maximum torque make about 25 % over all, on both joints",
        both,
        "% of maximum torque",
        all(23.0 <= value <= 27.0 for value in both.values()),
        "23 to 27 on both",
    )
