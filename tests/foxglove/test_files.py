"""Files for Foxglove, read by MCAP's own reader and Google's protobuf: the same numbers, to the last bit."""

import resource
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
import xarray

from layflat.bridge.arm import save_arm
from layflat.bridge.meshes import load_mesh
from layflat.bridge.pieces import rigid_arm
from layflat.bridge.view.scenery import scenery
from layflat.errors import InputError, OutputError
from layflat.foxglove import write_mcap
from layflat.machine import Machine, load
from layflat.sim import Run, rollout
from tests.bridge.meshes import write_wedge
from tests.foxglove.messages import matrix, positions, read_messages
from tests.physics.arms.chain.chains import as_chain, random_arm

ARM = load("paper-arm")


@pytest.fixture(scope="module")
def run() -> Run:
    return rollout(ARM, [("0 s", {"large": "20 deg"})], start="-10 deg", duration="0.5 s")


def moving(machine: Machine, angles: np.ndarray) -> xarray.Dataset:
    """Angles, (n, joints), every 5 ms, as a data set of a machine."""
    data = {"angle": (("time", "joint"), angles)}
    time = 0.005 * np.arange(len(angles))
    return xarray.Dataset(data, {"time": time, "joint": list(machine.joints)}, {"machine": machine.model_dump_json()})


def test_a_run_reads_back_with_the_same_numbers(run: Run, tmp_path: Path) -> None:
    topics = read_messages(write_mcap(run, tmp_path / "run.mcap"))
    stamps = np.rint(run["time"].to_numpy() * 1e9).astype(int).tolist()
    for topic in ("/joint_states", "/tf", "/machine", "/joint/large", "/joint/small"):
        assert [stamp for stamp, _ in topics[topic]] == stamps
    assert positions(topics["/joint_states"]) == run["angle"].to_numpy().tolist()
    _, first = topics["/joint_states"][1]
    assert (first.timestamp.seconds, first.timestamp.nanos) == (0, stamps[1])
    assert [joint.name for joint in first.joints] == ["large", "small"]
    assert [joint.velocity for joint in topics["/joint_states"][50][1].joints] == run["velocity"][50].values.tolist()
    for joint in ("large", "small"):
        for index, (_, message) in enumerate(topics[f"/joint/{joint}"]):
            expected = {
                name: float(values[index].sel(joint=joint)) for name, values in run.items() if "joint" in values.dims
            }
            assert message == expected
    message = topics["/machine"][70][1]
    assert message["tip"] == dict(zip("xy", run["tip"][70].values.tolist(), strict=True))
    assert message["supply"] == float(run["supply"][70])


def test_transforms_lead_to_the_tip(run: Run, tmp_path: Path) -> None:
    topics = read_messages(write_mcap(run, tmp_path / "run.mcap"))
    for index in (0, 60, 100):
        transforms = topics["/tf"][index][1].transforms
        assert [one.child_frame_id for one in transforms] == ["base", "large-link", "small-link", "tool"]
        pose = np.linalg.multi_dot([matrix(one) for one in transforms])
        assert pose[:2, 3] == pytest.approx(run["tip"][index].values, abs=1e-12)


@pytest.mark.parametrize("seed", range(4))
def test_transforms_of_any_arm_are_those_of_its_frames(seed: int, tmp_path: Path) -> None:
    rng = np.random.default_rng(seed)
    machine = random_arm(1 + seed, seed)
    angles = rng.uniform(-1.0, 1.0, (3, len(machine.joints)))
    topics = read_messages(write_mcap(moving(machine, angles), tmp_path / "run.mcap"))
    for row, (_, message) in zip(angles, topics["/tf"], strict=True):
        pose = np.eye(4)
        for transform, (axes, origin) in zip(message.transforms, scenery(machine, row).frames(row), strict=True):
            pose = pose @ matrix(transform)
            assert pose[:3, :3] == pytest.approx(axes, abs=1e-12)
            assert pose[:3, 3] == pytest.approx(origin, abs=1e-12)


def test_the_scene_has_the_solids_of_each_link_in_its_frame(run: Run, tmp_path: Path) -> None:
    ((stamp, scene),) = read_messages(write_mcap(run, tmp_path / "run.mcap"))["/scene"]
    assert stamp == 0
    entities = {entity.frame_id: entity for entity in scene.entities}
    assert list(entities) == ["base", "large-link", "small-link", "tool"]
    assert all(entity.frame_locked for entity in entities.values())
    links = rigid_arm(ARM).links
    rod, body = entities["large-link"].cylinders
    assert rod.size.z == pytest.approx(float(np.linalg.norm(links[1].place)))
    assert (rod.bottom_scale, rod.top_scale) == (1.0, 1.0)
    assert len(entities["large-link"].spheres) == 2  # ends of a capsule
    assert body.size.x == ARM.joints["large"].cylinder.diameter
    assert {entity.lifetime.seconds for entity in entities.values()} == {0}  # for ever


