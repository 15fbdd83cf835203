"""Find what the paper does not give, so that its findings come out: `python -m layflat.experiments.calibrate`.

Three stages; each writes its values into the built-in descriptions, marked as calibrated:

1. Losses: the share of the polyester strap and the effect of the rigid shell, from the hysteresis that the paper quotes
   of two rigs (21 % and 8 % at 3 bar). The 7 % and 25 % of the new and the earlier joint are then predictions.
2. Axis one: size and dither of the valve, the hose's memory, and the small joint's gains, such that with its brake it
   settles whatever it carries, that without it it oscillates only a little, and that the same controller is good on the
   earlier actuator but not beyond its limit, as the paper says. How long the joint takes without brake is not asked.
3. The arm: gains of the large joint, such that both joints settle after a step of either.

Each search begins at what stands in the descriptions and repeats itself for the same beginning; the whole takes some
ten minutes on two cores.
"""

import json
import re
import sys
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from importlib.resources import as_file
from math import degrees, radians
from typing import Any

import numpy as np
from scipy.optimize import brentq

from layflat.arrays import Array
from layflat.description.change import changed_all
from layflat.experiments.bench import Bench, bench, payload_for_inertia
from layflat.files import write_text
from layflat.machine import Machine, changed, load
from layflat.machine.loader import BUILT_IN
from layflat.sim import Scenario
from layflat.sim.metrics import BAND, settling_time
from layflat.sim.run import prepare
from layflat.sim.sweep import sweep
from layflat.tune.knobs import PER_DEG, Knob, gain_knobs, values_of
from layflat.tune.search import Strategy

AT, LAST = 0.5, 3.0  # time of the step, and how long it may take, s

BOTH = ("large", "small")

VALVE_KNOBS = [
    Knob(("valve.conductance",), 0.1, 2.0, "dm^3/(s bar)", 1e-8),
    Knob(("valve.dither.amplitude",), 0.06, 0.2),
]
MEMORY_KNOBS = [
    Knob(tuple(f"joint.{j}.losses.deflections.{i}" for j in BOTH), low, high, "deg", 1 / PER_DEG)
    for i, (low, high) in enumerate([(0.15, 3.0), (2.0, 10.0), (8.0, 25.0)])
]
WEIGHT_KNOB = Knob(tuple(f"joint.{j}.losses.weights.0" for j in BOTH), 0.1, 0.45)
"""The first element's weight; the other two share the rest."""

BRAKED = [
    *((40, 0.32), (-40, 0.32), (10, 0.32), (2, 0.32), (-100, 0.32)),
    *((40, 0.08), (10, 0.08), (40, 0.5), (40, 1.0), (40, 1.2)),
]
"""Steps (deg) and inertias (kg m2) that the new joint with its brake has to settle."""
EARLIER = [(40, 0.33), (-40, 0.33), (10, 0.33), (40, 0.36), (40, 0.2)]  # the same of the earlier actuator
BEYOND = (0.6, 0.7, 0.8)  # inertias beyond the earlier actuator's limit: about twice what it is good at, kg m2
UNBRAKED = (0.15, 0.27)  # inertias at which the new joint without brake should at least stay close, kg m2
OVERSHOOT, OFF = 0.1, 5.0  # cost of overshoot beyond 1 deg and of the error that remains, 1/deg
OSCILLATION = 0.15  # cost of a swing, 1/deg
SLOW = 1.8  # there it should take longer than this, s
SOON = 0.8  # settling faster than this is worth nothing more, s: haste costs stability
MARGIN = 2.0 / 3.0  # share of the band that joints are asked to stay in, so that noise does not decide


def written(knobs: Iterable[Knob], values: Iterable[float]) -> dict[str, Any]:
    """Return what stands in a description for the knobs' values, by path; of a first weight all three."""
    found: dict[str, Any] = {}
    for knob, value in zip(knobs, values, strict=True):
        for path in knob.paths:
            found[path] = knob.text(float(value))
            if path.endswith("weights.0"):
                first = found.pop(path)
                rest = round(0.5 * (1.0 - first), 6)
                found[path.removesuffix(".0")] = [first, rest, rest]
    return found


