import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from layflat.bridge import save_arm
from layflat.bridge.arm import conversion_losses
from layflat.bridge.meshes import load_mesh
from layflat.bridge.robots import import_arm
from layflat.errors import InputError
from tests.bridge.meshes import write_wedge
from tests.bridge.robot_files import UPPER, urdf, written
from tests.physics.arms.chain.chains import as_chain

mujoco: Any = pytest.importorskip("mujoco")

FLAT = [[(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(1, 0, 0), (1, 1, 0), (0, 1, 0)]]
LINE = [[(0, 0, 0), (1, 0, 0), (2, 0, 0)]]


def stl(triangles: Any) -> bytes:
    rows = [np.array([[0, 0, 0], *one], "<f4").tobytes() + b"\0\0" for one in triangles]
    return b"\0" * 80 + struct.pack("<I", len(triangles)) + b"".join(rows)


def obj(triangles: Any) -> bytes:
    corners = [corner for one in triangles for corner in one]
    lines = [f"v {x} {y} {z}" for x, y, z in corners] + [f"f {i} {i + 1} {i + 2}" for i in range(1, len(corners), 3)]
    return "\n".join(["# flat", *lines, ""]).encode()


def machine_with(folder: Path, name: str) -> Any:
    shapes = {"large": [{"kind": "mesh", "file": name, "scale": [0.1, 0.1, 0.1]}]}
    return as_chain(shapes=shapes, where=str(folder / "arm.toml"))


@pytest.mark.parametrize("triangles", [FLAT, FLAT[:1]], ids=["two triangles", "one"])
@pytest.mark.parametrize(("name", "write"), [("m.stl", stl), ("m.obj", obj)])
def test_flat_meshes_go_to_mujoco(triangles: Any, name: str, write: Any, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(write(triangles))
    save_arm(machine_with(tmp_path, name), tmp_path / "out.xml")
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "out.xml"))
    size = np.ptp(model.mesh_vert, axis=0)
    assert np.linalg.norm(size) == pytest.approx(0.1 * np.sqrt(2.0), rel=0.3)
    import_arm(tmp_path / "out.xml").save(tmp_path / "back")
    save_arm(machine_with(tmp_path, name), tmp_path / "out.urdf")
    assert mujoco.MjModel.from_xml_path(str(tmp_path / "out.urdf")).nv == 2
    (line,) = [one for one in conversion_losses(machine_with(tmp_path, name), ".urdf") if "draws" in one]
    assert line == f"MuJoCo draws nothing of this URDF, as it reads no DAE and no flat mesh there: {name}"


def test_a_mesh_without_surface_is_named(tmp_path: Path) -> None:
    (tmp_path / "m.obj").write_bytes(obj(LINE))
    with pytest.raises(InputError, match=r"m\.obj: can't be read as a mesh \(nothing in it\)"):
        save_arm(machine_with(tmp_path, "m.obj"), tmp_path / "out.xml")


@pytest.mark.parametrize(("name", "write"), [("m.stl", stl), ("m.obj", obj)])
@pytest.mark.parametrize("count", [2, 4])
def test_a_mesh_whose_corners_are_no_numbers_is_named(name: str, write: Any, count: int, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(write([[(0, 0, np.nan), (1, 0, 0), (0, 1, 0)], *FLAT * count][:count]))
    with pytest.raises(InputError, match=rf"{name}: has corners that are not finite; give another mesh"):
        save_arm(machine_with(tmp_path, name), tmp_path / "out.xml")


def dae(folder: Path, unit: str) -> Path:
    file = write_wedge(folder / "wedge.dae")
    file.write_text(file.read_text().replace('<unit meter="1"/>', unit))
    return file


@pytest.mark.parametrize(
    ("unit", "metres"),
    [('<unit name="millimeter" meter="0.001"/>', 1e-3), ("<unit meter='0.0254' name='inch'/>", 0.0254), ("", 1.0)],
)
def test_a_dae_is_as_large_as_its_unit_says(unit: str, metres: float, tmp_path: Path) -> None:
    file = dae(tmp_path, unit)
    assert np.ptp(load_mesh(file).vertices, axis=0) == pytest.approx([metres] * 3)
    mesh = '<visual><geometry><mesh filename="wedge.dae" scale="2 3 4"/></geometry></visual></link>'
    arm = import_arm(written(tmp_path, urdf(upper=UPPER.replace("</link>", mesh))))
    notes = [note for note in arm.notes() if "wedge.dae" in note]
    assert len(notes) == (metres != 1.0)
    saved = arm.save(tmp_path / "to")
    from layflat.machine import load

    save_arm(load(saved[0]), tmp_path / "out.xml")
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "out.xml"))
    assert np.abs(model.mesh_vert).max() < 4.0 * metres
    save_arm(load(saved[0]), tmp_path / "out.urdf")
    text = (tmp_path / "out.urdf").read_text()
    assert f'scale="{2.0 * metres!r} {3.0 * metres!r} {4.0 * metres!r}"' in text
    assert unit == "" or b'"1"' in (tmp_path / "out-urdf-meshes" / "wedge.dae").read_bytes().replace(b"'", b'"')
    assert import_arm(tmp_path / "out.urdf").machine.arm.link["shoulder"].shapes[1].scale == pytest.approx(
        (2.0 * metres, 3.0 * metres, 4.0 * metres)
    )


@pytest.mark.parametrize("unit", ["0", "-1", "inch", "nan"])
def test_a_unit_that_is_none_is_told(unit: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"wedge\.dae: declares a unit that is no length; give <unit meter"):
        load_mesh(dae(tmp_path, f'<unit meter="{unit}"/>'))


SCALED = """<mujoco><asset><mesh name="m" file="wedge.stl" {asset}/></asset><worldbody>
<frame {frame}><body name="upper"><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
<joint name="shoulder" axis="0 1 0" range="-35 35"/>
<geom type="mesh" mesh="m" contype="0" conaffinity="0"/></body></frame>
</worldbody></mujoco>"""


@pytest.mark.parametrize("asset", ["", 'scale="0.1 0.2 0.3"', 'refpos="1 2 3"', 'refquat="1 1 0 0" scale="2 2 2"'])
@pytest.mark.parametrize("frame", ["", 'scale="0.5"', 'pos="1 2 3" euler="10 20 30"'])
def test_meshes_of_an_mjcf_are_drawn_as_mujoco_draws_them(asset: str, frame: str, tmp_path: Path) -> None:
    write_wedge(tmp_path / "wedge.stl")
    file = written(tmp_path, SCALED.format(asset=asset, frame=frame), "robot.xml")
    arm = import_arm(file)
    saved = arm.save(tmp_path / "to")
    from layflat.machine import load

    machine = load(saved[0])
    (shape,) = machine.arm.link["shoulder"].shapes
    from layflat.physics.arms.bodies import rotation_from_angles

    ours = load_mesh(Path(shape.file)).vertices * np.array(shape.scale) @ rotation_from_angles(
        shape.rotation
    ).T + np.array(shape.position)
    model = mujoco.MjModel.from_xml_path(str(file))
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    geom, body = data.geom(0), data.body("upper")
    world = model.mesh_vert @ geom.xmat.reshape(3, 3).T + geom.xpos
    theirs = (world - body.xpos) @ body.xmat.reshape(3, 3)
    assert np.sort(ours.round(5), axis=0).min(axis=0) == pytest.approx(theirs.min(axis=0), abs=2e-5)
    assert ours.max(axis=0) == pytest.approx(theirs.max(axis=0), abs=2e-5)
