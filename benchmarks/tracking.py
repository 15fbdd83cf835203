"""What the tracking controller does: how soon it brings the tip to rest, and how closely it follows a belt.

    python -m benchmarks.tracking [RUNS]

prints the figures of docs/control.md. Runs are steps of 40 degrees of one and of both joints in sixteen postures, as
described and on plants that differ from what the controller believes. The belt goes back and forth.
"""

import sys
from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import ArrayLike

from layflat.arrays import Array
from layflat.description.change import changed_all, value_at
from layflat.machine import Machine, changed, load
from layflat.motion.kinematics import tip_position
from layflat.motion.reach import Reach
from layflat.physics.friction.stribeck import StribeckPart
from layflat.sim import Scenario, rollout
from layflat.sim.ensemble import ensemble

POSTURES, STEP, EDGE = 16, 40.0, 55.0  # deg
WAYS = ((1, 1), (1, -1), (1, 0), (0, 1))
PAUSE = 1.5  # between moves, s


def moves(count: int) -> list[Scenario]:
    """So many steps after each other, from sixteen postures."""
    draw, found = np.random.default_rng(1), []
    for posture in range(POSTURES):
        at = draw.uniform(-EDGE, EDGE, 2)
        demand = []
        for move in range(count):
            step = STEP * draw.choice([-1, 1]) * np.array(WAYS[(posture + move) % len(WAYS)])
            if move == 0:
                at = np.clip(at, np.maximum(-EDGE, -EDGE - step), np.minimum(EDGE, EDGE - step))
                demand.append((0.0, np.radians(at).tolist()))
            at = at + np.where(np.abs(at + step) > EDGE + 1e-9, -step, step)
            demand.append((0.5 + PAUSE * move, np.radians(at).tolist()))
        found.append(Scenario(demand=demand, duration=0.5 + PAUSE * count))
    return found


def others(arm: Machine, runs: int) -> dict[str, ArrayLike]:
    """Plants that differ from what their controller believes."""
    draw, found = np.random.default_rng(5).uniform, dict[str, ArrayLike]()
    for name in arm.joints:
        for path, low, high in (("brake.torque", 0.7, 1.3), ("hose.loss_share", 0.7, 1.3)):
            key = f"joint.{name}.{path}"
            found[key] = value_at(arm, key) * draw(low, high, runs)
        found[f"joint.{name}.friction.static_ratio"] = draw(1.0, 1.5, runs)
    found["valve.conductance"] = value_at(arm, "valve.conductance") * draw(0.8, 1.2, runs)
    found["scenario.supply"] = arm.supply.pressure_gauge * draw(0.8, 1.2, runs)
    found["valve.delay"] = draw(0.0, arm.cycle, runs)
    return found


def rough() -> Machine:
    """The arm with friction that may be greater at rest."""
    arm = load("paper-arm-fast")
    for name in arm.joints:
        sticks = StribeckPart(kind="stribeck", static_ratio=1.0, velocity="2 deg/s")
        arm = changed(arm, f"joint.{name}.friction", sticks)
    return arm


def rows(runs: int) -> Iterator[tuple[str, Array]]:
    """What is run, and settling times of the tip (runs,), s; infinite for what did not settle."""
    arm, plant = load("paper-arm-tracking"), rough()
    unsure = changed_all(arm, {"arm.payload": 1.0, "controller.payload_spread": 0.6})
    each: dict[str, ArrayLike] = {"scenario": np.arange(runs) % POSTURES, "seed": np.arange(runs)}
    loaded = each | {"scenario.payload": np.random.default_rng(12).uniform(0.0, 2.0, runs)}
    single, several, differing = moves(1), moves(5), others(plant, runs)

    def times(machine: Machine, scenarios: list[Scenario], vary: Mapping[str, ArrayLike], driver: Machine) -> Array:
        return ensemble(machine, scenarios, vary, controller=driver)["tip_settling"].values

    late = changed_all(arm, {"valve.delay": arm.cycle})
    papers = load("paper-arm-fast-tuned")
    yield "the paper's controller, tuned", times(papers, single, each, papers)
    yield "as described", times(arm, single, each, arm)
    yield "with a cycle of delay, known", times(late, single, each, late)
    known = times(arm, several, loaded, unsure)
    yield "payload unknown, first move", known[:, 0]
    yield "the four moves after it", known[:, 1:]
    yield "other plants", times(plant, single, each | differing, arm)
    yield "other plants, payload unknown", times(plant, single, loaded | differing, unsure)


def belt(speed: float, acceleration: float = 3.0, seconds: float = 4.0, cycle: float = 5e-3) -> Array:
    """Where something on a belt is at every cycle, (cycles, 2), m: it goes to and fro along a line."""
    low, high, x = 0.02, 0.38, 0.55
    places, y, v, way = [], low, 0.0, 1.0
    for _ in range(round(seconds / cycle)):
        stop = y + v * abs(v) / (2.0 * acceleration)
        way = -1.0 if stop >= high else 1.0 if stop <= low else way
        v = float(np.clip(way * speed, v - acceleration * cycle, v + acceleration * cycle))
        y += v * cycle
        places.append((x, y))
    return np.array(places)


def apart(machine: Machine, places: Array, *, seed: int) -> Array:
    """Distance of the tip from places that it follows, from a second after it set out on, m."""
    reach = Reach(machine)
    angles = [reach.postures(x, y)[0].angles for x, y in places.tolist()]
    start = {"large": "0 deg", "small": "-30 deg"}
    run = rollout(machine, np.array(angles), duration=len(places) * machine.cycle, start=start, seed=seed)
    off: Array = np.linalg.norm(tip_position(machine, run.angle.values[:-1]) - places, axis=1)
    return off[round(1.0 / machine.cycle) :]


if __name__ == "__main__":
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 4096
    print(f"{'':32} runs  median    95 %   worst  not settled")
    for what, found in rows(count):
        settled = found[np.isfinite(found)]
        tail = np.quantile(found, 0.95, method="higher")
        print(
            f"{what:32} {found.size:5d} {np.median(found):7.3f} {tail:7.3f} {settled.max():7.3f} "
            f"{found.size - settled.size:7d}"
        )
    for name in ("paper-arm-fast-tuned", "paper-arm-tracking"):
        for speed in (0.3, 0.5):
            off = 1e3 * np.concatenate([apart(load(name), belt(speed), seed=seed) for seed in range(4)])
            rms = np.sqrt(np.mean(off * off))
            print(f"{name} behind a belt with {speed} m/s: {rms:.2f} mm rms, {off.max():.2f} mm at most")
