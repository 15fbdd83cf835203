"""Clearances over the stroke against the CAD kernel's own distances."""

import numpy as np
import pytest

from layflat import extras
from layflat.solids import cad
from layflat.solids.assembly import assemble
from layflat.solids.checks.clearances import RUNNING_GAP, Clearance, arm_clearances
from layflat.solids.checks.frames import joint_parts, joint_place
from layflat.solids.checks.meshes import MeshStore
from layflat.solids.kernel import placed
from tests.solids.bodies import body_of
from tests.solids.checks.builds import built, checked

pytestmark = pytest.mark.skipif(not extras.available("cad"), reason="no extra cad; pip install layflat[cad]")


def kernel_distance(clearance: Clearance) -> float:
    """Return the least distance of all parts of both names, by the kernel, m."""
    parts = joint_parts(built(), clearance.joint, clearance.angles[0])
    first, second = (
        [body_of(placed(cad.solid(one.shape), at)) for one in parts if one.name == name for at in one.places]
        for name in (clearance.first, clearance.second)
    )
    return 1e-3 * min(float(a.distance_to(b)) for a in first for b in second)


def test_nearest_pairs_are_as_near_by_the_kernel() -> None:
    nearest = checked().clearances[:4]
    assert nearest
    for one in nearest:
        assert one.distance == pytest.approx(kernel_distance(one), abs=1e-4)


def test_distances_end_at_the_required_one_and_touching_parts_are_left_out() -> None:
    assembly = built()
    for one in checked().clearances:
        assert one.distance <= one.required
        assert one.required in (assembly.sizes["small"].clearance / 1e3, RUNNING_GAP / 1e3)
        assert {one.first, one.second} != {"bush", "shaft"}
        assert "strap of hose A" not in (one.first, one.second) or "shell A" not in (one.first, one.second)
        assert abs(one.angles[0]) <= assembly.sizes["small"].swing * (1 + 1e-12)


def test_a_finding_names_both_parts_distance_angle_and_a_key() -> None:
    one = Clearance("bump stop", "nut of the arm", "small", (np.radians(70.0),), 0.0013, 0.002)
    assert not one.enough
    assert str(one.finding) == (
        "small: bump stop and nut of the arm: they come within 1.3 mm at 70 deg; "
        "2 mm are required; change joint.small.build.screw"
    )
    assert one.finding.severity == "warning"
    assert Clearance("cam", "cylinder", "small", (0.0,), 0.0, 0.002).finding.severity == "error"


def test_joint_parts_turn_link_and_output_together_as_the_assembly_does() -> None:
    turned = assemble(built().machine, [0.6])
    place = joint_place(turned, "small")
    moved = [one.moved(place) for one in joint_parts(built(), "small", 0.6)]
    assert [one.name for one in moved] == [one.name for one in turned.components]
    for one, again in zip(turned.components, moved, strict=True):
        for at, again_at in zip(one.places, again.places, strict=True):
            assert again_at.origin == pytest.approx(at.origin, abs=1e-6)
            assert again_at.axes == pytest.approx(at.axes, abs=1e-9)


def test_a_single_joint_has_no_clearances_between_links() -> None:
    assert arm_clearances(built(), MeshStore()) == []


def test_links_that_fold_onto_the_base_are_found() -> None:
    arm = built("paper-arm")
    found = arm_clearances(arm, MeshStore())
    assert [one.joint for one in found] == ["large, small"]
    assert found[0].distance == 0.0
    assert found[0].finding.severity == "warning"
    assert "joint.small.stops.mechanical_stroke" in found[0].finding.right or "arm.tool" in found[0].finding.right
