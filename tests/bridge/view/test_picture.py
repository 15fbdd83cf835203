from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from layflat.bridge.pieces import COLOURS
from layflat.bridge.view.picture import HEIGHT, WIDTH, render_picture, save_picture
from layflat.bridge.view.scenery import scenery
from layflat.errors import InputError
from layflat.machine import load
from tests.bridge.meshes import write_wedge
from tests.physics.arms.chain.chains import as_chain, random_arm

pytest.importorskip("mujoco")


pytestmark = pytest.mark.usefixtures("opengl")


def share(seen: NDArray[np.uint8], of: str) -> float:
    """Share of a picture that has about the hue of some pieces."""
    hue = np.array(COLOURS[of][:3]) / np.linalg.norm(COLOURS[of][:3])
    length = np.linalg.norm(seen, axis=2)
    like = (seen @ hue) / np.maximum(length, 1.0)
    dark = length < 130 if of == "joint" else length > 130
    return float(np.mean((like > 0.99) & dark))


def test_arm_bodies_of_joints_and_tip_are_seen(tmp_path: Path) -> None:
    path = save_picture(load("paper-arm"), [-0.3, 0.4], tmp_path / "sub" / "arm.png")
    seen = np.asarray(Image.open(path))
    assert seen.shape == (HEIGHT, WIDTH, 3)
    assert 0.03 < share(seen, "joint") < 0.4
    assert 1e-4 < share(seen, "tip") < 0.02
    assert seen[0].mean() > 250  # the sky is white


def test_the_whole_arm_is_in_the_picture() -> None:
    machine = random_arm(4, 3)
    seen = render_picture(scenery(machine, [0.2, -0.3, 0.4, 0.1]), [0.2, -0.3, 0.4, 0.1])
    edge = np.concatenate([seen[:2].reshape(-1, 3), seen[:, :2].reshape(-1, 3), seen[:, -2:].reshape(-1, 3)])
    assert np.linalg.norm(edge.astype(float), axis=1).min() > 200  # sky and floor alone


def test_the_way_of_the_tip_is_drawn() -> None:
    machine = load("paper-arm")
    shown, way = scenery(machine, [0.0, 0.0]), np.linspace([-0.9, 0.0], [0.0, 0.0], 50)
    assert share(render_picture(shown, [0.0, 0.0], motion=way), "tip") > 2.0 * share(
        render_picture(shown, [0.0, 0.0]), "tip"
    )


@pytest.mark.parametrize("name", ["wedge.stl", "wedge-text.stl", "wedge.obj", "wedge.dae"])
def test_meshes_of_every_format_are_drawn(name: str, tmp_path: Path) -> None:
    pytest.importorskip("collada")
    write_wedge(tmp_path / name)
    shapes: dict[str, Any] = {"small": [{"kind": "mesh", "file": name, "scale": [0.5, 0.5, 0.5]}]}
    machine = as_chain(shapes=shapes, where=str(tmp_path / "arm.toml"))
    drawn, bare = (render_picture(scenery(one, [0.0, 0.0]), [0.0, 0.0]) for one in (machine, as_chain()))
    assert np.mean(np.any(drawn != bare, axis=2)) > 0.05


def test_a_mesh_that_is_none_is_named(tmp_path: Path) -> None:
    pytest.importorskip("trimesh")
    (tmp_path / "bad.stl").write_bytes(b"solid nothing")
    shapes = {"small": [{"kind": "mesh", "file": "bad.stl"}]}
    machine = as_chain(shapes=shapes, where=str(tmp_path / "arm.toml"))
    with pytest.raises(InputError, match=r"bad\.stl: can't be read as a mesh"):
        save_picture(machine, [0.0, 0.0], tmp_path / "arm.png")
    assert not (tmp_path / "arm.png").exists()
