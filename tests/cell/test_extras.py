from __future__ import annotations

import os
import subprocess
import sys

import pytest

from layflat.cell import extras
from layflat.errors import InputError


def test_a_missing_package_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cv2", None)
    with pytest.raises(InputError, match=r"needs opencv-python-headless, not installed; .* 'layflat\[cell\]'"):
        extras.opencv()


def test_a_cell_is_read_without_the_heavy_packages() -> None:
    code = "import sys, layflat.cell as c; c.load('packing'); print({'cv2', 'mujoco', 'OpenGL'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"


def test_a_scene_goes_on_without_what_draws_and_a_picture_says_what_to_install() -> None:
    code = """
from layflat.cell import load
from layflat.cell.scene.camera import SimulatedCamera
from layflat.cell.scene import Scene
from layflat.errors import NoDrawingError
scene = Scene(load("packing"), 0)
scene.step(5)
try:
    SimulatedCamera(scene)
except NoDrawingError as error:
    print(error)
"""
    hidden = os.environ | {"MUJOCO_GL": "egl", "__EGL_VENDOR_LIBRARY_FILENAMES": "/nowhere.json"}
    done = subprocess.run([sys.executable, "-c", code], env=hidden, capture_output=True, text=True, check=True)
    assert "apt-get install libegl1 libgl1-mesa-dri" in done.stdout
