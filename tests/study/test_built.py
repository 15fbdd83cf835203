"""Mass and cost of built machines beside the metrics of their runs."""

from pathlib import Path

import numpy as np
import pytest

from layflat.errors import InputError
from layflat.machine import changed, load
from layflat.solids.cost import cost_of, read_prices
from layflat.solids.totals import list_built_parts
from layflat.study import Study, read_study, run_study, study_table
from tests.cli.commands import layflat
from tests.study.studies import SMALL, written

WIDTH = "joint.small.hose.width"
BUILT = SMALL.replace('"air_used"]', '"air_used", "mass_built", "cost"]\nprices = "prices.toml"').replace(
    '[vary."joint.small.brake.torque"]\nlow = "0 N m"\nhigh = "4 N m"\npoints = 6',
    f'[vary."{WIDTH}"]\nvalues = ["40 mm", "100 mm", "120 mm"]',
)  # fmt: skip
MASS_ALONE = BUILT.replace('["settling", "air_used", "mass_built", "cost"]\nprices = "prices.toml"', '["mass_built"]')
PRICES = '[stock]\naluminium = "12 /kg"\n[process]\nmilling = "25"\n[bought]\n"*" = "0.5"\n'


def study_in(folder: Path, text: str = BUILT, prices: str = PRICES) -> Study:
    (folder / "prices.toml").write_text(prices, encoding="utf-8")
    return read_study(written(folder, text))


def test_a_row_has_mass_and_cost_of_the_machine_that_it_names(tmp_path: Path) -> None:
    run_study(study_in(tmp_path), tmp_path / "out", chunk=5)
    found = study_table(tmp_path / "out")
    assert found.attrs["units"]["mass_built"] == "kg"
    assert found.attrs["units"]["cost"] == "1"
    for width in (0.1, 0.12):
        parts = list_built_parts(changed(load("paper-small-joint"), WIDTH, width))
        rows = found[found[WIDTH] == width]
        assert len(rows) == 4
        assert set(rows["mass_built"]) == {parts.mass}
        assert set(rows["cost"]) == {cost_of(parts, read_prices(tmp_path / "prices.toml")).total}
    cannot = found[found[WIDTH] == 0.04]
    assert np.isnan(cannot["mass_built"]).all()
    assert np.isfinite(cannot["air_used"]).all()


def test_runs_are_the_same_as_without_mass_and_cost(tmp_path: Path) -> None:
    run_study(study_in(tmp_path), tmp_path / "built")
    plain = BUILT.replace(', "mass_built", "cost"]\nprices = "prices.toml"', "]")
    run_study(study_in(tmp_path, plain), tmp_path / "plain")
    names = ["settling.small.0", "air_used"]
    assert study_table(tmp_path / "built")[names].equals(study_table(tmp_path / "plain")[names])


def test_mass_alone_may_vary_with_sizes_that_no_run_needs(tmp_path: Path) -> None:
    machine = 'extends = "paper-small-joint"\nname = "mine"\n[joint.small.build]\nend_plate_thickness = "10 mm"\n'
    (tmp_path / "mine.toml").write_text(machine, encoding="utf-8")
    text = MASS_ALONE.replace('"paper-small-joint"', '"mine.toml"').replace(
        f'"{WIDTH}"]\nvalues = ["40 mm", "100 mm", "120 mm"]',
        '"joint.small.build.end_plate_thickness"]\nvalues = ["8 mm", "10 mm", "12 mm"]',
    )
    run_study(study_in(tmp_path, text), tmp_path / "out")
    masses = study_table(tmp_path / "out").groupby("joint.small.build.end_plate_thickness")["mass_built"].first()
    assert masses.is_monotonic_increasing
    assert masses.nunique() == 3


def test_prices_count_by_what_they_are(tmp_path: Path) -> None:
    study = study_in(tmp_path)
    assert study.canonical() == study_in(tmp_path, prices=f"# mine\n{PRICES}").canonical()
    assert study.canonical() != study_in(tmp_path, prices=PRICES.replace("25", "26")).canonical()
    assert "prices" not in read_study("valves").canonical()["study"]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('prices = "prices.toml"\n', "", r'study.toml: metrics: "cost" needs prices; name a file'),
        (', "cost"]', "]", r'study.toml: prices: has no effect; add "cost" to metrics'),
        ("prices.toml", "none.toml", r"none\.toml: "),
        ('"mass_built"', '"mass"', r"'mass' is not a metric; use settling, .*, mass_built, cost"),
        ("paper-small-joint", "rig-shell-steel", r"metrics: 'mass_built' needs a machine that can be built: joint"),
    ],
)
def test_mistakes_are_one_line(tmp_path: Path, old: str, new: str, message: str) -> None:
    with pytest.raises(InputError, match=message) as caught:
        study_in(tmp_path, BUILT.replace(old, new))
    assert "\n" not in str(caught.value)


def test_the_command_names_parts_without_a_price(tmp_path: Path) -> None:
    study_in(tmp_path)
    done = layflat("study", "run", "study.toml", "--out", "out", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "mass_built" in done.stdout
    assert "no price, counted as nothing: " in done.stderr
    assert "shaft" in done.stderr
