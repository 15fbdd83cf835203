import os
import signal
import socket
import subprocess
import sys
from pathlib import Path
from urllib.request import urlopen

import numpy as np
import pytest
import xarray

from layflat.bridge.view import picture
from tests.cli.commands import LAYFLAT, layflat, refused


def saved_run(path: Path, *joints: str) -> Path:
    angles = np.linspace(np.zeros(len(joints)), np.full(len(joints), 0.3), 20)
    data = {"angle": (("time", "joint"), angles)}
    xarray.Dataset(data, {"time": np.arange(20) * 0.005, "joint": list(joints)}).to_netcdf(path, engine="h5netcdf")
    return path


@pytest.mark.usefixtures("opengl")
@pytest.mark.parametrize("options", [[], ["--pose", "-20 deg, 30 deg"], ["--run"]])
def test_a_picture_is_drawn_without_a_screen(options: list[str], tmp_path: Path) -> None:
    if options == ["--run"]:
        options = ["--run", str(saved_run(tmp_path / "run.nc", "large", "small"))]
    out = tmp_path / "sub" / "arm.png"
    done = layflat("arm", "view", "paper-arm", *options, "--png", str(out))
    assert done.stdout == f"wrote {out}\n"
    assert out.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (["--pose", "20 deg"], "--pose: '20 deg' has 1 values; give one for each of large, small"),
        (["--pose", "20, 10"], "--pose: '20' is a bare number; give an angle such as \"120 deg\""),
        (["--pose", "90 deg, 0 deg"], "--pose: 90 deg is beyond the stops of joint 'large'; stay within +-70 deg"),
        (["--run", "none.nc"], "none.nc: can't be read as a run"),
    ],
)
def test_wrong_options_are_one_line(options: list[str], expected: str, tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    line = refused("arm", "view", "paper-arm", *options, "--png", str(tmp_path / "arm.png"), cwd=tmp_path)
    assert line.startswith(f"layflat: {expected}")
    assert not list(tmp_path.iterdir())


def test_a_run_of_another_arm_and_another_format_are_refused(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    run = str(saved_run(tmp_path / "run.nc", "one", "two"))
    line = refused("arm", "view", "paper-arm", "--run", run, "--png", str(tmp_path / "arm.png"))
    assert line == f"layflat: {run}: is of an arm with the joints one, two; give one of joints large, small"
    line = refused("arm", "view", "paper-arm", "--png", str(tmp_path / "arm.jpg"))
    assert line == "layflat: --png: 'arm.jpg' has an unknown format; give a name such as arm.png"


def test_without_opengl_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    monkeypatch.setattr(picture, "GL_LIBRARIES", {"egl": "libNone.so"})
    line = refused("arm", "view", "paper-arm", "--png", str(tmp_path / "arm.png"))
    assert line == f"layflat: no picture can be drawn: there is no OpenGL library; {picture.GL_INSTALL_ADVICE}"


def test_a_page_is_served_until_it_is_stopped() -> None:
    pytest.importorskip("viser")
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    with subprocess.Popen(
        [*LAYFLAT, "arm", "view", "paper-arm", "--port", "0"], stdout=subprocess.PIPE, text=True, env=environment
    ) as page:
        assert page.stdout is not None
        try:
            assert page.stdout.readline() == "paper-arm is at the link below; Ctrl-C ends it\n"
            with urlopen(page.stdout.readline().strip(), timeout=20) as answer:
                assert answer.status == 200
            page.send_signal(signal.SIGINT)
            assert page.wait(20) == 0
        finally:
            page.kill()
        assert page.stdout.read() == ""


def test_a_port_in_use_is_told() -> None:
    pytest.importorskip("viser")
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        line = refused("arm", "view", "paper-arm", "--port", str(port))
    assert line.startswith(f"layflat: --port: port {port} can't be had")
