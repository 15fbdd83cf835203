from pathlib import Path

import numpy as np
import pandas
import pyarrow.parquet as pq
import pytest

from layflat.errors import InputError
from layflat.machine import changed
from layflat.sim.ensemble import ensemble
from layflat.study import read_study, run_study, study_table
from layflat.study.results import summarize_study
from tests.study.studies import SMALL, SOBOL, written

DEMAND = 'demand = [["0 s", "-10 deg"], ["0.05 s", "10 deg"]]\n'
WILD = SMALL.replace(DEMAND, "").replace("[scenario]", "[scenario]\nopening = 1.0\nbrake = 0.0").replace(
    '[vary."joint.small.brake.torque"]\nlow = "0 N m"\nhigh = "4 N m"\npoints = 6',
    '[vary."joint.small.stops.stop_stiffness"]\nvalues = ["1000 N m/rad", "1e9 N m/rad"]',
).replace('"0.2 s"', '"0.6 s"')  # fmt: skip


def test_a_row_is_the_run_that_it_names(tmp_path: Path) -> None:
    study = read_study(written(tmp_path))
    run_study(study, tmp_path / "out")
    found = study_table(tmp_path / "out")
    assert list(found.columns) == [
        "sample", "scenario", "noise_seed", "joint.small.brake.torque", "scenario.payload",
        "settling.small.0", "air_used", "diverged",
    ]  # fmt: skip
    assert list(found["sample"]) == list(range(24))
    row = found.iloc[13]
    assert row["joint.small.brake.torque"] == pytest.approx(0.8 * 3)
    assert row["scenario.payload"] == 1.0
    machine = changed(study.machine, "joint.small.brake.torque", row["joint.small.brake.torque"])
    machine = changed(machine, "arm.payload", row["scenario.payload"])
    alone = ensemble(machine, study.scenarios[0], precision=study.precision)
    assert float(alone["air_used"][0]) == row["air_used"]
    assert len(set(found["air_used"])) == 24


def test_every_column_has_its_unit(tmp_path: Path) -> None:
    path = run_study(read_study(written(tmp_path)), tmp_path / "out")
    units = {field.name: field.metadata[b"unit"].decode() for field in pq.read_schema(path)}
    assert units["joint.small.brake.torque"] == "N*m"
    assert units["scenario.payload"] == "kg"
    assert units["settling.small.0"] == units["diverged"] == "s"
    assert units["sample"] == "1"
    assert study_table(tmp_path / "out").attrs["units"] == units


def test_chunks_and_threads_make_no_difference(tmp_path: Path) -> None:
    study = read_study(written(tmp_path, SOBOL))
    whole = pq.read_table(run_study(study, tmp_path / "whole")).to_pandas()
    for chunk, threads in ((1, 1), (3, 2), (5, 1)):
        out = tmp_path / f"{chunk}"
        parts = pq.read_table(run_study(study, out, chunk=chunk, threads=threads)).to_pandas()
        pandas.testing.assert_frame_equal(parts, whole, check_exact=True)
        assert len(list((out / "chunks").iterdir())) == -(-8 // chunk)


def test_every_sample_runs_in_every_scenario_with_every_seed(tmp_path: Path) -> None:
    demand = '[["0 s", "0 deg"], ["0.1 s", "20 deg"], ["0.15 s", "0 deg"]]'
    second = f'[[scenario]]\nname = "back"\nseed = 50\nduration = "0.2 s"\ndemand = {demand}\n'
    text = SOBOL.replace("[scenario]", "noise_seeds = 3\n[[scenario]]").replace("[vary", f"{second}[vary", 1)
    found = run_study(read_study(written(tmp_path, text)), tmp_path / "out", chunk=7)
    frame = pq.read_table(found).to_pandas()
    assert len(frame) == 8 * 2 * 3
    assert list(frame["scenario"][:6]) == ["0"] * 3 + ["back"] * 3
    assert list(frame["noise_seed"][:6]) == [0, 1, 2, 50, 51, 52]
    assert len(set(frame["air_used"])) == 48
    # The first scenario has one move, the second two.
    assert np.all(frame["settling.small.1"].isna() == (frame["scenario"] == "0"))


def test_runs_that_diverged_are_kept_and_counted(tmp_path: Path) -> None:
    study = read_study(written(tmp_path, WILD.replace('"paper-small-joint"', '"paper-small-joint-fast"')))
    run_study(study, tmp_path / "out")
    frame = study_table(tmp_path / "out")
    wild = (frame["joint.small.stops.stop_stiffness"] == 1e9).to_numpy()
    assert len(frame) == 8
    assert np.all(frame["diverged"].notna() == wild)
    assert np.all(frame["air_used"].isna() == wild)
    assert np.all(frame["settling.small.0"].isna() == wild)
    told = summarize_study(tmp_path / "out", study.metrics)
    assert (told.runs, told.diverged) == (8, 4)
    assert told.settled == 0.0


def test_a_summary_has_quantiles_even_of_what_never_settles(tmp_path: Path) -> None:
    study = read_study(written(tmp_path, SMALL.replace('"0.2 s"', '"0.6 s"')))
    run_study(study, tmp_path / "out")
    frame, told = study_table(tmp_path / "out"), summarize_study(tmp_path / "out", study.metrics)
    unit, (low, median, high) = told.quantiles["settling.small.0"]
    assert unit == "s"
    assert told.settled == float(np.isfinite(frame["settling.small.0"]).mean())
    assert 0.0 < told.settled < 1.0
    assert low < median <= high == np.inf
    assert low in set(frame["settling.small.0"])


def test_progress_counts_up_to_all(tmp_path: Path) -> None:
    told: list[tuple[int, int]] = []
    study = read_study(written(tmp_path))
    run_study(study, tmp_path / "out", chunk=10, progress=lambda done, total: told.append((done, total)))
    assert told[0] == (0, 24)
    assert told[-1] == (24, 24)
    assert told == sorted(told)
    told.clear()
    run_study(study, tmp_path / "out", chunk=10, progress=lambda done, total: told.append((done, total)))
    assert told == [(24, 24)]


def test_there_is_no_table_where_no_study_was(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="holds no table of a study"):
        study_table(tmp_path)


def test_a_device_that_is_none_is_told_before_any_work(tmp_path: Path) -> None:
    study = read_study(written(tmp_path))
    with pytest.raises(InputError, match='device: \'tpu\' is not a device; use "cpu" or "cuda"'):
        run_study(study, tmp_path / "out", device="tpu")
    with pytest.raises(InputError, match="device: a cluster works on its processors, not on 'cuda'"):
        run_study(study, tmp_path / "out", device="cuda", scheduler="tcp://127.0.0.1:1")
    assert not (tmp_path / "out").exists()
