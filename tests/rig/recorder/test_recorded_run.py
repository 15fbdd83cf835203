"""Recorded logs as runs: the same names and units as simulated ones, whoever takes them."""

import json
from math import radians
from pathlib import Path

import numpy as np
import pytest
import xarray

from layflat.errors import InputError, OutputError
from layflat.identify.logs import find_issues, read_log
from layflat.machine import Machine, load
from layflat.plot.runs import angle_figure, arm_steps, run_figure
from layflat.plot.style import to_svg
from layflat.rig.record import SHARED_COLUMNS, RowLayout
from layflat.rig.recorder.bag import BagWriter, LogHeading
from layflat.rig.recorder.ring import Event, EventLevel
from layflat.rig.recorder.run import export_run, read_run
from layflat.rig.safety.faults import Fault, RigState
from layflat.sim import rollout
from layflat.sim.dataset import open_run
from layflat.sim.metrics import measure_moves
from tests.rig.recorder.rigrows import BEGIN, CYCLE, HEADING, JOINTS, LAYOUT, column, log_of, rows


@pytest.fixture(scope="module")
def simulated() -> xarray.Dataset:
    return rollout("paper-small-joint", [("0 s", "0 deg"), ("0.3 s", "30 deg"), ("1.3 s", "-30 deg")], duration="2.5 s")


