from pathlib import Path
from typing import Any

import numpy as np
import pytest

from layflat.bridge import save_arm
from layflat.bridge.robots import import_arm
from layflat.errors import InputError
from tests.bridge.robot_files import UPPER, urdf, written

mujoco: Any = pytest.importorskip("mujoco")

PLATE = """<mujoco model="plate"><worldbody><body name="upper"><inertial pos="0 0 0.1" mass="0.5" {}/>
<joint name="shoulder" axis="0 1 0" range="-35 35"/></body></worldbody></mujoco>"""
ROUNDED = "0.000833333 0.000833333 0.00166667"  # of a square of 100 mm and 0.5 kg


@pytest.mark.parametrize("inertia", [f'diaginertia="{ROUNDED}"', f'fullinertia="{ROUNDED} 0 0 0"',
                                     f'diaginertia="{ROUNDED}" quat="1 2 0 3"'])  # fmt: skip
@pytest.mark.parametrize("suffix", [".xml", ".urdf"])
def test_a_plate_of_six_digits_goes_in_and_out(inertia: str, suffix: str, tmp_path: Path) -> None:
    arm = import_arm(written(tmp_path, PLATE.format(inertia), "plate.xml"))
    (note,) = arm.notes()
    assert note.startswith("inertia of body 'upper' is rounded to that of no body: taken 2e-06 of it smaller")
    save_arm(arm.machine, tmp_path / f"out{suffix}")
    moments = sorted(mujoco.MjModel.from_xml_path(str(tmp_path / f"out{suffix}")).body_inertia[1])
    assert moments == pytest.approx([0.000833333, 0.000833333, 0.00166667], rel=3e-6)


def test_the_same_plate_is_taken_from_urdf_and_exported_so_that_mujoco_reads_it(tmp_path: Path) -> None:
    a, b, c = ROUNDED.split()
    head, tail = UPPER.partition("<inertia ")[0], UPPER.partition("/></inertial>")[2]
    upper = f'{head}<inertia ixx="{a}" iyy="{b}" izz="{c}"/></inertial>{tail}'
    arm = import_arm(written(tmp_path, urdf(upper=upper)))
    for suffix in (".xml", ".urdf"):
        save_arm(arm.machine, tmp_path / f"out{suffix}")
        assert mujoco.MjModel.from_xml_path(str(tmp_path / f"out{suffix}")).nv == 2


def test_what_is_further_from_a_body_than_rounding_is_refused(tmp_path: Path) -> None:
    for inertia in ('diaginertia="0.001 0.001 0.0021"', 'fullinertia="0.001 0.001 0.0021 0 0 0"'):
        with pytest.raises(InputError, match=r"A \+ B >= C.*no principal moment"):
            import_arm(written(tmp_path, PLATE.format(inertia), "plate.xml"))


MESH = """<mujoco><asset><mesh name="m" file="none.stl"/></asset><worldbody><body name="upper">{}
<joint name="shoulder" axis="0 1 0" range="-35 35"/><geom type="mesh" mesh="m" {}/></body></worldbody></mujoco>"""
INERTIAL = '<inertial pos="0 0 0.1" mass="0.5" diaginertia="1 1 1"/>'


def test_without_meshes_an_mjcf_needs_none_that_weighs_nothing(tmp_path: Path) -> None:
    file = written(tmp_path, MESH.format(INERTIAL, ""), "arm.xml")
    assert import_arm(file, meshes=False).machine.arm.link["shoulder"].mass == 0.5
    with pytest.raises(InputError, match=r"none\.stl.*; put the file there, or leave meshes out: `meshes=False`"):
        import_arm(file)
    light = written(tmp_path, MESH.format('<geom size=".1"/>', 'mass="0"'), "arm.xml")
    assert np.isclose(import_arm(light, meshes=False).machine.arm.link["shoulder"].mass, 4000 / 3 * np.pi * 1e-3)
    heavy = written(tmp_path, MESH.format('<geom size=".1"/>', ""), "arm.xml")
    with pytest.raises(InputError, match="body 'upper' gets its mass from the mesh 'm'; give it an inertial"):
        import_arm(heavy, meshes=False)
