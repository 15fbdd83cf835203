"""Outputs turn freely inside their frames, whose parts lie beside what moves."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from layflat.design import JointDesign, SizingRequest, design_joint, size_joint
from layflat.design.straplines import direction_vector
from layflat.machine import changed
from layflat.machine.parts import Calliper
from layflat.solids.brake import CYLINDER_HEIGHT, HUB_GAP
from layflat.solids.cams import CLAMP_SCREW, cam_loop, flat
from layflat.solids.joint import joint_components
from layflat.solids.links import arm_seats, strut_components
from layflat.solids.output import link_holes
from layflat.solids.places import stop_places, stop_radius
from layflat.solids.section import STRIP_THICKNESS, CrossSection
from layflat.solids.shapes import Joined, Prism, Turned
from layflat.solids.sizes import MM, JointSizes
from layflat.solids.standard.screws import screw_for


def sized(torque: str, stroke: str, supply: str) -> JointDesign:
    return size_joint(SizingRequest(torque=torque, stroke=stroke, supply=supply)).design


def with_key(design: JointDesign, table: str, key: str, value: object) -> JointDesign:
    """A design with one key of the joint changed."""
    return design_joint(changed(design.machine, f"joint.{design.name}.{table}.{key}", value), design.name)


def test_holes_for_a_link_lie_beyond_straps_that_cross_the_arm() -> None:
    """The cam of a short stroke is long: its strap passes where the link would be screwed on."""
    long = JointSizes(with_key(sized("25.35 N m", "60.17 deg", "5.64 bar"), "output", "shaft_offset", 0.022))
    section, holes = CrossSection(long), np.array([[0.0, at] for at in link_holes(long)])
    for angle in np.linspace(-long.swing, long.swing, 41):
        c, s = np.cos(angle), np.sin(angle)
        points = holes @ np.array([[c, s], [-s, c]]) + [0.0, long.axis]
        path = section.strap_path(long.stroke / 2 + float(angle))
        fine = np.vstack([np.linspace(a, b, 50) for a, b in pairwise(path)])
        nearest = np.hypot(*(fine[:, None] - points).T).min(axis=1)
        assert (nearest > np.array([1.0, 1.1, 1.0]) * long.screw.nut_flats * MM / 2).all()


@pytest.mark.parametrize("offset", [0.018, 0.022, 0.026])
def test_bump_stops_lie_beside_the_cylinder_and_meet_the_arm_at_the_mechanical_limit(offset: float) -> None:
    sizes = JointSizes(with_key(sized("25.35 N m", "60.17 deg", "5.64 bar"), "output", "shaft_offset", offset))
    (_, stop), radius = stop_places(sizes), stop_radius(sizes)
    away = float(np.hypot(*stop))
    assert away + radius < sizes.inner_radius or away - radius > sizes.radius
    along = np.array([np.sin(sizes.swing), np.cos(sizes.swing)])
    x, y = np.array(stop) - [0.0, sizes.axis]
    assert abs(x * along[1] - y * along[0]) == pytest.approx(sizes.arm_width / 2 + radius)


def test_small_cylinders_have_small_screws() -> None:
    small, large = (JointSizes(sized(torque, "70 deg", "3.8 bar")) for torque in ("2.5 N m", "5 N m"))
    assert (small.screw.name, small.rod.name, large.screw.name) == ("M2.5", "M2.5", "M3")
    assert any("M2.5" in part.designation for part in joint_components(small))


def test_small_cylinders_have_small_inlets() -> None:
    found = joint_components(JointSizes(sized("7.3 N m", "115 deg", "3.2 bar")))
    assert any("inlet" in part.name for part in found)


def test_screws_of_a_straps_clamp_end_inside_the_thin_cam_of_a_short_stroke() -> None:
    sizes = JointSizes(sized("17.5 N m", "63 deg", "6 bar"))
    (x, y), normal = flat(sizes)
    screw = screw_for((STRIP_THICKNESS + sizes.strap_thickness) / MM, CLAMP_SCREW.name)
    reach, outward = screw.length * MM - STRIP_THICKNESS - sizes.strap_thickness, direction_vector(normal)
    corners = cam_loop(sizes).points()
    sides = np.roll(corners, -1, axis=0) - corners
    for aside in (-CLAMP_SCREW.diameter, CLAMP_SCREW.diameter):
        apart = [x, y] - reach * outward + aside / 2 * MM * direction_vector(normal + np.pi / 2) - corners
        inside = sides[:, 0] * apart[:, 1] - sides[:, 1] * apart[:, 0]
        assert (inside > 0).all() or (inside < 0).all()


def test_a_strap_lies_on_its_roller_before_the_stroke_too() -> None:
    sizes = JointSizes(with_key(sized("31.8 N m", "60 deg", "2.4 bar"), "output", "kind", "roller"))
    path = CrossSection(sizes).strap_path(-0.17) - [0.0, sizes.axis]
    fine = np.vstack([np.linspace(a, b, 50) for a, b in pairwise(path)])
    assert np.hypot(*fine.T).min() > sizes.joint.output.radius * MM - 0.1


def test_the_cylinder_of_a_calliper_lies_beside_the_shaft() -> None:
    calliper = Calliper(released_fraction=0.1, stroke_time="50 ms")
    roller = with_key(sized("31.8 N m", "60 deg", "2.4 bar"), "output", "kind", "roller")
    sizes = JointSizes(with_key(roller, "brake", "calliper", calliper))
    parts = {part.name: part for part in joint_components(sizes)}
    cylinder, end = parts["brake cylinder"], parts["shaft"].places[0].origin
    (at,) = cylinder.places
    assert isinstance(cylinder.shape, Turned)
    radius = cylinder.shape.outline.points()[:, 0].max()
    beside = np.hypot(*(at.origin - end)[:2]) - radius - sizes.shaft / 2
    assert max(beside, end[2] - at.origin[2] - CYLINDER_HEIGHT) >= HUB_GAP - 1e-9


def test_the_eye_of_a_long_link_passes_through_the_cylinders_window() -> None:
    sizes = JointSizes(sized("13 N m", "120 deg", "3.3 bar"))
    seat = arm_seats(sizes, outer=True)[0]
    ahead = np.array([0.0, 900.0, 0.0])
    (strut, *_) = strut_components(
        sizes, [(seat, replace(seat, near=seat.far + ahead, far=seat.near + ahead, tie=False))]
    )
    assert isinstance(strut.shape, Joined)
    (eye, at), *_ = strut.shape.placed()
    assert isinstance(eye, Prism)
    width = float(np.ptp(eye.outline.points()[:, 1]))
    corners = eye.outline.points()
    edge = np.vstack([np.linspace(a, b, 50) for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)])
    placed = (np.pad(edge, ((0, 0), (0, 1))) @ at.axes.T + at.origin)[:, :2]
    c, s = np.cos(sizes.swing), np.sin(sizes.swing)
    x, y = (placed @ np.array([[c, -s], [s, c]]) + [0.0, sizes.axis]).T
    met = (np.arctan2(y, x) < np.pi - CrossSection(sizes).window_end) & (np.hypot(x, y) < sizes.radius)
    assert width > sizes.arm_width
    assert not met.any()
