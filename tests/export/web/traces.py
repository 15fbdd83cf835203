"""Closed loops of exported machines under Node.js, and the same in Python."""

import json
from itertools import islice
from pathlib import Path

import numpy as np

from layflat.arrays import Array
from layflat.control import Demand, Sensed, step, wake
from layflat.machine import Machine, parameters
from layflat.machine.exchanged import with_tracking
from layflat.physics.adjustable import DriveFractions
from layflat.physics.sensor import noise_samples
from layflat.sim.plant import SteppedPlant
from tests.export.web.engines import run_script

SECONDS, SEED = 2.0, 3
TRACED = ("angle", "velocity", "pressure_a", "pressure_b")


def demands(machine: Machine) -> list[float]:
    """Angles that a trace asks for, rad, one a joint, that differ."""
    return [0.35 * (-1.0) ** j / (1 + 0.2 * j) for j in range(len(machine.joints))]


def node_trace(folder: Path, place: Path, machine: Machine, law: str) -> dict[str, Array]:
    """What the joints do in a run with noise, by the names of a rollout, (cycles, joints)."""
    cycles, joints = round(SECONDS / machine.cycle), len(machine.joints)
    np.array(list(islice(noise_samples(SEED, joints), cycles))).tofile(place / "noise.bin")
    inputs = {"law": law, "demand": demands(machine), "noise": str(place / "noise.bin")}
    (place / "inputs.json").write_text(json.dumps(inputs))
    script = Path(__file__).with_name("trace.mjs")
    result = run_script(script, str(folder), str(place / "inputs.json"), str(place / "out.bin"))
    assert result["joints"] == list(machine.joints)
    assert result["step"] == result["steps"] * cycles
    columns = (*TRACED, "voltage", *DriveFractions._fields)
    rows = np.fromfile(place / "out.bin").reshape(cycles, joints, len(columns))
    return {name: rows[:, :, i] for i, name in enumerate(columns)}


def check_same_bits(name: str, found: Array, expected: Array) -> None:
    """Fail where a number differs in any bit."""
    np.testing.assert_array_equal(bits_of(found), bits_of(expected), err_msg=name)


def bits_of(numbers: Array) -> Array:
    return np.ascontiguousarray(numbers).view(np.int64)


def check_trace(found: dict[str, Array], machine: Machine, law: str, interpreted: int) -> None:
    """Compare the whole trace with the plant in Python, and its first cycles with the law as Python interprets it.

    Args:
        found: trace of a run.
        machine: the machine.
        law: name of the law.
        interpreted: number of cycles of the law, which is slow in Python.
    """
    controlled = with_tracking(machine) if law == "tracking" else machine
    assert controlled is not None
    plant, settings, zeros = (
        SteppedPlant(machine, seed=SEED),
        parameters.control(controlled),
        (0.0,) * len(machine.joints),
    )
    memory = wake(settings, _sensed(SteppedPlant(machine, noise=False)))
    for k, voltages in enumerate(found["voltage"]):
        sensed = _sensed(plant)
        if k < interpreted:
            demand = Demand(tuple(demands(machine)), zeros, zeros, zeros)
            memory, command, _ = step(settings, memory, sensed, demand, machine.cycle)
            check_same_bits(f"voltage in cycle {k}", voltages, np.array(command.voltage))
        plant.drive(voltages, np.column_stack([found[name][k] for name in DriveFractions._fields]))
        plant.advance((k + 1) * machine.cycle)
        now = (plant.angles, plant.velocities, *plant.pressures.T)
        for name, values in zip(TRACED, now, strict=True):
            check_same_bits(f"{name} in cycle {k}", found[name][k], values)


def _sensed(plant: SteppedPlant) -> Sensed:
    angles, pressures = plant.sense()
    return Sensed(tuple(angles.tolist()), tuple(pressures.tolist()))
