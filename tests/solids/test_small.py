"""The smallest joints: inlets in the shells, flanges of bushes in the ends of the cylinder."""

from math import dist

import pytest

from layflat import extras
from layflat.design import SizingRequest, size_joint
from layflat.solids.brake import stud_places
from layflat.solids.joint import joint_components
from layflat.solids.places import frame_places
from layflat.solids.sizes import MM, JointSizes
from tests.solids.test_joint import overlaps

pytestmark = pytest.mark.skipif(not extras.available("cad"), reason="no extra cad; pip install layflat[cad]")


def test_a_joint_of_three_newton_metres_is_built() -> None:
    sizes = JointSizes(size_joint(SizingRequest(torque="3 N m", stroke="115 deg", supply="4 bar")).design)
    found = joint_components(sizes, 0.5)
    assert {"outer inlet of hose A", "outer inlet of hose B"} <= {part.name for part in found}
    assert overlaps(found) == []


def test_flanges_of_bushes_lie_in_pockets_of_a_narrow_cylinder() -> None:
    sizes = JointSizes(size_joint(SizingRequest(torque="11 N m", stroke="128 deg", supply="5.6 bar")).design)
    assert sizes.axis + sizes.bush.flange * MM / 2 > sizes.inner_radius
    assert overlaps([part for part in joint_components(sizes) if part.name in {"cylinder", "bush"}]) == []


def test_studs_of_a_small_brake_lie_beside_the_washers_of_the_frame() -> None:
    sizes = JointSizes(size_joint(SizingRequest(torque="2.595 N m", stroke="62.7 deg", supply="2.37 bar")).design)
    room = (sizes.screw.washer_diameter + sizes.screw.diameter) / 2 * MM
    assert all(dist(stud, screw) >= room for stud in stud_places(sizes) for screw in frame_places(sizes))