@pytest.fixture(scope="module")
def recorded(simulated: xarray.Dataset, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The simulated run, as a rig would have recorded it, with an uneven clock and some cycles missing."""
    machine = load("paper-small-joint")
    heading, layout = LogHeading.for_machine(machine, driver="simulated"), RowLayout.for_machine(machine)
    made = np.zeros((simulated.sizes["time"], layout.width))
    late = np.random.default_rng(0).exponential(1e-4, len(made))
    for i, name in enumerate(SHARED_COLUMNS):
        made[:, i] = simulated[name] if name == "supply" else 0.0
    made[:, 0] = simulated["time"] + late
    made[:, 1] = BEGIN * 1e-9 + made[:, 0]
    for i, name in enumerate(layout.by_joint):
        made[:, len(SHARED_COLUMNS) + i] = simulated[name][:, 0] if name in simulated else 0.0
    made[150:180, layout.shared["fault"]] = 4.0
    made[150:165, layout.shared["mode"]] = RigState.FAULT
    path = tmp_path_factory.mktemp("rig") / "run.mcap"
    with path.open("wb") as file:
        bag = BagWriter(file, heading, BEGIN, chunked=True)
        bag.add(np.delete(made, [200, 201], axis=0))
        bag.write_event(Event(0.75, EventLevel.ERROR, "following error"))
        bag.write_event(Event(1.2, EventLevel.INFO, "reset"))
        bag.finish()
    return path


def test_names_units_and_attributes_are_those_of_a_simulated_run(recorded: Path, simulated: xarray.Dataset) -> None:
    run = read_run(recorded)
    shared = [name for name in run.variables if name in simulated.variables]
    assert {"angle", "velocity", "demand", "voltage", "supply", "measured_angle", "phase"} < set(shared)
    for name in shared:
        assert run[name].dims == simulated[name].dims, name
        assert run[name].attrs.get("units") == simulated[name].attrs.get("units"), name
    assert {"machine", "machine_name", "layflat_version"} < set(run.attrs)
    assert Machine.model_validate_json(run.attrs["machine"]) == load("paper-small-joint")
    assert json.loads(run.attrs["notes"]) == {"driver": "simulated"}
    kept = np.delete(np.arange(simulated.sizes["time"]), [200, 201])
    for name in RowLayout.for_machine(load("paper-small-joint")).by_joint:
        if name in simulated:
            assert np.array_equal(run[name], simulated[name][kept]), name
    assert np.array_equal(run["angle"], run["measured_angle"])
    assert np.array_equal(run["velocity"], run["averaged_velocity"])
    assert run["event_text"].values.tolist() == ["following error", "reset"]
    assert run["event_time"].values.tolist() == [0.75, 1.2]


def test_metrics_take_it(recorded: Path, simulated: xarray.Dataset) -> None:
    sampled = simulated.assign(angle=simulated["measured_angle"])
    pairs = list(
        zip(measure_moves(read_run(recorded), radians(3.0)), measure_moves(sampled, radians(3.0)), strict=True)
    )
    assert len(pairs) == 2
    for (since, one), (told, other) in pairs:
        assert abs(since - told) < 0.002
        assert abs(one.settling - other.settling) < 0.02
        assert abs(one.steady_error - other.steady_error) < 1e-3


def test_figures_take_it_and_mark_what_went_wrong(recorded: Path) -> None:
    run = read_run(recorded)
    made = run_figure(run)
    assert all(axes.get_ylabel().endswith(")") for axes in made.axes)
    assert "Differential pressure (bar)" in [axes.get_ylabel() for axes in made.axes]
    assert [text.get_text() for text in made.axes[2].texts] == ["1"]
    assert [text.get_text() for text in made.texts] == ["1: at 0.75 s, following error"]
    faulty = run["time"].to_numpy()[run["mode"].to_numpy() == RigState.FAULT]
    for axes in made.axes:
        (shade,) = (one for one in axes.collections if one.get_label() == "fault")
        begin, end = shade.get_paths()[0].get_extents().intervalx
        assert (begin, end) == pytest.approx((faulty[0], faulty[-1]), abs=0.011)
    for figure in (made, arm_steps(run, band=radians(0.5)), angle_figure({"rig": run}, "small")):
        assert to_svg(figure)


def test_identification_reads_it_without_a_mapping(recorded: Path, simulated: xarray.Dataset) -> None:
    log = read_log(recorded, joints=["small"])
    assert set(log) == {"angle", "measured_pressure", "voltage", "demand", "supply"}
    assert abs(log.attrs["log_period"] - CYCLE) < 1e-4
    straight = np.interp(log["time"], simulated["time"], simulated["measured_angle"][:, 0])
    assert np.abs(log["angle"][:, 0] - straight).max() < np.radians(1.5)
    assert not [finding for finding in find_issues(log, load("paper-small-joint")) if finding.severity == "error"]


def test_exported_logs_hold_the_same(recorded: Path, tmp_path: Path) -> None:
    run = read_run(recorded)
    back: xarray.Dataset = open_run(export_run(run, tmp_path / "run.nc"))
    assert back.drop_vars("event_text").identical(run.drop_vars("event_text"))
    assert back["event_text"].values.tolist() == ["following error", "reset"]
    as_mcap = read_log(recorded, joints=["small"])
    for name in ("run.nc", "run.parquet"):
        log = read_log(export_run(run, tmp_path / name), joints=["small"])
        assert np.array_equal(log["angle"], as_mcap["angle"])
        assert np.array_equal(log["supply"], as_mcap["supply"])
    from pyarrow import parquet

    table = parquet.read_table(tmp_path / "run.parquet")
    assert table.schema.field("voltage.small").metadata == {b"unit": b"V"}
    assert json.loads(table.schema.metadata[b"events"])[0] == [0.75, 40, "following error"]


def test_formats_that_are_none_and_places_that_can_t_be_written_are_told(recorded: Path, tmp_path: Path) -> None:
    run = read_run(recorded)
    with pytest.raises(InputError, match=r"'\.xlsx' is not a format; use \.nc or \.parquet"):
        export_run(run, tmp_path / "run.xlsx")
    (tmp_path / "file").touch()
    with pytest.raises(OutputError, match="can't write here"):
        export_run(run, tmp_path / "file" / "run.nc")


def test_a_log_of_two_joints_without_events(tmp_path: Path) -> None:
    made = rows(7)
    run = read_run(log_of(tmp_path / "a.mcap", made))
    assert run["joint"].values.tolist() == list(JOINTS)
    assert np.array_equal(run["demand"], column(made, "demand"))
    assert run.sizes["event"] == 0
    assert run.attrs["machine"] == HEADING.machine


def test_what_is_no_log_of_a_rig_is_told(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    log_of(path, rows(9), chunked=False)
    with pytest.raises(InputError, match=r"was not finished; `layflat log repair .*` makes it whole"):
        read_run(path)
    log_of(path, rows(0))
    with pytest.raises(InputError, match="holds no cycles of a rig, no messages"):
        read_run(path)
    log_of(path, rows(0), [Event(0.0, EventLevel.INFO, "x")])
    with pytest.raises(InputError, match="holds no cycles of a rig, only rcl_interfaces/msg/Log"):
        read_run(path)
    whole = log_of(path, rows(500)).read_bytes()
    path.write_bytes(whole[:9000] + bytes(100) + whole[9100:])
    with pytest.raises(InputError, match=r"can't be read \(.*`layflat log repair .*` keeps what is whole"):
        read_run(path)


def test_a_log_of_the_first_version_still_reads() -> None:
    """60 cycles of a virtual rig, written before columns were renamed."""
    run = read_run(Path(__file__).parent / "logs" / "first-version.mcap")
    assert set(run["device"].values) == {0.0}
    assert run["device"].attrs["flag_meanings"] == "running centred dumped"
    assert run["measured_angle"].dims == ("time", "joint")
    assert run["demand"].values[-1, 0] == 0.2
    assert {"phase", "short_term", "long_term", "learning"} <= set(run.variables)
    assert list(run["event_text"].values) == ["off -> ready", "ready -> moving"]


def test_faults_of_a_log_go_by_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Logs of other versions have other numbers, and logs of the first ones do not say which."""
    made = rows(4)
    made[:, LAYOUT.shared["fault"]] = [0.0, 5.0, 6.0, 21.0]
    LAYOUT.named(made, "joint_fault")[:] = 0.0
    now = read_run(log_of(tmp_path / "now.mcap", made))
    assert [Fault(int(n)).name for n in now["fault"]] == ["NONE", "REPLY_LOST", "MODEL_DOUBTED", "DEVICE_DUMPED"]

    names = ["NONE", *["E_STOP"] * 4, "LINK_LOST", *["of_later"] * 16]
    monkeypatch.setattr("layflat.rig.recorder.bag.FAULT_NAMES", names)
    other = read_run(log_of(tmp_path / "other.mcap", made))
    assert [Fault(int(n)).name for n in other["fault"]] == ["NONE", "LINK_LOST", "E_STOP", "E_STOP"]

    monkeypatch.setattr("layflat.rig.recorder.run.METADATA", "missing")
    first = read_run(tmp_path / "now.mcap")
    assert [Fault(int(n)).name for n in first["fault"]] == ["NONE", "REPLY_LOST", "FOLLOWING_ERROR", "E_STOP"]
