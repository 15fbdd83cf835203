"""Machines through time: rollouts, ensembles, the stepped plant, the arm in MuJoCo, slow sweeps."""

from __future__ import annotations

from math import sin
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Arrays = dict[str, Any]
"""Results by name; anything that becomes an array of float64."""

MOVING = (
    "earlier-actuator", "paper-arm", "paper-arm-fast", "paper-arm-fast-tuned", "paper-arm-switching",
    "paper-large-joint", "paper-small-joint", "paper-small-joint-switching",
)  # fmt: skip
TURNED = (
    "paper-arm", "rig-kevlar", "rig-kevlar-plate", "rig-polyester", "rig-polyester-plate", "rig-polyester-polythene",
    "rig-shell-steel", "rig-single-thickness",
)  # fmt: skip

SIGNALS = {
    name: name
    for name in (
        "angle", "velocity", "pressure_a", "pressure_b", "temperature_a", "temperature_b", "valve_opening", "voltage",
        "measured_angle", "measured_pressure", "averaged_angle", "averaged_velocity", "averaged_pressure", "ripple",
        "phase", "short_term", "long_term", "learning", "hose_torque", "gas_work", "load_work", "hose_work",
        "hose_stored", "brake_heat", "damping_heat", "air_taken", "tip",
    )
}  # fmt: skip
"""Our name of a rollout's signal: its name in the code."""

METRICS = {
    name: name
    for name in (
        "settling", "overshoot", "steady_error", "ripple", "tip_settling", "tip_error", "air_used", "hysteresis",
        "peak_acceleration", "diverged",
    )
}  # fmt: skip
TRACES = {
    name: name for name in ("angle", "velocity", "pressure_a", "pressure_b", "valve_opening", "voltage")
}  # fmt: skip


def each(machine: Any, first: float, second: float) -> tuple[float, ...]:
    """One value a joint: `first` of the first, `second` of others."""
    return (first, second)[: len(machine.joints)]


def rollouts(name: str) -> Arrays:
    """A machine in closed loop, with gravity, with given openings and with given voltages."""
    from layflat import changed, load, rollout  # noqa: PLC0415

    machine = load(name)
    moves = [(0.0, each(machine, 0.0, 0.0)), (0.1, each(machine, 0.3, -0.25)), (0.8, each(machine, -0.2, 0.15))]
    eventful: dict[str, Any] = {
        "demand": moves, "duration": "1.5 s", "seed": 3, "start": 0.05,
        "payload": [("0 s", "1 kg"), ("0.4 s", "2.1 kg")], "supply": [("0.3 s", "3.5 bar"), ("1 s", "4.2 bar")],
        "load": [("0.6 s", "1.5 N m")], "drift": [("0.5 s", "0.1 V")], "brake": [("0.9 s", 0.6)],
    }  # fmt: skip
    heavy = changed(machine, "arm.gravity", 9.81)
    opened: dict[str, Any] = {
        "opening": [("0 s", each(machine, 0.1, -0.1)), ("0.3 s", each(machine, -0.2, 0.05))],
        "brake": 0.3,
    }
    runs = {
        "closed loop": rollout(machine, **eventful),
        "quiet": rollout(machine, demand=moves, duration="1 s", noise=False, records=5, step="0.5 ms"),
        "gravity": rollout(heavy, demand=moves, duration="1 s", seed=8),
        "open loop": rollout(machine, **opened, duration="1 s", start=0.1, pressures=("2 bar", "2.5 bar")),
        "voltages": rollout(machine, voltage=lambda t: 5.0 + 2.0 * sin(9.0 * t), duration="0.6 s"),
    }
    return {f"{case}: {ours}": run[name] for case, run in runs.items() for ours, name in SIGNALS.items()}