def test_frames_are_the_links_of_the_exported_urdf(tmp_path: Path) -> None:
    machine = load("picking-arm")
    (urdf, *_) = save_arm(machine, tmp_path / "arm.urdf")
    topics = read_messages(write_mcap(moving(machine, np.zeros((1, 4))), tmp_path / "run.mcap"))
    for transform in topics["/tf"][0][1].transforms:
        assert f'<link name="{transform.child_frame_id}"' in urdf.read_text()


@pytest.mark.parametrize(
    ("name", "kind"), [("part.stl", "model/stl"), ("part.obj", "model/obj"), ("part.dae", "model/stl")]
)
def test_meshes_travel_with_the_scene(name: str, kind: str, tmp_path: Path) -> None:
    pytest.importorskip("collada")
    write_wedge(tmp_path / name)
    shapes = {"large": [{"kind": "mesh", "file": name, "position": ["0.1 m", "0 m", "0 m"], "scale": [0.1, 0.2, 0.3]}]}
    machine = as_chain(shapes=shapes, where=str(tmp_path / "arm.toml"))
    log = moving(machine, np.zeros((1, 2)))
    topics = read_messages(write_mcap(log, tmp_path / "run.mcap", machine=machine))
    (model,) = next(one for one in topics["/scene"][0][1].entities if one.frame_id == "large-link").models
    assert (model.media_type, model.url) == (kind, "")
    assert (model.scale.x, model.scale.y, model.scale.z, model.pose.position.x) == (0.1, 0.2, 0.3, 0.1)
    (tmp_path / f"sent.{kind[-3:]}").write_bytes(model.data)
    assert load_mesh(tmp_path / f"sent.{kind[-3:]}").volume == pytest.approx(1.0 / 6.0)


def test_events_and_times_of_day_of_a_log(tmp_path: Path) -> None:
    log = moving(ARM, np.zeros((3, 2))).assign(
        event_time=("event", [0.004, 0.2]), event_level=("event", [30, 40]), event_text=("event", ["warm", "e-stop"])
    )
    start = datetime(2026, 5, 1, 12, 30, 0, 250000, UTC)
    log.attrs["start"] = start.isoformat()
    topics = read_messages(write_mcap(log, tmp_path / "log.mcap"))
    begin = round(start.timestamp() * 1e9)
    assert [(stamp - begin, one.level, one.message) for stamp, one in topics["/events"]] == [
        (4_000_000, 3, "warm"),
        (200_000_000, 4, "e-stop"),
    ]
    assert [stamp - begin for stamp, _ in topics["/joint_states"]] == [0, 5_000_000, 10_000_000]


def test_values_that_are_no_numbers_are_left_out(tmp_path: Path) -> None:
    angles = np.array([[0.1, 0.2], [np.nan, 0.3], [0.4, np.inf]])
    topics = read_messages(write_mcap(moving(ARM, angles), tmp_path / "log.mcap"))
    states = [[joint.HasField("position") for joint in one.joints] for _, one in topics["/joint_states"]]
    assert states == [[True, True], [False, True], [True, False]]
    assert [one for _, one in topics["/joint/small"]] == [{"angle": 0.2}, {"angle": 0.3}, {}]
    assert [stamp for stamp, _ in topics["/tf"]] == [0]


def test_a_log_without_angles_has_its_other_signals(tmp_path: Path) -> None:
    log = xarray.Dataset({"supply": ("time", [5e5, 5.1e5])}, {"time": [0.0, 1.0]})
    topics = read_messages(write_mcap(log, tmp_path / "log.mcap"))
    assert topics == {"/machine": [(0, {"supply": 5e5}), (1_000_000_000, {"supply": 5.1e5})]}


def test_the_same_run_makes_the_same_file(run: Run, tmp_path: Path) -> None:
    first, second = (write_mcap(run, tmp_path / f"{name}.mcap").read_bytes() for name in "ab")
    assert first == second


def test_what_can_not_be_shown_is_refused(run: Run, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="data set: has no signals over time; give a run"):
        write_mcap(xarray.Dataset({"settling": ("joint", [1.0])}), tmp_path / "run.mcap")
    with pytest.raises(InputError, match=r"has the joints large, small; give one of the joints small, or another"):
        write_mcap(run, tmp_path / "run.mcap", machine="paper-small-joint")
    assert list(tmp_path.iterdir()) == []


def test_a_file_that_can_not_be_written_leaves_none(
    run: Run, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (10_000, before[1]))
    try:
        with pytest.raises(OutputError, match=r"run.mcap: can't write here"):
            write_mcap(run, tmp_path / "run.mcap")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert list(tmp_path.iterdir()) == []
    assert capfd.readouterr().err == ""
