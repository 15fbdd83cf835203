"""Assemblies of arms: where the joints are, what they weigh, and that angles are checked."""

from functools import cache

import numpy as np
import pytest

from layflat import extras
from layflat.bridge.pieces import rigid_arm
from layflat.errors import InputError
from layflat.machine import load
from layflat.machine.parts import DeflectingRoller
from layflat.solids.assembly import Assembly, assemble
from tests.solids.bodies import body_of

pytestmark = pytest.mark.skipif(not extras.available("cad"), reason="no extra cad; pip install layflat[cad]")


@cache
def built(name: str, *angles: float) -> Assembly:
    return assemble(load(name), angles or None)


def test_the_papers_arm_weighs_what_the_paper_says_within_a_tenth() -> None:
    arm = built("paper-arm")
    mass = sum(arm.mass_of(part) * part.quantity for part in arm.components)
    assert mass == pytest.approx(8.5, rel=0.1)


@pytest.mark.parametrize("angles", [(0.0, 0.0), (0.7, -1.1)])
def test_shafts_lie_on_the_axes_of_the_arm_and_turn_with_it(angles: tuple[float, ...]) -> None:
    arm = built("paper-arm", *angles)
    frames = rigid_arm(load("paper-arm")).poses(angles)
    shafts = [part for part in arm.components if part.name == "shaft"]
    assert [part.joint for part in shafts] == ["large", "small"]
    for part, (_, origin) in zip(shafts, frames, strict=False):
        assert part.places[0].origin[:2] == pytest.approx(1e3 * origin[:2], abs=1e-6)


def test_the_flange_ends_where_the_tool_is() -> None:
    arm = built("paper-arm", 0.7, -1.1)
    _, tip = rigid_arm(load("paper-arm")).poses((0.7, -1.1))[-1]
    (flange,) = [part for part in arm.components if part.name == "tool flange"]
    (at,) = flange.places
    points = np.array([[v.X, v.Y, v.Z] for v in body_of(arm.solid(flange)).vertices()]) @ at.axes.T + at.origin
    elbow = rigid_arm(load("paper-arm")).poses((0.7, -1.1))[1][1]
    along = (tip - elbow) / np.linalg.norm(tip - elbow)
    assert float((points @ along).max()) == pytest.approx(1e3 * float(tip @ along), abs=1e-6)


def test_an_arm_in_space_is_built_whole() -> None:
    arm = built("picking-arm")
    assert arm.omitted == {}
    assert {part.joint for part in arm.components} == {"base", "shoulder", "elbow", "wrist"}
    assert all(body_of(arm.solid(part)).is_valid for part in arm.components)


@pytest.mark.parametrize("name", ["base", "shoulder", "wrist"])
def test_the_rest_of_an_arm_is_built_where_a_strap_is_deflected(name: str) -> None:
    arm = load("picking-arm")
    joint = arm.joint[name]
    roller = DeflectingRoller(diameter="25 mm", count=1, friction_fraction=0.006, bending_fraction=0.05)
    output = joint.output.model_copy(update={"shaft_offset": 0.0})
    deflected = joint.model_copy(update={"deflecting_roller": roller, "output": output})
    found = assemble(arm.model_copy(update={"joint": {**arm.joint, name: deflected}}))
    assert set(found.omitted) == {name}
    assert "\n" not in found.omitted[name]
    assert {part.joint for part in found.components} == set(arm.joints) - {name}
    # The first joint alone stands on a foot; the others have tongues for what carries them.
    assert [one for one, sizes in found.sizes.items() if sizes.foot] == [one for one in ("base",) if one != name]
    assert all((sizes.mount is None) == sizes.foot for sizes in found.sizes.values())


@pytest.mark.parametrize(("angles", "text"), [((0.0,), "1 angles for 2 joints"), ((0.0, 2.0), "114.6 deg for small")])
def test_wrong_angles_are_named(angles: tuple[float, ...], text: str) -> None:
    with pytest.raises(InputError, match=text):
        assemble(load("paper-arm"), angles)
