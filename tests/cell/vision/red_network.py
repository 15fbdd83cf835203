"""A network that finds the one red thing in a picture by its extent, as a stand-in for a learned one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper

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
