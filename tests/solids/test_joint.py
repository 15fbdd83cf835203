"""Joints built from descriptions: valid solids that do not overlap and move as the laws say."""

from functools import cache
from itertools import combinations

import numpy as np
import pytest
from matplotlib.path import Path

from layflat import extras
from layflat.design import SizingRequest, size_joint
from layflat.errors import DesignError
from layflat.machine import load
from layflat.machine.build_sizes import Build
from layflat.machine.parts import Calliper
from layflat.solids import cad
from layflat.solids.cams import opening, strap_point
from layflat.solids.component import Component
from layflat.solids.documents.tubes import list_tubes
from layflat.solids.inlets import choose_inlet
from layflat.solids.joint import joint_components, joint_sizes
from layflat.solids.kernel import box, integrals, placed
from layflat.solids.section import CrossSection
from layflat.solids.shapes import Lofted
from layflat.solids.sizes import MM, JointSizes
from tests.solids.bodies import body_of

pytestmark = pytest.mark.skipif(not extras.available("cad"), reason="no extra cad; pip install layflat[cad]")

BUILT = [("paper-small-joint", "small"), ("paper-large-joint", "large"), ("picking-arm", "wrist")]


@cache
def sizes_of(machine: str, joint: str) -> JointSizes:
    return joint_sizes(load(machine), joint)


def overlaps(components: list[Component]) -> list[tuple[str, str, float]]:
    """Pairs of parts that overlap by more than 1 mm3."""
    solids = [(part, cad.solid(part.shape)) for part in components]
    assert all(body_of(solid).is_valid for _, solid in solids)
    bodies = [(part.name, body_of(placed(solid, at))) for part, solid in solids for at in part.places]
    boxes = [body.bounding_box() for _, body in bodies]
    found = []
    for (i, (name, body)), (k, (other, second)) in combinations(enumerate(bodies), 2):
        a, b = boxes[i], boxes[k]
        if any(getattr(a.max, x) < getattr(b.min, x) or getattr(b.max, x) < getattr(a.min, x) for x in "XYZ"):
            continue
        volume = sum(getattr(part, "volume", 0.0) for part in body.intersect(second) or ())
        if volume > 1.0:
            found.append((name, other, volume))
    return found


@pytest.mark.parametrize(
    ("machine", "joint", "share"),
    [("paper-small-joint", "small", -1.0), ("paper-large-joint", "large", 0.3), ("picking-arm", "wrist", 1.0)],
)
def test_parts_are_valid_solids_that_do_not_overlap(machine: str, joint: str, share: float) -> None:
    sizes = sizes_of(machine, joint)
    assert overlaps(joint_components(sizes, share * sizes.swing)) == []


def test_a_joint_with_a_roller_a_calliper_and_one_hose_is_built() -> None:
    sizes = sizes_of("single-joint-lift", "small")
    calliper = Calliper(released_fraction=0.1, stroke_time="0.1 s")
    output = sizes.joint.output.model_copy(update={"kind": "roller"})
    brake = sizes.joint.brake.model_copy(update={"calliper": calliper})
    machine = load("single-joint-lift")
    joint = sizes.joint.model_copy(update={"brake": brake, "output": output})
    changed = machine.model_copy(update={"joint": {**machine.joint, "small": joint}})
    found = joint_components(joint_sizes(changed, "small"), 0.4)
    assert {"roller of hose A", "brake cylinder"} <= {part.name for part in found}
    assert not any("hose B" in part.name for part in found)
    assert overlaps(found) == []


@pytest.mark.parametrize(("machine", "joint", "height"), [
    ("paper-small-joint", "small", 180.0), ("paper-large-joint", "large", 250.0)])  # fmt: skip
def test_heights_are_those_of_the_paper_within_a_tenth(machine: str, joint: str, height: float) -> None:
    parts = joint_components(sizes_of(machine, joint))
    heights = np.array([box(placed(cad.solid(part.shape), at))[:, 2] for part in parts for at in part.places])
    assert np.ptp(heights) == pytest.approx(height, rel=0.1)


