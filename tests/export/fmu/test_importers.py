"""Importers of others: FMPy's validation and simulation, and the FMI Library beneath libcosim."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from layflat.sim.results import Run
from tests.export.fmu.importer import Fmu
from tests.export.fmu.runs import CYCLE, JOINTS, RECORDED, SEED, names_of, run_of

pytestmark = pytest.mark.compiled

PARTS = ("", "-plant", "-controller")


@pytest.fixture(scope="module")
def run() -> Run:
    return run_of(True)


def signals_of(run: Run, name: str, inputs: list[str]) -> Any:
    """Return inputs as FMPy reads them: a table with times."""
    table = np.zeros(run.sizes["time"], dtype=[("time", float), *[(one, float) for one in inputs]])
    table["time"] = np.arange(len(table)) * CYCLE
    for j, one in enumerate(inputs):
        table[one] = run[name].values[:, j]
    return table


@pytest.mark.parametrize("part", PARTS)
def test_validation_finds_nothing(fmu_folder: Path, version: str, part: str) -> None:
    validation = pytest.importorskip("fmpy.validation", reason="needs fmpy: pip install 'layflat[importers]'")
    assert validation.validate_fmu(str(fmu_folder / f"paper-arm{part}-{version}.fmu")) == []


def test_fmpy_simulates_the_run(fmu_folder: Path, version: str, run: Run) -> None:
    fmpy = pytest.importorskip("fmpy", reason="needs fmpy: pip install 'layflat[importers]'")
    outputs = [name for signal in RECORDED if signal != "voltage" for name in names_of(signal)]
    result = fmpy.simulate_fmu(
        str(fmu_folder / f"paper-arm-{version}.fmu"),
        stop_time=(run.sizes["time"] - 1) * CYCLE,
        step_size=CYCLE,
        output_interval=CYCLE,
        start_values={"seed": SEED},
        input=signals_of(run, "demand", names_of("demand")),
        output=outputs,
    )
    for signal in RECORDED[:4]:
        for j, name in enumerate(names_of(signal)):
            assert np.array_equal(result[name], run[signal].values[:, j]), name


def test_libcosim_simulates_the_run(fmus: dict[str, Fmu], fmu_folder: Path) -> None:
    """By FMI 2.0 alone, which is all that it reads."""
    parts = ("CosimExecution", "CosimManipulator", "CosimObserver", "CosimSlave")
    execution, manipulator, observers, slaves = (
        pytest.importorskip(f"libcosimpy.{part}", reason="needs libcosimpy: pip install 'layflat[importers]'")
        for part in parts
    )

    if fmus["both"].third:
        pytest.skip("libcosim reads FMI 2.0")
    run = run_of(False)
    arm = slaves.CosimLocalSlave(fmu_path=str(fmu_folder / "paper-arm-fmi2.fmu"), instance_name="arm")
    simulation = execution.CosimExecution.from_step_size(round(CYCLE * 1e9))
    number = simulation.add_local_slave(arm)
    references = fmus["both"].references
    assert simulation.boolean_initial_value(number, references["noise"], False)
    override, observer = manipulator.CosimManipulator.create_override(), observers.CosimObserver.create_last_value()
    simulation.add_manipulator(override)
    simulation.add_observer(observer)
    rows = []
    for k in range(run.sizes["time"] - 1):
        demands = [references[name] for name in names_of("demand")]
        override.slave_real_values(number, demands, run["demand"].values[k].tolist())
        assert simulation.step()
        rows.append(list(observer.last_real_values(number, [references[f"{joint}.angle"] for joint in JOINTS])))
    assert np.array_equal(rows, run["angle"].values[1:])
