"""The long-term integral: what it learns, and its three rules (section 3)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import pi, radians
from typing import TYPE_CHECKING

import numpy as np

from layflat.experiments.bench import Bench
from layflat.experiments.claim import Claim
from layflat.machine import parameters
from layflat.sim import Scenario, rollout

if TYPE_CHECKING:
    import xarray

DRIFT = 0.05
"""Drift of the valve's neutral, share of full opening."""
DURATION = 60.0
OFFSET_LOAD = 0.4
"""Offset load of rule 3, share of the maximum torque at supply pressure."""


@dataclass(frozen=True)
class Drift:
    """Runs with a drifted neutral: at rest, with the air off, in motion, and under an offset load."""

    volts: float
    rest: xarray.Dataset
    no_air: xarray.Dataset
    motion: xarray.Dataset
    offset: xarray.Dataset


def perform(bench: Bench) -> Drift:
    """Let the neutral drift by 5 % and watch the long-term integral of axis one."""
    machine = bench.axis_one
    valve, _, _ = parameters.drive_parts(machine)
    volts = DRIFT * valve.volts_to_full
    load = OFFSET_LOAD * parameters.torque_constant(machine.joint["small"]) * machine.supply.pressure_gauge
    ambient = machine.supply.ambient_pressure

    def sway(t: float) -> float:
        return radians(40.0) * float(np.sin(2 * pi * 0.5 * t))

    case = Scenario(drift=volts, brake=bench.brake, seed=4, duration=20.0)
    return Drift(
        volts,
        rollout(machine, scenario=replace(case, duration=DURATION)),
        rollout(machine, scenario=replace(case, supply=0.0, pressures=(ambient, ambient))),
        rollout(machine, scenario=replace(case, demand=sway)),
        rollout(machine, scenario=replace(case, load=[(0.0, 0.0), (1.0, load)])),
    )


def claims(found: Drift) -> list[Claim]:
    """What the paper says of the long-term integral."""

    def learnt(run: xarray.Dataset, since: float = 0.0) -> float:
        values = run["long_term"].sel(joint="small", time=slice(since, None)).to_numpy()
        return float(values[-1] - values[0])

    taken = 100.0 * learnt(found.rest) / found.volts
    still = {
        "air off": abs(learnt(found.no_air)),
        "in motion": abs(learnt(found.motion, since=1.0)),
        "offset load": abs(learnt(found.offset, since=2.5)),
    }
    return [
        Claim(
            "long-term-integral",
            "3",
            "the long-term integral builds only with air, at rest, without offset load",
            {"drift taken over (%)": taken, **{f"{name} (V)": value for name, value in still.items()}},
            "as named",
            90.0 <= taken <= 110.0 and all(value == 0.0 for value in still.values()),
            "at least 90 % of a 5 % drift within 60 s; no change with the air off, in motion or under an offset load",
        )
    ]
