"""Stresses of a built joint against closed forms, and that a weak part is a finding."""

from math import pi

import pytest

from layflat import extras
from layflat.solids.strength import check_strength
from layflat.solids.stresses import joint_stresses
from tests.solids.checks.builds import built

pytestmark = pytest.mark.skipif(not extras.available("cad"), reason="no extra cad; pip install layflat[cad]")


def test_hinge_bush_and_shaft_bear_the_straps_pull() -> None:
    sizes = built().sizes["small"]
    stresses = {one.where.removeprefix("small: "): one for one in joint_stresses(sizes, built().components, "small")}
    assert stresses["hinge: webbing"].stress == pytest.approx(sizes.pull / (110e-3 * 1e-3))
    assert stresses["bush"].stress == pytest.approx(sizes.pull / 2)
    assert stresses["bush"].limit == pytest.approx(40e6 * sizes.shaft * sizes.end_plate / 1e6)
    moment = sizes.pull / 2 * (sizes.top - sizes.end_plate / 2 - sizes.arm_z[1]) / 1e3
    twist = 16 * sizes.joint.brake.torque / (pi * (sizes.shaft / 1e3) ** 3)
    bent = 32 * moment / (pi * (sizes.shaft / 1e3) ** 3)
    assert stresses["shaft"].stress == pytest.approx((bent**2 + 3 * twist**2) ** 0.5, rel=1e-6)


@pytest.mark.parametrize("name", ["paper-small-joint", "single-joint-lift"])
def test_parts_sized_by_rules_are_strong_enough(name: str) -> None:
    stresses = joint_stresses(built(name).sizes["small"], built(name).components, "small")
    assert {one.where for one in stresses} >= {"small: end plate", "small: end clamp: bar", "small: brake: beam"}
    assert all(one.source for one in stresses)
    assert [check_strength(one) for one in stresses] == [None] * len(stresses)