def with_values(machine: Machine, knobs: Iterable[Knob], values: Iterable[float]) -> Machine:
    """Return a machine with the knobs' values in place; paths of joints that it does not have are passed over."""
    others = [name for name in BOTH if name not in machine.joint]
    found = written(knobs, values)
    known = {path: text for path, text in found.items() if not path.startswith(tuple(f"joint.{j}." for j in others))}
    return changed_all(machine, known)


def put_into(name: str, values: dict[str, Any]) -> None:
    """Replace values by dotted path in the file of a built-in description, and leave all else as it stands."""
    with as_file(BUILT_IN / f"{name}.toml") as path:
        text = path.read_text(encoding="utf-8")
        for key, value in values.items():
            text = replaced(text, key, value)
        write_text(path, text)


def replaced(text: str, path: str, value: object) -> str:
    """Return a description with one value replaced, an item of a list by its index (KeyError: it is not calibrated)."""
    keys = path.split(".")
    index = int(keys.pop()) if keys[-1].isdigit() else None
    key = keys.pop()
    start = text.find(f"[{'.'.join(keys)}]\n")
    if start < 0:
        raise KeyError(path)
    end = text.find("\n[", start + 1)
    section = text[start : end if end >= 0 else len(text)]
    line = re.search(rf'^{re.escape(key)} = \{{ value = (.+?), source = "calibrated"', section, flags=re.MULTILINE)
    if line is None:
        raise KeyError(path)
    if index is not None:
        items = json.loads(line.group(1))
        items[index] = value
        value = items
    return text[: start + line.start(1)] + json.dumps(value) + text[start + line.end(1) :]


def losses() -> dict[str, float]:
    """Stage 1: return the loss shares of strap and shell."""

    def share(rig: str, path: str, hysteresis: float, most: float) -> float:
        def off(tried: float) -> float:
            return sweep(changed(load(rig), path, tried), "small", 3e5).hysteresis - hysteresis

        return float(f"{brentq(off, 0.0, most, xtol=1e-4):.3g}")

    return {
        "strap": share("rig-polyester", "joint.small.strap.loss_share", 0.21, 0.5),
        "shell": share("rig-shell-steel", "joint.small.cover.loss_factor", 0.08, 1.0),
    }


def _stepped(machine: Machine, step: float, inertia: float, brake: float) -> tuple[Array, float, bool]:
    """Errors of a joint alone that is asked for a step (deg), rad; the cycle between them, s; whether it diverged."""
    half = radians(step / 2)
    payload = payload_for_inertia(machine, machine.arm.joints[0], inertia)
    demand: list[tuple[str | float, float]] = [(0.0, -half), (AT, half)]
    prepared = prepare(machine, Scenario(demand=demand, duration=AT + LAST, payload=payload, brake=brake, seed=1))
    rows, _, diverged = prepared.run()
    return rows[:, 0, 0] - half, prepared.timing.cycle, diverged >= 0


def step_cost(machine: Machine, step: float, inertia: float, brake: float) -> float:
    """Return the settling time of a step (deg) of a joint alone (s), and what error remains (deg)."""
    error, cycle, diverged = _stepped(machine, step, inertia, brake)
    return 20.0 if diverged else verdict(error[round(AT / cycle) : round((AT + LAST) / cycle)], cycle)


def swing(machine: Machine, inertia: float) -> float:
    """Return how far a joint without brake swings about its demand in the end, deg rms."""
    return _rms_of_end(_stepped(machine, 40, inertia, 0.0)[0])


def _rms_of_end(error: Array) -> float:
    return degrees(float(np.sqrt(np.mean(np.square(error[int(0.7 * len(error)) :])))))


def verdict(error: Array, cycle: float) -> float:
    """Return seconds until errors (rad, one a cycle, s) stay small, and degrees of overshoot and of what is left."""
    time: Array = np.arange(len(error)) * np.float64(cycle)
    beyond = degrees(float(np.max(-np.sign(error[0]) * error)))
    settling = max(min(settling_time(time, error, MARGIN * BAND), LAST), SOON)
    return settling + OVERSHOOT * max(0.0, beyond - 1.0) + min(OFF * _rms_of_end(error), 5.0)


