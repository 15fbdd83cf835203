"""What varies together, relative to the machine, or as a group."""

from pathlib import Path

import numpy as np
import pytest

from layflat.description.change import value_at
from layflat.errors import InputError
from layflat.study import read_study, run_study, study_table
from layflat.study.sampling import draw_samples
from layflat.study.varied import machine_values
from tests.study.studies import SMALL, written

LINKED = """
[vary."joint.small.gains.near.error"]
also = ["joint.small.gains.close.error", "joint.small.gains.integral"]
relative = true
values = [0.5, 2.0]
"""


def test_what_varies_along_is_scaled_by_the_same_factor(tmp_path: Path) -> None:
    study = read_study(written(tmp_path, SMALL + LINKED))
    assert study.samples == 2 * 24
    drawn = draw_samples(study.varied, study.file)
    factors = drawn["joint.small.gains.near.error"]
    assert set(factors) == {0.5, 2.0}
    on_machine = machine_values(study.varied, drawn, study.machine)
    for path in ("near.error", "close.error", "integral"):
        whole = f"joint.small.gains.{path}"
        assert np.allclose(on_machine[whole], factors * value_at(study.machine, whole), rtol=1e-15)
    assert np.array_equal(on_machine["scenario.payload"], drawn["scenario.payload"])


def test_the_table_has_the_factor_with_the_unit_of_a_number(tmp_path: Path) -> None:
    run_study(read_study(written(tmp_path, SMALL + LINKED)), tmp_path / "out")
    found = study_table(tmp_path / "out")
    assert set(found["joint.small.gains.near.error"]) == {0.5, 2.0}
    assert found.attrs["units"]["joint.small.gains.near.error"] == "1"
    assert "joint.small.gains.integral" not in found
    each = found.groupby(["joint.small.brake.torque", "scenario.payload"])["air_used"].nunique()
    assert (each == 2).all()


def test_the_same_value_for_all_that_vary_along(tmp_path: Path) -> None:
    text = (
        SMALL + '[vary."supply.temperature"]\nalso = ["supply.ambient_temperature"]\nvalues = ["5 degC", "30 degC"]\n'
    )
    study = read_study(written(tmp_path, text))
    on_machine = machine_values(study.varied, draw_samples(study.varied, study.file), study.machine)
    assert np.array_equal(on_machine["supply.temperature"], on_machine["supply.ambient_temperature"])
    assert set(on_machine["supply.temperature"]) == {278.15, 303.15}


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("close.error", "close.eror", "also.0: no number of this name can vary; nearest is"),
        ('"joint.small.gains.close.error"', '"scenario.load"', "scenario.load is not a number of the machine"),
        ('"joint.small.gains.close.error"', '"angle_sensor.bits"', "relative: is a whole number; give values"),
        ('"joint.small.gains.close.error"', '"joint.small.brake.torque"', "joint.small.brake.torque varies twice"),
        ("relative = true\nvalues = [0.5, 2.0]", 'values = ["1 V/deg"]', "gains.integral' is of another kind"),
        ("values = [0.5, 2.0]", 'values = ["1 V/deg"]', "values.0: '1 V/deg' is not a number"),
        ("values = [0.5, 2.0]", "values = [-0.5]", "values.0: -0.5 is out of range"),
        ("relative = true", 'relative = true\ngroup = "gains"', "group: has no effect; use sampling = \"saltelli\""),
        ("relative = true", "relativ = true", "relativ: unknown key; did you mean 'relative'?"),
    ],
)  # fmt: skip
def test_a_mistake_is_named_in_one_line(tmp_path: Path, old: str, new: str, expected: str) -> None:
    assert old in LINKED
    with pytest.raises(InputError) as caught:
        read_study(written(tmp_path, SMALL + LINKED.replace(old, new)))
    assert expected in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_factor_that_leads_out_of_bounds_is_refused(tmp_path: Path) -> None:
    text = SMALL + '[vary."valve.friction"]\nrelative = true\nvalues = [1.0, 30.0]\n'
    with pytest.raises(InputError, match=r"vary.valve.friction: sample 1\.5 is out of range"):
        read_study(written(tmp_path, text))
    text = SMALL + '[vary."valve.leakage"]\nrelative = true\nvalues = [1.0, 1000.0]\n'
    with pytest.raises(InputError, match="leakage must be smaller than conductance"):
        read_study(written(tmp_path, text))
