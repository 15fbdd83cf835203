import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray

from layflat.errors import InputError
from layflat.identify import fit
from layflat.identify.benches import insert_columns, simulate_candidates
from layflat.identify.benches.loader import load_bench
from layflat.identify.benches.regulated import RegulatedLog, RegulatedModel, parameters
from layflat.identify.benches.regulated.description import RegulatedJointBench
from layflat.identify.benches.regulated.laws import MAX_STEP_TIME, NOTHING_IMPOSED, RegulatedSignals, run_regulated
from layflat.identify.identification import prepare_identification

TRUTH = {
    "load.inertia": 0.004,
    "load.damping": 0.07,
    "load.torque": 0.1,
    "load.stiffness": 0.3,
    "friction.lower_end": 0.25,
    "friction.upper_end": 0.08,
    "friction.change_angle": -0.3,
    "friction.change_width": 0.15,
    "friction.lag": 3.0,
    "friction.static_ratio": 1.25,
    "stroke.lower_stop": -1.15,
}


def rig() -> RegulatedJointBench:
    described: RegulatedJointBench = load_bench("regulated-elbow")
    return described


def commands(seconds: float, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Set-points against each other around 4 bar gauge: smooth moves between rests."""
    time = np.arange(round(30 * seconds) + 1) / 30.0
    knots = np.arange(0.0, seconds + 0.7, 0.7)
    levels = np.random.default_rng(seed).uniform(-1.0e5, 0.9e5, len(knots))
    swing = np.interp(time, knots, levels)
    return time, 5e5 + swing, 5e5 - swing


def free_run(described: RegulatedJointBench, log: RegulatedLog, step: float = MAX_STEP_TIME) -> np.ndarray:
    """Angle and pressures of the joint of `TRUTH` from the set-points of a log, (samples, 3)."""
    case = parameters(insert_columns(described, TRUTH), log), log.signals, NOTHING_IMPOSED, step
    runs = simulate_candidates(run_regulated, 1, [case], [(len(log.signals.time), 3)])[0]
    return np.asarray(runs[0])


def log(described: RegulatedJointBench, seconds: float = 8.0, seed: int = 0, *, noise: float = 1.0) -> xarray.Dataset:
    """What the joint of `TRUTH` does, with the noise of usual sensors."""
    time, a, b = commands(seconds, seed)
    start = np.full_like(time, np.nan)
    course = RegulatedSignals(time, a, b, start, np.full_like(time, 1.2e5), np.full_like(time, 6.5e5))
    run = free_run(described, RegulatedLog("one", course, "lower_stop"))
    rng, half = np.random.default_rng(seed + 100), 0.5 * described.stroke.reading
    angle = np.clip(run[:, 0] + noise * 2e-3 * rng.standard_normal(len(time)), -half, half)
    angle[0] = -half
    p_a, p_b = (run[:, i] + noise * 1e3 * rng.standard_normal(len(time)) for i in (1, 2))
    signals = {"angle": angle, "pressure_a": p_a, "pressure_b": p_b, "setpoint_a": a, "setpoint_b": b}
    return xarray.Dataset({key: ("time", values) for key, values in signals.items()}, coords={"time": time})


def test_the_values_behind_a_log_are_found_and_predict_another() -> None:
    described = rig()
    logs, others = {"one": log(described, seed=1)}, {"other": log(described, seed=3)}
    model = RegulatedModel(described, logs, others, blocks=["motion"])
    found = fit(model, starts=0)
    for path in ("load.inertia", "load.damping", "load.torque", "friction.lower_end"):
        assert found.estimate(path).value == pytest.approx(TRUTH[path], rel=0.25), path
    validation = {quality.output: quality for quality in found.qualities() if quality.validation}
    assert validation["angle"].rms < 0.02 * described.stroke.reading
    assert validation["pressure_a"].rms < 3e3


def test_without_noise_the_truth_predicts_all_outputs_and_so_do_the_easier_models() -> None:
    described = rig()
    model = RegulatedModel(described, {"one": log(described, noise=0.0)})
    values = np.array([[TRUTH.get(one.path, one.guess) for one in model.unknowns]])
    for rung, most in zip(model.continuations()[0], (0.04, 0.04, 1e-9), strict=True):
        error = rung.simulate(values)[0] - model.measured
        for place, output in zip(model.slices, model.outputs, strict=True):
            rms = np.sqrt(np.nanmean(error[place][2:] ** 2))
            assert rms <= most * np.nanstd(output.measured), (output.name, rms)


def test_a_joint_at_the_end_of_its_reading_begins_at_its_stop() -> None:
    described = rig()
    model = RegulatedModel(described, {"one": log(described, seed=1)})
    (lower,) = [i for i, one in enumerate(model.unknowns) if one.path == "stroke.lower_stop"]
    assert "stroke.upper_stop" not in [one.path for one in model.unknowns]
    values = np.tile([TRUTH.get(one.path, one.guess) for one in model.unknowns], (2, 1))
    values[1, lower] -= 0.2
    near, far = model.simulate(values)[:, model.slices[0]]
    half = 0.5 * described.stroke.reading
    assert near.min() == far.min() == -half
    assert (near > -half).argmax() < (far > -half).argmax()


def test_a_block_that_is_not_asked_for_stays_as_described() -> None:
    described = rig()
    model = RegulatedModel(described, {"one": log(described)}, blocks=["motion"])
    assert {one.path.split(".")[0] for one in model.unknowns} == {"load", "friction", "stroke"}
    assert len(model.continuations()[0]) == 2


def test_without_another_log_the_rest_of_a_log_judges() -> None:
    described = rig()
    model = RegulatedModel(described, {"one": log(described, 3.0)})
    for output in model.outputs:
        assert output.fitted[output.time < 1.95].all()
        assert not output.fitted[output.time > 2.05].any()
    with pytest.raises(InputError, match="fitted_share"):
        RegulatedModel(described, {"one": log(described, 3.0)}, fitted_share=0.0)


def test_files_go_in_and_a_description_comes_out(tmp_path: Path) -> None:
    described = rig()
    made = log(described, 4.0, seed=1)
    table = {"time": made["time"].values} | {f"{key}.elbow": made[key].values for key in made.data_vars}
    path = tmp_path / "bench.csv"
    np.savetxt(path, np.column_stack(list(table.values())), delimiter=",", header=",".join(table), comments="")
    session = prepare_identification([path], "regulated-elbow", tmp_path / "out")
    assert set(session.blocks) == {"valve", "gas", "motion"}
    session = prepare_identification([path], "regulated-elbow", tmp_path / "out", blocks="motion")
    kept = session.write_results(session.fit(starts=0))
    assert isinstance(kept, RegulatedJointBench)
    assert kept.load.damping == pytest.approx(TRUTH["load.damping"], rel=0.5)
    assert kept.valve == described.valve


def test_simpler_frictions_have_fewer_unknowns_and_say_all_that_they_are() -> None:
    described = rig()
    model = RegulatedModel(described, {"one": log(described, 3.0)})
    coulomb, sticking = model.simpler_models().values()
    assert [len(model.unknowns) - len(one.unknowns) for one in (coulomb, sticking)] == [5, 4]
    for one, ratio in ((coulomb, 1.0), (sticking, TRUTH["friction.static_ratio"])):
        values = np.array([TRUTH.get(unknown.path, unknown.guess) for unknown in one.unknowns])
        found = one.described_values(values)
        assert found["friction.upper_end"] == found["friction.lower_end"] == TRUTH["friction.lower_end"]
        assert found["friction.static_ratio"] == ratio
        full = {unknown.path: found.get(unknown.path, unknown.guess) for unknown in model.unknowns}
        alike = model.simulate(np.array([list(full.values())]))
        assert np.array_equal(one.simulate(values[None]), alike, equal_nan=True)
    assert RegulatedModel(described, {"one": log(described, 3.0)}, blocks=["valve"]).simpler_models() == {}


def test_held_unknowns_keep_what_is_described() -> None:
    described = rig()
    model = RegulatedModel(described, {"one": log(described, 3.0)})
    held = model.hold(["chamber.wall_conductance", "valve.lag"])
    assert len(held.unknowns) == len(model.unknowns) - 2
    assert np.array_equal(held.simulate(held.guess[None]), model.simulate(model.guess[None]), equal_nan=True)
    assert not {"chamber.wall_conductance", "valve.lag"} & held.described_values(held.guess).keys()


def test_a_log_of_several_joints_is_refused() -> None:
    described = rig()
    both = xarray.concat([log(described, 2.0)] * 2, dim="joint")
    with pytest.raises(InputError, match="2 joints"):
        RegulatedModel(described, {"one": both})


def test_candidates_give_the_same_alone_and_side_by_side() -> None:
    described = rig()
    model = RegulatedModel(described, {"one": log(described, 3.0), "two": log(described, 2.0, seed=5)})
    values = np.tile(model.guess, (5, 1)) * np.linspace(0.95, 1.05, 5)[:, None]
    together = model.simulate(values)
    for row, alone in zip(together, values, strict=True):
        assert np.array_equal(row, model.simulate(alone[None])[0], equal_nan=True)


def test_smaller_steps_change_little() -> None:
    described = rig()
    model = RegulatedModel(described, {"one": log(described)})
    coarse, fine = (free_run(described, model.logs[0], step) for step in (1e-3, 1e-4))
    assert np.abs(coarse[:, 0] - fine[:, 0]).max() < 0.01 * described.stroke.reading
    assert np.abs(coarse[:, 1:] - fine[:, 1:]).max() < 5e3


@pytest.mark.parametrize(
    ("spoil", "told"),
    [
        (lambda d: d.drop_vars("setpoint_b"), "one: has no setpoint_b"),
        (lambda d: d.assign(setpoint_a=d["setpoint_a"].where(d["time"] > 1.0)), "one: setpoint_a"),
        (lambda d: d.assign(pressure_a=d["pressure_a"].where(d["time"] > 1.0)), "one: pressure_a"),
        (lambda d: d.assign(angle=np.degrees(d["angle"])), "one: angle"),
        (lambda d: d.isel(time=slice(None, None, -1)), "one: its time"),
    ],
)
def test_a_log_that_cannot_be_used_is_refused_in_one_line(spoil: object, told: str) -> None:
    described = rig()
    with pytest.raises(InputError) as error:
        RegulatedModel(described, {"one": spoil(log(described, 2.0))})  # type: ignore[operator]
    assert "\n" not in str(error.value)
    assert told.split(": ", maxsplit=1)[0] in str(error.value)
    assert told.split(": ")[1] in str(error.value)


def test_unknown_blocks_are_refused() -> None:
    described = rig()
    logs = {"one": log(described, 2.0)}
    with pytest.raises(InputError, match="blocks"):
        RegulatedModel(described, logs, blocks=["valves"])


@pytest.mark.slow
def test_the_elbow_of_an_android_is_predicted_from_its_commands(measured_data: Path, tmp_path: Path) -> None:
    """The program, fitted on the first 6 s of two runs and validated by another; the rig repeats itself within 1 %."""
    script = Path(__file__).parents[4] / "research" / "measured_logs" / "affetto.py"
    for name in ("motion_data_000.csv", "motion_data_003.csv", "motion_data_006.csv"):
        lines = (measured_data / "affetto" / name).read_text(encoding="utf-8").splitlines(keepends=True)
        (tmp_path / name).write_text("".join(lines[:181]), encoding="utf-8")
    command = [sys.executable, str(script), str(tmp_path), "--validate", "006", "--out", str(tmp_path)]
    subprocess.run(command, check=True, timeout=600)
    found = json.loads((tmp_path / "affetto.json").read_text(encoding="utf-8"))
    assert (tmp_path / "affetto.png").exists()
    assert found["converged"]
    validation = [own for own in found["logs"].values() if own["validation"]]
    assert len(validation) == 1
    assert validation[0]["angle_percent"] <= 2.5
    assert validation[0]["pressure_a_kpa"] <= 10.0
    assert validation[0]["pressure_b_kpa"] <= 10.0


def test_the_program_reports_in_one_line_what_is_missing(tmp_path: Path) -> None:
    script = Path(__file__).parents[4] / "research" / "measured_logs" / "affetto.py"
    (tmp_path / "motion_data_000.csv").write_text("t,rq5\n0,1\n1,2\n", encoding="utf-8")
    for folder, told in ((tmp_path / "nowhere", "nowhere"), (tmp_path, "rpa5")):
        command = [sys.executable, str(script), str(folder)]
        done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
        assert done.returncode == 2
        assert told in done.stderr
        assert done.stderr.count("\n") == 1
