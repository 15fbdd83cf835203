import numpy as np
import pytest
import xarray

from layflat.design import Table1, design_joint, table1
from layflat.experiments import load_bench
from layflat.experiments.statics import StaticsExperiment, air_stiffness, cam_torque, printed_table, wrong_cells
from layflat.machine import changed, load, parameters


def test_every_cell_of_table_1_rounds_to_the_printed_digits() -> None:
    assert wrong_cells(table1()) == []
    assert sum(map(len, printed_table().values())) == 176


def test_a_wrong_cell_is_found() -> None:
    table = table1()
    bent = table.columns["T_Nm"].copy()
    bent[3] += 1e-4
    assert wrong_cells(Table1(table.columns | {"T_Nm": bent})) == ["T_Nm, row 4"]


def test_the_printed_table_is_whole() -> None:
    assert all(len(column) == 11 for column in printed_table().values())
    assert np.isfinite([float(cell) for column in printed_table().values() for cell in column]).all()


def squeezed(slope: float) -> xarray.Dataset:
    """A run of the large joint (two periods of 20 s) whose air turns it back by `slope`, N m/rad."""
    arm = load("paper-arm")
    time = np.arange(0.0, 40.0, 0.1)
    angle = 0.01 * np.sin(2 * np.pi * time / 20.0)[:, None]
    difference = -slope * angle / parameters.torque_constant(arm.joint["large"])
    values = {"angle": angle, "pressure_a": 4e5 + 0.5 * difference, "pressure_b": 4e5 - 0.5 * difference}
    data = {name: (("time", "joint"), value) for name, value in values.items()}
    return xarray.Dataset(data, {"time": time, "joint": ["large"]}, {"machine": arm.model_dump_json()})


@pytest.mark.parametrize("slope", [30.0, 107.0])
def test_stiffness_is_the_slope_of_the_airs_torque(slope: float) -> None:
    assert air_stiffness(squeezed(slope)) == pytest.approx(slope)


def test_stiffness_looks_at_the_last_period_alone() -> None:
    run = squeezed(50.0)
    run["pressure_a"][:150] += 1e4
    assert air_stiffness(run) == pytest.approx(50.0)


def test_a_cam_turns_a_falling_force_into_a_constant_torque() -> None:
    torque = cam_torque(design_joint(load("paper-arm"), "large"))
    assert np.ptp(torque) / np.mean(torque) < 1e-6
    assert np.mean(torque) == pytest.approx(82.1, rel=0.01)


def test_torque_that_is_needed_for_a_mass_asks_for_both_joints() -> None:
    found = StaticsExperiment.torque_per_mass.evaluate_claim(StaticsExperiment(load_bench("paper-large-joint")))
    assert found.reason == "not applicable: paper-large-joint: has no joint 'small'"
    found = StaticsExperiment.torque_per_mass.evaluate_claim(StaticsExperiment(load_bench()))
    large, small, mean = (one.value for one in found.quantities)
    assert mean == pytest.approx((large + small) / 2)
    assert found.agrees


def test_torque_for_a_mass_and_pressure_counts_the_supply_of_the_machine() -> None:
    halved = changed(load("paper-arm"), "supply.pressure_gauge", 2e5)
    evaluate = StaticsExperiment.torque_per_mass.evaluate_claim
    before, after = (evaluate(StaticsExperiment(load_bench(arm))) for arm in ("paper-arm", halved))
    assert [one.value for one in after.quantities] == pytest.approx([one.value for one in before.quantities], rel=0.02)