@pytest.mark.parametrize(("machine", "joint"), BUILT)
def test_the_strap_leaves_the_shell_at_the_laws_strap_point_and_touches_the_cam(machine: str, joint: str) -> None:
    sizes = sizes_of(machine, joint)
    section, cam = CrossSection(sizes), sizes.design.with_cam()
    assert section.strap_miss < 0.1
    for k in (0, 200, 400, 600):
        turn = float(cam.angle[k])
        path = section.strap_path(turn)
        foot = section.foot(turn)
        at = int(np.hypot(*(path - foot).T).argmin())
        way = (path[at] - path[at - 1]) / np.hypot(*(path[at] - path[at - 1]))
        normal = np.array([-way[1], way[0]])
        assert abs(float((np.array(strap_point(sizes, turn)) - path[at]) @ normal)) < 0.1
        lever = abs(float((foot - [0.0, sizes.axis]) @ normal))
        assert lever == pytest.approx(cam.lever[k] * MM, abs=0.1)


def test_the_shell_opens_as_far_as_the_hose_travels() -> None:
    sizes = sizes_of("paper-small-joint", "small")
    cam = sizes.design.with_cam()
    assert opening(sizes, 0.0) == 0.0
    assert opening(sizes, cam.stroke) * sizes.line.chord == pytest.approx(cam.travel[-1])


@pytest.mark.parametrize("machine", ["paper-small-joint", "paper-large-joint", ""])
def test_the_hinge_goes_round_the_shells_edge_without_a_cut(machine: str) -> None:
    strong = SizingRequest(torque="88 N m", stroke="128 deg", supply="3.5 bar")
    sizes = sizes_of(machine, machine.split("-")[1]) if machine else JointSizes(size_joint(strong).design)
    section, hinge = CrossSection(sizes), np.array(sizes.line.hinge) * MM
    for turn in np.linspace(0.0, sizes.stroke, 9):
        angle = opening(sizes, float(turn))
        back = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        shell = hinge + (section.shell().points() - hinge) @ back
        assert not Path(section.webbing(float(turn)).points()).contains_points(shell).any()


def test_a_hose_gains_about_the_volume_that_its_law_sweeps() -> None:
    """Eq. (1) peels off along the wrap and the solid does not: they agree within a quarter."""
    sizes = sizes_of("paper-small-joint", "small")
    section, law = CrossSection(sizes), sizes.joint.geometry
    full, flat = (integrals(cad.solid(Lofted(section.hose(turn)))).volume for turn in (sizes.stroke, 0.0))
    assert (full - flat) / MM**3 == pytest.approx(law.volume, rel=0.25)


def test_a_strap_over_a_roller_is_refused_in_one_line() -> None:
    with pytest.raises(DesignError, match=r"no solids of a joint whose strap is deflected; give output\.shaft_offset"):
        joint_components(joint_sizes(load("rig-shell-steel"), "small"))


def test_given_sizes_take_the_place_of_rules() -> None:
    sizes = sizes_of("paper-small-joint", "small")
    build = Build(end_plate_thickness="12 mm", screw="M6", shaft_diameter="12 mm")
    joint = sizes.joint.model_copy(update={"build": build})
    machine = load("paper-small-joint")
    changed = machine.model_copy(update={"joint": {**machine.joint, "small": joint}})
    own = joint_sizes(changed, "small")
    assert (own.end_plate, own.screw.name, own.shaft) == (12.0, "M6", 12.0)
    assert len(joint_components(own)) == len(joint_components(sizes))


@pytest.mark.parametrize("machine", ["paper-arm", "picking-arm", "single-joint-lift"])
def test_inlets_take_the_tubes_of_the_list_or_the_widest_that_fit(machine: str) -> None:
    described = load(machine)
    rows = {row.end: row for row in list_tubes(described)}
    for number, joint in enumerate(described.joints, start=1):
        inlet, tube = choose_inlet(sizes_of(machine, joint)), rows[f"{number}A1"]
        assert tube.bore is not None
        assert inlet.bore == pytest.approx(tube.bore, rel=0.1) or inlet.bore < tube.bore
        if joint != "wrist":
            assert inlet.bore == pytest.approx(tube.bore, rel=0.1)
