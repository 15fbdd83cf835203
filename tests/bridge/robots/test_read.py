from pathlib import Path

import pytest

from layflat.bridge.robots import ChainEnds, import_arm
from layflat.errors import InputError
from tests.bridge.robot_files import MJCF, urdf, written


@pytest.mark.parametrize(("name", "text", "to"), [
    ("a.urdf", urdf().replace("shoulder", "Gelenk für oben"), ""),
    ("a.xml", MJCF.replace("swing", "Gelenk für oben"), "fore")
])  # fmt: skip
@pytest.mark.parametrize(
    "encoding", ["utf-8", "UTF-8", "iso-8859-1", "ISO-8859-15", "windows-1252", "UTF-16", "utf-8-sig"]
)
def test_a_file_is_read_in_the_encoding_that_it_declares(
    name: str, text: str, to: str, encoding: str, tmp_path: Path
) -> None:
    declared = encoding.removesuffix("-sig")
    content = f'<?xml version="1.0" encoding="{declared}"?>\n{text.strip()}'.encode(encoding)
    (tmp_path / name).write_bytes(content)
    arm = import_arm(tmp_path / name, ends=ChainEnds(to=to))
    assert next(iter(arm.machine.joints)) == "Gelenk für oben"


@pytest.mark.parametrize(("head", "encoding", "expected"), [
    ("", "iso-8859-1", "is not in UTF-8 (line 2); save it as UTF-8, or declare its encoding in the first line"),
    ('<?xml version="1.0" encoding="ascii"?>', "iso-8859-1", "is not in UTF-8 (line 2); save it as UTF-8, or declare "
     "its encoding in the first line"),
    ('<?xml version="1.0" encoding="klingon"?>', "utf-8", "declares the unknown encoding 'klingon'; save it as UTF-8"),
    ('<?xml version="1.0" encoding="hex"?>', "utf-8", "declares the unknown encoding 'hex'; save it as UTF-8"),
])  # fmt: skip
def test_an_encoding_that_it_has_not_is_told(head: str, encoding: str, expected: str, tmp_path: Path) -> None:
    file = tmp_path / "a.urdf"
    file.write_bytes(f"{head}\n{urdf().replace('two', 'für')}".encode(encoding))
    with pytest.raises(InputError) as caught:
        import_arm(file)
    assert str(caught.value) == f"{file}: {expected}"


def test_an_option_of_mujoco_without_gravity_leaves_the_standard(tmp_path: Path) -> None:
    options = ('<option timestep="0.002"/>', "<compiler/>", '<option/><option gravity="0 0 -1"/>')
    pulls = [import_arm(written(tmp_path, urdf(f"<mujoco>{text}</mujoco>"))).machine.arm.gravity[2] for text in options]
    assert pulls == pytest.approx([-9.80665, -9.80665, -1.0])


def test_a_model_without_a_name_is_called_as_its_file(tmp_path: Path) -> None:
    file = written(tmp_path, MJCF.replace(' model="branching"', ""), "picker.xml")
    arm = import_arm(file, ends=ChainEnds(to="fore"))
    assert arm.machine.name == "picker"
    assert not any("is called" in note for note in arm.notes())
    named = written(tmp_path, MJCF.replace("branching", "v1.2 picker"), "picker.xml")
    assert (
        "the machine is called 'v1-2-picker', the robot 'v1.2 picker'"
        in import_arm(named, ends=ChainEnds(to="fore")).notes()
    )
    odd = import_arm(written(tmp_path, MJCF.replace("branching", "***"), "picker.xml"), ends=ChainEnds(to="fore"))
    assert "the machine is called 'picker', the robot '***'" in odd.notes()
