"""A network that finds the one red thing in a picture by its extent, as a stand-in for a learned one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import onnx
import pytest
from onnx import TensorProto, helper, numpy_helper
from pictures import Ball, Picture, Scene, take
from vision_scenes import CAMERA, KINDS, PLATES, TABLE, true_calibration

from layflat.cell.vision import OnnxDetector
from layflat.errors import InputError

ROWS, COLUMNS = 480, 640


def network(path: Path, last: tuple[float, ...] = (0.9, 0.0)) -> Path:
    """Redness over 0.2 by a convolution; its greatest and least column and row, then `last`."""
    across = np.arange(COLUMNS, dtype=np.float32)[None, None, None] + np.zeros((1, 1, ROWS, 1), np.float32)
    down = np.arange(ROWS, dtype=np.float32)[None, None, :, None] + np.zeros((1, 1, 1, COLUMNS), np.float32)
    constants = {
        "kernel": np.array([1.0, -0.5, -0.5], np.float32).reshape(1, 3, 1, 1),
        "bias": np.array([-0.2], np.float32),
        "steep": np.array([1e4], np.float32).reshape(1, 1, 1, 1),
        "across": across,
        "down": down,
        "back": COLUMNS - across,
        "up": ROWS - down,
        "columns": np.array([[[COLUMNS]]], np.float32),
        "rows": np.array([[[ROWS]]], np.float32),
        "one": np.array([[[1.0]]], np.float32),
        "shape": np.array([1, 1, 1]),
        "size": np.array([1, 1, ROWS, COLUMNS]),
        "last": np.array([[last]], np.float32),
    }
    nodes = [
        helper.make_node("Conv", ["picture", "kernel", "bias"], ["redness"], kernel_shape=[1, 1]),
        helper.make_node("Reshape", ["redness", "size"], ["sized"]),
        helper.make_node("Mul", ["sized", "steep"], ["strong"]),
        helper.make_node("Sigmoid", ["strong"], ["red"]),
    ]
    for ramp, name in (("across", "right"), ("down", "lower"), ("back", "from_right"), ("up", "from_below")):
        nodes += [
            helper.make_node("Mul", ["red", ramp], [f"{name}_map"]),
            helper.make_node("GlobalMaxPool", [f"{name}_map"], [f"{name}_pooled"]),
            helper.make_node("Reshape", [f"{name}_pooled", "shape"], [f"{name}_flat"]),
        ]
    nodes += [
        helper.make_node("Sub", ["columns", "from_right_flat"], ["left"]),
        helper.make_node("Sub", ["rows", "from_below_flat"], ["upper"]),
        helper.make_node("Add", ["right_flat", "one"], ["right"]),
        helper.make_node("Add", ["lower_flat", "one"], ["lower"]),
        helper.make_node("Concat", ["left", "upper", "right", "lower", "last"], ["boxes"], axis=2),
    ]
    graph = helper.make_graph(
        nodes,
        "red",
        [helper.make_tensor_value_info("picture", TensorProto.FLOAT, [1, 3, ROWS, COLUMNS])],
        [helper.make_tensor_value_info("boxes", TensorProto.FLOAT, [1, 1, 4 + len(last)])],
        [numpy_helper.from_array(value, name) for name, value in constants.items()],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 13)], ir_version=8)
    onnx.checker.check_model(model)
    onnx.save(model, path)
    return path


@pytest.fixture(scope="module")
def picture() -> Picture:
    scene = Scene(balls=[Ball("tomato", 0.3, 0.1, 0.03, (190.0, 40.0, 30.0))], plates=PLATES, table=TABLE)
    return take(scene, CAMERA, 5)


def test_geometry_measures_what_a_network_finds(tmp_path: Path, picture: Picture) -> None:
    detector = OnnxDetector(network(tmp_path / "red.onnx"), KINDS, TABLE, size=(ROWS, COLUMNS))
    (found,) = detector.find(picture, true_calibration())
    assert found.kind == "tomato"
    assert found.grade == "red"
    assert found.position == pytest.approx((0.3, 0.1, 0.03), abs=5e-4)
    assert found.diameter == pytest.approx(0.06, rel=0.01)
    assert found.confidence == pytest.approx(0.9, abs=0.05)


def test_a_number_over_the_kinds_is_of_no_known_kind(tmp_path: Path, picture: Picture) -> None:
    detector = OnnxDetector(network(tmp_path / "red.onnx", last=(0.9, 7.0)), KINDS, TABLE, size=(ROWS, COLUMNS))
    (found,) = detector.find(picture, true_calibration())
    assert found.kind is None
    assert found.grade is None


def test_a_file_that_is_no_network_is_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        OnnxDetector(tmp_path / "none.onnx", KINDS, TABLE)
    broken = tmp_path / "broken.onnx"
    broken.write_bytes(b"no network")
    with pytest.raises(InputError, match="is no network"):
        OnnxDetector(broken, KINDS, TABLE)


def test_a_network_of_other_shapes_is_told(tmp_path: Path, picture: Picture) -> None:
    without_kind = OnnxDetector(network(tmp_path / "five.onnx", last=(0.9,)), KINDS, TABLE, size=(ROWS, COLUMNS))
    with pytest.raises(InputError, match=r"gives \(1, 1, 5\); needs boxes"):
        without_kind.find(picture, true_calibration())
    smaller = OnnxDetector(network(tmp_path / "six.onnx"), KINDS, TABLE, size=(320, 320))
    with pytest.raises(InputError, match=r"fails on its input \(1, 3, 320, 320\); tell the size"):
        smaller.find(picture, true_calibration())