def ensembles(name: str) -> Arrays:
    """Runs that differ in machine, scenario, start and noise: metrics and traces."""
    from layflat import Scenario, ensemble, load  # noqa: PLC0415

    machine, count = load(name), 11
    last, share = tuple(machine.joints)[-1], np.linspace(0.0, 1.0, count)
    steps = [(0.0, each(machine, 0.0, 0.0)), (0.1, each(machine, 0.3, -0.25)), (0.5, each(machine, -0.1, 0.1))]
    scenarios = [
        Scenario(demand=steps, duration="0.9 s"),
        Scenario(demand=steps[:2], duration="0.9 s", load=[("0.4 s", "1 N m")], noise=False),
        Scenario(opening=0.1, brake=0.5, duration="0.9 s"),
    ]
    vary = {
        "scenario": np.arange(count) % 3, "seed": np.arange(count), "scenario.payload": 2.0 * share,
        "supply.pressure_gauge": 3e5 + 2e5 * share, f"joint.{last}.brake.torque": 1.0 + 3.0 * share,
        f"joint.{last}.hose.dead_volume": 2e-5 + 3e-5 * share, f"start.angle.{last}": 0.1 * share,
        f"scenario.drift.{last}": 0.05 * share,
    }  # fmt: skip
    found = ensemble(machine, scenarios, vary, traces=list(TRACES.values()))
    return {ours: found[name] for ours, name in (METRICS | TRACES).items()}


def stepped() -> Arrays:
    """The stepped plant with voltages, and what can break in it."""
    from layflat import load  # noqa: PLC0415
    from layflat.sim.plant import SteppedPlant  # noqa: PLC0415

    return {
        f"{name}: {key}": value
        for name in ("paper-arm", "paper-small-joint-switching")
        for key, value in driven(SteppedPlant(load(name), start=0.1, seed=4)).items()
    }


def in_mujoco() -> Arrays:
    """The paper's arm in MuJoCo, likewise."""
    from layflat import load  # noqa: PLC0415
    from layflat.bridge import MujocoPlant  # noqa: PLC0415

    return driven(MujocoPlant(load("paper-arm"), seed=4))


def driven(plant: Any) -> Arrays:
    """A plant that is driven for 0.8 s and fails in between: what it does and what its sensors say, by cycle."""
    rows, last = [], len(plant.joints) - 1
    events = {
        20: lambda: plant.kink(0, 0.4), 40: lambda: plant.kink(0, 1.0), 50: lambda: plant.burst(last, 1),
        60: lambda: plant.burst(last, None), 70: lambda: plant.seize(0, 0.3), 85: lambda: plant.seize(0, None),
        95: lambda: plant.grip(last, 20.0), 110: lambda: plant.grip(last, 0.0),
    }  # fmt: skip
    for k in range(160):
        events.get(k, lambda: None)()
        plant.payload = 1.5 if k < 100 else 0.8
        plant.supply = 5e5 if k < 120 else 4e5
        plant.load[last] = 1.0 if k > 130 else 0.0
        plant.drive(np.array([5.0 + 1.5 * sin(0.13 * k), 5.0 - 2.0 * sin(0.09 * k)])[: last + 1])
        plant.advance(0.005 * (k + 1))
        angles, pressures = plant.sense()
        rows.append(np.stack([plant.angles, plant.velocities, *plant.pressures.T, angles, pressures]))
    names = ("angle", "velocity", "pressure_a", "pressure_b", "measured_angle", "measured_pressure")
    return dict(zip(names, np.array(rows).transpose(1, 0, 2), strict=True))


def sweeps() -> Arrays:
    """Torque over angle of the open-loop rigs."""
    from layflat import load  # noqa: PLC0415
    from layflat.sim.sweep import sweep  # noqa: PLC0415

    found: Arrays = {}
    for name in TURNED:
        machine = load(name)
        for joint in machine.joints:
            loop = sweep(machine, joint, 3e5, centre=0.05, brake=0.5, points=201)
            found |= {f"{name} {joint}: torque": loop.torque, f"{name} {joint}: lossless": loop.lossless}
    return found
