"""Volumes and lowest points without a CAD kernel are those of solids."""

from math import pi

import pytest

from layflat import extras
from layflat.machine import load
from layflat.solids import cad
from layflat.solids.assembly import Assembly, assemble
from layflat.solids.joint import joint_components
from layflat.solids.kernel import box, placed
from layflat.solids.loops import circle, polygon, rectangle
from layflat.solids.shapes import ALONG_X, Drilled, Hole, Lofted, PartPlace, Prism, Shape, Turned, joined, place
from layflat.solids.volumes import lowest, mass_of, volume
from tests.solids.joints import components_of, sizes_of

with_solids = pytest.mark.skipif(not extras.available("cad"), reason="no extra cad; pip install layflat[cad]")

CUBE = Prism(rectangle(10.0, 10.0), 10.0)
THROUGH = Drilled((0.0, 0.0, -5.0), (0.0, 0.0, 1.0), 4.0, 50.0)
ACROSS = Drilled((-9.0, 0.0, 5.0), (1.0, 0.0, 0.0), 4.0, 40.0)
STEINMETZ = 16 / 3 * 2.0**3  # what two crossed cylinders of radius 2 have in common, mm3


def triangle(z: float, side: float) -> tuple[tuple[float, float, float], ...]:
    return (0.0, 0.0, z), (side, 0.0, z), (0.0, side, z)


@pytest.mark.parametrize(
    ("shape", "expected", "within"),
    [
        (Prism(circle(3.0, 4.0, 10.0), 2.0), 200 * pi, 1e-4),
        (Prism(rectangle(8.0, 9.0), 2.0, (Hole((1.0, 0.0), 3.0),), (rectangle(2.0, 1.0, (-2.0, 0.0)),)),
         2 * (72 - 9 * pi / 4 - 2), 1e-4),
        (Turned(rectangle(2.0, 7.0, (5.0, 1.0))), 2 * pi * 5 * 14, 1e-9),
        (Turned(polygon([(0.0, 0.0), (3.0, 0.0), (0.0, 5.0)])), 15 * pi, 1e-9),
        (Prism(rectangle(10.0, 10.0), 10.0, drilled=(THROUGH,)), 1000 - 40 * pi, 1e-3),
        (Prism(rectangle(10.0, 10.0), 10.0, drilled=(THROUGH, ACROSS)), 1000 - 80 * pi + STEINMETZ, 1e-3),
        (Prism(rectangle(10.0, 10.0), 10.0, pockets=((circle(5.0, 0.0, 4.0), 7.0, 30.0),)), 1000 - 24 * pi, 1e-4),
        (Turned(rectangle(10.0, 6.0, (5.0, 3.0)), (Drilled((20.0, 0.0, 3.0), (-1.0, 0.0, 0.0), 1e-3, 15.0),)),
         600 * pi, 1e-6),
        (Lofted((triangle(0.0, 2.0), triangle(3.0, 4.0))), 2 + 4 + 8, 1e-9),
        (joined((CUBE, place()), (CUBE, place(z=10.0))), 2000.0, 1e-9),
    ],
)  # fmt: skip
def test_volumes_of_simple_shapes_are_those_of_geometry(shape: Shape, expected: float, within: float) -> None:
    assert volume(shape) == pytest.approx(expected, rel=within)


def test_the_lowest_point_of_simple_shapes() -> None:
    lying = PartPlace(ALONG_X, place(z=20.0).origin)
    assert lowest(Turned(rectangle(3.0, 8.0, (1.5, 4.0))), lying) == pytest.approx(17.0)
    assert lowest(CUBE, place(z=2.0)) == pytest.approx(2.0)
    assert lowest(CUBE, lying) == pytest.approx(15.0)
    assert lowest(joined((CUBE, place(z=-4.0)), (CUBE, place())), place(z=1.0)) == pytest.approx(-3.0)


def made_assembly(name: str) -> Assembly:
    return assemble(load(name))


@with_solids
@pytest.mark.parametrize("name", ["paper-small-joint", "paper-large-joint"])
def test_volumes_of_all_parts_are_those_of_their_solids(name: str) -> None:
    assembly = made_assembly(name)
    wrong = {
        part.name: (volume(part.shape), assembly.integrals(part.shape).volume)
        for part in assembly.components
        if volume(part.shape) != pytest.approx(assembly.integrals(part.shape).volume, rel=5e-3)
    }
    assert wrong == {}
    whole = sum(part.quantity * assembly.mass_of(part) for part in assembly.components)
    assert sum(part.quantity * mass_of(part) for part in assembly.components) == pytest.approx(whole, rel=1e-3)


@with_solids
def test_the_lowest_point_of_a_joint_is_that_of_its_solids() -> None:
    sizes = sizes_of("paper-small-joint", "small")
    for angle in (0.0, 0.4 * sizes.stroke):
        parts = joint_components(sizes, angle)
        heights = [box(placed(cad.solid(part.shape), at))[0, 2] for part in parts for at in part.places]
        found = min(lowest(part.shape, at) for part in parts for at in part.places)
        assert found == pytest.approx(min(heights), abs=1e-3)


def test_an_assembly_needs_no_kernel(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(extras, "_is_installed", lambda _module: False)
    assembly = made_assembly("paper-small-joint")
    assert sum(part.quantity * mass_of(part) for part in assembly.components) > 1.0
    assert components_of("paper-arm", "small")
