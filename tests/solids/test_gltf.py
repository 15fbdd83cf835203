"""A GLB shows an assembly where it is, in metres with Y up, and its nodes turn as the joint does."""

from __future__ import annotations

import json
import struct
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from layflat.solids.gltf import Y_UP, frame_of, moving_frames, quaternion, write_glb
from layflat.solids.shapes import turn_about_z
from tests.solids.joints import components_of, maker_of_solids, sizes_of

if TYPE_CHECKING:
    from pathlib import Path

pytest.importorskip("OCP")
pytest.importorskip("pygltflib")

from layflat.solids.kernel import box, integrals, placed

SIZES = {"small": sizes_of("paper-arm", "small")}
SMALL = components_of("paper-arm", "small", 0.3)


SOLID = maker_of_solids()


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_glb(tmp_path_factory.mktemp("glb") / "arm.glb", "arm", SMALL, SIZES, SOLID)


def content(path: Path) -> dict[str, Any]:
    data = path.read_bytes()
    assert data[:4] == b"glTF"
    found: dict[str, Any] = json.loads(data[20 : 20 + struct.unpack_from("<I", data, 12)[0]])
    return found


def test_an_independent_reader_finds_every_part_in_its_place(path: Path) -> None:
    trimesh = pytest.importorskip("trimesh")
    scene = trimesh.load(path)
    parts = [placed(SOLID(one), at) for one in SMALL for at in one.places]
    assert len(scene.graph.nodes_geometry) == len(parts)
    boxes = np.array([box(one) for one in parts])
    corners = np.array([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)]) @ Y_UP.T / 1e3
    assert np.sort(corners, axis=0) == pytest.approx(scene.bounds, abs=2e-4)
    volume = sum(float(scene.geometry[scene.graph[name][1]].volume) for name in scene.graph.nodes_geometry)
    assert volume * 1e9 == pytest.approx(sum(integrals(one).volume for one in parts), rel=0.005)


def test_equal_parts_share_a_mesh_and_nodes_have_names(path: Path) -> None:
    found = content(path)
    assert len(found["meshes"]) == len({(one.shape, one.material) for one in SMALL})
    names = [node["name"] for node in found["nodes"]]
    assert len(names) == len(set(names))
    assert {"arm", "small/output", "small/shell a", "small/shaft", "small/tie bar 2"} <= set(names)
    assert {one["name"] for one in found["materials"]} == {one.material for one in SMALL}


def test_parts_are_below_the_node_with_which_they_move(path: Path) -> None:
    nodes = content(path)["nodes"]
    parents = {child: node["name"] for node in nodes for child in node.get("children", ())}
    frames = moving_frames(SMALL, SIZES)
    homes = {f"small/{one.name}": frame_of(one, frames) for one in SMALL if one.quantity == 1}
    for k, node in enumerate(nodes):
        if node["name"] in homes:
            assert parents[k] == homes[node["name"]]
    assert homes["small/cam of hose A"] == "small/output"
    assert homes["small/hose A"] == "small/body"


def test_equal_assemblies_give_equal_files(path: Path, tmp_path: Path) -> None:
    again = write_glb(tmp_path / "again.glb", "arm", components_of("paper-arm", "small", 0.3), SIZES)
    assert again.read_bytes() == path.read_bytes()


def test_nodes_that_turn_by_their_extras_are_where_the_joint_has_them() -> None:
    low, high = -0.5, 0.7
    before = moving_frames(components_of("paper-arm", "small", low), SIZES)
    after = moving_frames(components_of("paper-arm", "small", high), SIZES)
    for name in ("output", "shell a", "shell b"):
        first, second = before[f"small/{name}"], after[f"small/{name}"]
        turn = high - low
        if name != "output":
            turn = float(np.diff(np.interp([low, high], first.extras["angles"], first.extras["openings"]))[0])
        turned = first.place.axes @ turn_about_z(turn).axes
        assert turned == pytest.approx(second.place.axes, abs=3e-3)
        assert first.place.origin == pytest.approx(second.place.origin, abs=1e-6)


def test_a_chain_of_joints_hangs_on_the_outputs() -> None:
    pair = {"a": sizes_of("paper-arm", "large"), "b": sizes_of("paper-arm", "small")}
    components = [*components_of("paper-arm", "large", name="a"), *components_of("paper-arm", "small", name="b")]
    frames = moving_frames(components, pair)
    assert frames["a/body"].parent == ""
    assert frames["b/body"].parent == "a/output"
    assert list(frames).index("a/output") < list(frames).index("b/body")


def test_quaternions_turn_like_their_axes() -> None:
    x, y, z, w = quaternion(Y_UP)
    assert (x, y, z, w) == pytest.approx((-np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)))
    assert Y_UP @ [0.0, 0.0, 1.0] == pytest.approx([0.0, 1.0, 0.0])
