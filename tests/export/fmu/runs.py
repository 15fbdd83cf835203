"""Simulation runs that FMUs have to repeat bit for bit."""

from pathlib import Path
from typing import Any

import numpy as np

import layflat as lf
from layflat.arrays import Array
from layflat.export.fmu import libraries, writer
from layflat.export.fmu.variables import quoted
from layflat.machine import Machine
from layflat.sim.kernel import JointRecord
from layflat.sim.results import Run
from tests.export.fmu.importer import OK, Fmu, Instance

MACHINE, CYCLE, JOINTS, SEED = "paper-arm", 0.005, ("large", "small"), 7
DEMAND: Any = [("0.05 s", {"large": "20 deg", "small": "-10 deg"}), ("0.4 s", "5 deg")]

REPORT = ("averaged_angle", "averaged_velocity", "averaged_pressure", "ripple", "phase", "short_term", "long_term")
HELD = ("voltage", *REPORT)
"""Signals that hold from one control cycle to the next: in an FMU they are those of the cycle that ends."""


def run_of(noise: bool, seed: int = SEED) -> Run:
    return lf.rollout(MACHINE, DEMAND, noise=noise, seed=seed, duration="0.8 s")


def names_of(signal: str) -> list[str]:
    return [f"{joint}.{signal}" for joint in JOINTS]


def rows_of(run: Run, signals: tuple[str, ...]) -> Array:
    """Return the rows that an FMU has to show at all instants but the start, (instants, signals, joints)."""
    columns = [run[name].values[:-1] if name in HELD else run[name].values[1:] for name in signals]
    return np.stack(columns, axis=1)


def follow(instance: Instance, run: Run, inputs: tuple[str, ...], outputs: tuple[str, ...], first: int = 0) -> Array:
    """Step an instance from a control cycle to the end with a run's signals as inputs; return its rows."""
    rows = []
    for k in range(first, run.sizes["time"] - 1):
        for name in inputs:
            assert instance.set(dict(zip(names_of(name), run[name].values[k].tolist(), strict=True))) == OK
        assert instance.step(k * CYCLE, CYCLE) == OK, instance.messages
        rows.append([instance.get(names_of(name)) for name in outputs])
    return np.array(rows)


RECORDED = JointRecord._fields


def check_fmus(machine: Machine, folder: Path) -> None:
    """Fail where an FMU of plant and control law, by FMI 2.0 or 3.0, differs from a run of 2 s with noise."""
    system = libraries.host_system()
    assert system is not None
    run = lf.rollout(machine, [("0.1 s", "5 deg")], seed=3, duration="2 s")
    files = list(writer.write_fmus(machine, folder / "fmus", target="fmu", precision="double"))
    for end in writer.FMI_VERSIONS.values():
        (path,) = (one for one in files if one.name == f"{machine.name}-{end}.fmu")
        check_run(Instance(Fmu(path, folder / end, (system.folder_2, system.folder))), machine, run)


def check_run(instance: Instance, machine: Machine, run: Run) -> None:
    """Fail where an instance of plant and control law differs from a run of seed 3."""
    instance.set_noise(3, True)
    instance.begin()
    signals, joints = [one for one in RECORDED if one != "voltage"], list(machine.joints)
    outputs = [f"{quoted(joint)}.{one}" for one in signals for joint in joints]
    for k in range(run.sizes["time"] - 1):
        demand = run["demand"].values[k].tolist()
        assert instance.set({f"{quoted(joint)}.demand": q for joint, q in zip(joints, demand, strict=True)}) == OK
        assert instance.step(k * machine.cycle, machine.cycle) == OK, instance.messages
        rows = np.reshape(instance.get(outputs), (len(signals), len(joints)))
        assert np.array_equal(rows, [run[one].values[k + 1] for one in signals])