def axis_one_cost(knobs: list[Knob], on: Bench, values: Array) -> float:
    """Stage 2: return seconds and degrees over all moves."""
    tried = Bench(with_values(on.arm, knobs, values), with_values(on.earlier, knobs, values))
    new, earlier = tried.axis_one, tried.earlier_scaled
    cost = sum(step_cost(new, step, inertia, 1.0) for step, inertia in BRAKED)
    cost += 1.5 * sum(step_cost(earlier, step, inertia, 0.0) for step, inertia in EARLIER)
    cost += sum(2.0 * max(0.0, SLOW - step_cost(earlier, 40, inertia, 0.0)) for inertia in BEYOND)
    return cost + sum(OSCILLATION * swing(new, inertia) for inertia in UNBRAKED)


def arm_cost(knobs: list[Knob], arm: Machine, values: Array) -> float:
    """Stage 3: return the same over steps of both joints, and how far the small joint's step pushes the large one."""
    tried = with_values(arm, knobs, values)
    cost = 0.0
    for payload, step in ((1.5, 40.0), (1.5, -40.0), (0.0, 40.0), (2.0, 40.0), (1.5, 10.0)):
        half, second = radians(step / 2), AT + LAST
        demand: list[tuple[str | float, Any]] = [(0.0, (-half, -half)), (AT, (half, -half)), (second, (half, half))]
        prepared = prepare(tried, Scenario(demand=demand, duration=second + LAST, payload=payload, seed=2))
        rows, _, diverged = prepared.run()
        if diverged >= 0:
            return 1e3
        cycle = prepared.timing.cycle
        for joint, goal, since in ((0, half, AT), (1, -half, AT), (1, half, second), (0, half, second)):
            cost += verdict(rows[round(since / cycle) : round((since + LAST) / cycle), joint, 0] - goal, cycle)
        later = rows[round(second / cycle) :, 0, 0]
        cost += degrees(float(np.abs(later - later[0]).max()))
    return cost


def search(cost: Callable[[Array], float], knobs: Sequence[Knob], start: Array, rounds: int, seed: int) -> Array:
    """Seek least cost over the knobs' ranges, from `start` (in the knobs' units); two candidates at a time."""
    low, high = np.array([k.low for k in knobs]), np.array([k.high for k in knobs])
    strategy = Strategy((start - low) / (high - low), 24, seed)
    inner = strategy.inner
    with ThreadPoolExecutor(2) as pool:
        while not inner.stop() and inner.countiter < rounds:
            strategy.tell(pool.map(lambda share: cost(low + share * (high - low)), strategy.ask()))
            sys.stderr.write(f"\rround {inner.countiter} of {rounds}: cost {inner.result.fbest:.3f}  ")
    sys.stderr.write("\n")
    # No worse than before, however short the search.
    found = np.asarray(low + inner.result.xbest * (high - low))
    return found if inner.result.fbest < cost(start) else start


def main(rounds: int = 150) -> None:
    """All stages, in order."""
    shares = losses()
    put_into("earlier-actuator", {"joint.small.strap.loss_share": shares["strap"]})
    put_into("rig-shell-steel", {"joint.small.cover.loss_factor": shares["shell"]})
    put_into("paper-arm", {f"joint.{j}.cover.loss_factor": shares["shell"] for j in BOTH})

    on = bench()
    knobs = [*gain_knobs("small"), *VALVE_KNOBS, *MEMORY_KNOBS, WEIGHT_KNOB]
    found = search(partial(axis_one_cost, knobs, on), knobs, values_of(on.arm, knobs), rounds, seed=1)
    texts = written(knobs, found)
    put_into("paper-small-joint", {path: text for path, text in texts.items() if ".gains." in path})
    # The arm's small joint is given the same gains; tuned for the arm they may become others.
    put_into("paper-arm", texts)

    arm = load("paper-arm")
    knobs = gain_knobs("large")
    found = search(partial(arm_cost, knobs, arm), knobs, values_of(arm, knobs), rounds // 2, seed=2)
    put_into("paper-arm", written(knobs, found))


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:]))
