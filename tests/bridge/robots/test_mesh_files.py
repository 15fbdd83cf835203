from pathlib import Path

import pytest

from layflat.bridge.robots import ImportedArm, import_arm
from layflat.errors import InputError
from tests.bridge.meshes import write_wedge
from tests.bridge.robot_files import BASE, UPPER, urdf, written

LONG = f"{'a' * 5000}.stl"


def with_mesh(name: str, more: str = "") -> str:
    mesh = f'<visual><geometry><mesh filename="{name}"/></geometry></visual></link>'
    return urdf(more, upper=UPPER.replace("</link>", mesh))


def drawn(arm: ImportedArm) -> list[object]:
    return list(arm.text.meshes.values())


@pytest.mark.parametrize(("name", "place"), [
    ("package://my_robot/meshes/w.stl", "my_robot/meshes/w.stl"),  # around the file, which is in my_robot/urdf
    ("package://other/meshes/w.stl", "other/meshes/w.stl"),
    ("package://other/w.stl", "my_robot/urdf/w.stl"),
    ("model://other/w.stl", "other/w.stl"),
    ("meshes/w.stl", "my_robot/urdf/meshes/w.stl"),
    ("../meshes/w.stl", "my_robot/meshes/w.stl"),
    ("..\\meshes\\w.stl", "my_robot/meshes/w.stl"),
    ("file://{folder}/elsewhere/w.stl", "elsewhere/w.stl"),
    ("file://{folder}/else%20where/w.stl", "else where/w.stl"),
    ("{folder}/elsewhere/w.stl", "elsewhere/w.stl"),
    ("100%/w.stl", "my_robot/urdf/100%/w.stl"),
])  # fmt: skip
def test_meshes_are_where_their_names_say(name: str, place: str, tmp_path: Path) -> None:
    file = write_wedge(tmp_path / place)
    (tmp_path / "my_robot" / "urdf").mkdir(parents=True, exist_ok=True)
    arm = import_arm(written(tmp_path / "my_robot" / "urdf", with_mesh(name.format(folder=tmp_path))))
    assert drawn(arm) == [file.resolve()]


def test_a_folder_that_the_file_has_for_mujoco_counts(tmp_path: Path) -> None:
    file = write_wedge(tmp_path / "parts" / "w.stl")
    text = with_mesh("package://any/where/w.stl", '<mujoco><compiler meshdir="parts" strippath="true"/></mujoco>')
    assert drawn(import_arm(written(tmp_path, text))) == [file.resolve()]


def test_packages_that_are_elsewhere_are_named(tmp_path: Path) -> None:
    file = write_wedge(tmp_path / "far" / "my_robot" / "meshes" / "w.stl")
    (tmp_path / "here").mkdir()
    robot = written(tmp_path / "here", with_mesh("package://my_robot/meshes/w.stl"))
    with pytest.raises(InputError) as caught:
        import_arm(robot)
    line = str(caught.value)
    assert line.startswith(f"{robot}: link 'upper': mesh 'package://my_robot/meshes/w.stl' is not there; looked for ")
    assert str(tmp_path / "here" / "my_robot" / "meshes" / "w.stl") in line
    assert line.endswith("; say where package my_robot is in `packages`, or leave meshes out: `meshes=False`")
    assert drawn(import_arm(robot, packages={"my_robot": tmp_path / "far" / "my_robot"})) == [file.resolve()]
    with pytest.raises(InputError, match=r"looked for .*none/meshes/w\.stl; say"):
        import_arm(robot, packages={"my_robot": tmp_path / "none"})


def test_meshes_of_what_is_not_of_the_arm_do_not_matter(tmp_path: Path) -> None:
    base = BASE.replace("/>", '><visual><geometry><mesh filename="none.stl"/></geometry></visual></link>')
    assert drawn(import_arm(written(tmp_path, urdf(base=base)))) == []


@pytest.mark.parametrize(("name", "expected"), [
    ("none.stl", "is not there; looked for {folder}/none.stl; put it there, or leave meshes out: `meshes=False`"),
    pytest.param(LONG, f"is not there; looked for {{folder}}/{LONG}; put it there, or leave meshes out: `meshes=False`",
                 id="long"),
    ("https://x.org/w.stl", "is not on this computer; give a file, or leave meshes out: `meshes=False`"),
    ("a.step", "is of an unknown format; give STL, OBJ or DAE, or leave meshes out: `meshes=False`"),
])  # fmt: skip
def test_a_mesh_that_can_not_be_had(name: str, expected: str, tmp_path: Path) -> None:
    (tmp_path / "a.step").touch()
    file = written(tmp_path, with_mesh(name))
    with pytest.raises(InputError) as caught:
        import_arm(file)
    assert str(caught.value) == f"{file}: link 'upper': mesh {name!r} {expected.format(folder=tmp_path)}"
