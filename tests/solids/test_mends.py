"""Joints that can't be built are refused in one line with values that mend them."""

import re
from pathlib import Path

import pytest

from layflat.design import SizingRequest, size_joint
from layflat.errors import DesignError
from layflat.machine import changed, load
from layflat.solids.assembly import assemble
from layflat.solids.joint import joint_sizes
from layflat.solids.mends import buildable_components
from layflat.solids.sizes import JointSizes

ADVICE = re.compile(r'(\w+\.\w+) of "?([^"]+?)"?(?= and |$)')


def described(path: Path, base: str, values: dict[str, str]) -> JointSizes:
    """Sizes of the joint of a machine with values changed in its description, written to a file."""
    lines = [f'joint.small.{key} = "{value}"' for key, value in values.items()]
    path.write_text("\n".join([f'extends = "{base}"', *lines]))
    return joint_sizes(load(path), "small")


@pytest.mark.parametrize(
    ("base", "values", "text"),
    [
        ("50 N m, 89 deg, 4.2 bar", {}, "the cam sweeps"),
        ("100 N m, 83 deg, 4.2 bar", {"acting": "single"}, "the cam sweeps"),
        ("88.5 N m, 128 deg, 3.5 bar", {"output.shaft_offset": "64 mm"}, "the retaining ring of a shaft"),
        ("1.9 N m, 116 deg, 5.9 bar", {}, "the screws of the hoses' clamp have no place"),
        ("2.16 N m, 66 deg, 6 bar", {}, "the screws of the hoses' clamp have no place"),
        ("2.45 N m, 113 deg, 5.3 bar", {"acting": "single"}, "a shaft of 8 mm leaves no wall with a lever arm"),
        ("2 N m, 67 deg, 2 bar", {"output.kind": "roller"}, "the screws of the hoses' clamp have no place"),
        ("2.19 N m, 127 deg, 2.6 bar", {"output.kind": "roller"}, "no rod of M3 or more fits"),
        ("2.157 N m, 115.7 deg, 5.2 bar", {"acting": "single", "output.kind": "roller"}, "no rod of M2.5 or more fits"),
        ("2.27 N m, 117 deg, 6 bar", {"acting": "single"}, "a shaft of 8 mm leaves no wall with a lever arm"),
        ("paper-small-joint", {"build.disc_diameter": "160 mm"}, "the studs of a brake"),
        ("paper-small-joint", {"build.end_plate_thickness": "0.3 mm"}, "bushes in end plates of 0.3 mm do not bear"),
        ("paper-small-joint", {"build.end_plate_thickness": "80 mm"}, "screw: no ISO 4762 M5 is 88.5 mm long"),
        ("paper-small-joint", {"build.clamp_bar_thickness": "2 mm"}, "the screws of the hoses' clamp have no place"),
        ("paper-small-joint", {"build.clamp_bar_thickness": "40 mm"}, "the screws of the hoses' clamp have no place"),
        ("paper-small-joint", {"brake.torque": "60 N m"}, "no spring for 2328 N goes around a stud M5"),
        ("paper-small-joint", {"build.shaft_diameter": "6 mm"}, "shaft: safety"),
        ("paper-small-joint", {"build.screw": "M2.5"}, "cam of hose A, hole at"),
    ],
)
def test_advice_lets_a_joint_be_built(base: str, values: dict[str, str], text: str, tmp_path: Path) -> None:
    if "," in base:
        torque, stroke, supply = base.split(", ")
        base = "sized.toml"
        (tmp_path / base).write_text(size_joint(SizingRequest(torque=torque, stroke=stroke, supply=supply)).toml)
    sizes = described(tmp_path / "refused.toml", base, values)
    with pytest.raises(DesignError, match=re.escape(text)) as refused:
        buildable_components(sizes)
    assert re.fullmatch(rf"{re.escape(sizes.design.label)}\b.*; give .*", str(refused.value))
    advice = dict(ADVICE.findall(refused.value.right))
    assert buildable_components(described(tmp_path / "mended.toml", "refused.toml", advice))


def test_values_that_mend_are_looked_for_only_where_someone_reads_them() -> None:
    machine = changed(load("paper-small-joint"), "joint.small.build.clamp_bar_thickness", "40 mm")
    with pytest.raises(DesignError, match=r"leaves room$"):
        assemble(machine)
    with pytest.raises(DesignError, match=r"give build\.clamp_bar_thickness of [\d.]+ mm$"):
        assemble(machine, mend=True)
