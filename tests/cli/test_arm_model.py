from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from layflat.cli import app
from layflat.errors import InputError

mujoco: Any = pytest.importorskip("mujoco")


@pytest.mark.parametrize("name", ["arm.xml", "arm.urdf"])
def test_what_it_writes_is_a_model(name: str, tmp_path: Path) -> None:
    out = tmp_path / "sub" / name
    done = CliRunner().invoke(app, ["arm", "export", "paper-arm", "--out", str(out)])
    assert done.output == f"wrote {out}\n"
    assert mujoco.MjModel.from_xml_path(str(out)).nv == 2


def test_ros2_control_is_for_urdf(tmp_path: Path) -> None:
    export = ["arm", "export", "paper-arm", "--ros2-control", "--out"]
    done = CliRunner().invoke(app, [*export, str(tmp_path / "arm.xml")])
    assert str(done.exception) == "--ros2-control: is for URDF alone; leave it out, or give arm.urdf"
    assert not list(tmp_path.iterdir())
    CliRunner().invoke(app, [*export, str(tmp_path / "arm.urdf")])
    assert '<ros2_control name="paper-arm" type="system">' in (tmp_path / "arm.urdf").read_text(encoding="utf-8")


def test_another_kind_is_refused(tmp_path: Path) -> None:
    done = CliRunner().invoke(app, ["arm", "export", "paper-arm", "--out", str(tmp_path / "arm.sdf")])
    assert isinstance(done.exception, InputError)
    assert str(done.exception) == "--out: 'arm.sdf' has an unknown format; give a name such as arm.xml or arm.urdf"
    assert not list(tmp_path.iterdir())
