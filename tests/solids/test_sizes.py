"""Sizes that do not exist, or that no joint has, are refused with key and remedy."""

from collections.abc import Callable
from pathlib import Path

import pytest

from layflat.errors import DesignError, LayflatError
from layflat.machine import load
from layflat.solids.joint import joint_components, joint_sizes
from layflat.solids.sizes import JointSizes


@pytest.fixture
def sizes_with(tmp_path: Path) -> Callable[[str, str], JointSizes]:
    def described(key: str, value: str) -> JointSizes:
        path = tmp_path / "joint.toml"
        path.write_text(f'extends = "paper-small-joint"\n[joint.small.build]\n{key} = "{value}"\n')
        return joint_sizes(load(path), "small")

    return described


@pytest.mark.parametrize(
    ("key", "value", "text"),
    [
        ("screw", "M7", "joint.small.build.screw: unknown size 'M7'; known sizes are M2.5, M3"),
        ("shaft_diameter", "3 mm", "joint.small.build.shaft_diameter: no bush has a bore of 3 mm; bores are 4, 5"),
        ("end_plate_thickness", "80 mm", "joint.small: screw: no ISO 4762 M5 is 88.5 mm long; the longest is 50 mm"),
        ("end_plate_thickness", "0.3 mm", "joint.small.build: bushes in end plates of 0.3 mm do not bear"),
    ],
)
def test_a_size_that_does_not_exist_is_refused_with_its_key(
    sizes_with: Callable[[str, str], JointSizes], key: str, value: str, text: str
) -> None:
    sizes = sizes_with(key, value)
    with pytest.raises(DesignError) as refused:
        joint_components(sizes)
    assert text in str(refused.value)


@pytest.mark.parametrize("value", ["0.2 mm", "30 mm"])
def test_a_clearance_that_no_joint_has_is_refused(sizes_with: Callable[[str, str], JointSizes], value: str) -> None:
    with pytest.raises(LayflatError, match=r"joint\.small\.build\.clearance: .*out of range"):
        sizes_with("clearance", value)
