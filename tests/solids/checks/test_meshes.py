"""Distances of triangles against closed forms and the CAD kernel's own distances."""

import numpy as np
import pytest

from layflat import extras
from layflat.solids import cad
from layflat.solids.checks.meshes import (
    CHORD_TOLERANCE,
    MeshStore,
    PartMesh,
    box_gaps,
    enclosing_triangles,
    least_distance,
    segment_distances,
)
from layflat.solids.checks.meshes import triangle_distances as distances
from layflat.solids.component import Component, axes_towards
from layflat.solids.hardware import rod, sleeve
from layflat.solids.kernel import placed
from layflat.solids.loops import rectangle
from layflat.solids.shapes import Drilled, Lofted, PartPlace, Prism, Shape
from tests.solids.bodies import body_of

FLAT = np.array([[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]])


def test_triangles_above_across_and_through_each_other() -> None:
    upright = np.array([[[1.0, 1.0, 2.0], [1.0, 1.0, 5.0], [2.0, 1.0, 5.0]]])
    assert distances(FLAT, upright) == pytest.approx([2.0])
    assert distances(FLAT, FLAT + np.array([10.0, 0.0, 0.0])) == pytest.approx([6.0])
    assert distances(FLAT, upright - np.array([0.0, 0.0, 3.0])) == pytest.approx([0.0])
    assert distances(upright, FLAT) == pytest.approx([2.0])


def test_segments_that_are_skew_parallel_or_points() -> None:
    one = np.array([[0.0, 0.0, 0.0]]), np.array([[2.0, 0.0, 0.0]])
    cases = [((1.0, -1.0, 3.0), (1.0, 1.0, 3.0), 3.0), ((0.5, 2.0, 0.0), (5.0, 2.0, 0.0), 2.0),
             ((5.0, 4.0, 0.0), (5.0, 4.0, 0.0), 5.0)]  # fmt: skip
    for start, end, distance in cases:
        assert segment_distances(*one, np.array([start]), np.array([end])) == pytest.approx([distance])


@pytest.mark.skipif(not extras.available("cad"), reason="no extra cad; pip install layflat[cad]")
def test_distances_are_those_of_the_kernel_within_the_tolerance_of_the_triangles() -> None:
    random, store = np.random.default_rng(3), MeshStore()
    shapes: list[Shape] = [rod(8.0, 20.0), Prism(rectangle(10.0, 6.0), 14.0), sleeve(12.0, 8.0, 5.0)]
    near = 0
    for _ in range(40):
        first, second = (
            Component("part", "body", shapes[k], "steel", "turning", (
                PartPlace(axes_towards(*random.normal(size=3)), random.uniform(-12.0, 12.0, 3)),))
            for k in random.integers(0, 3, 2)
        )  # fmt: skip
        bodies = [body_of(placed(cad.solid(one.shape), one.places[0])) for one in (first, second)]
        true = float(bodies[0].distance_to(bodies[1]))
        inside = true == 0.0
        found = least_distance(store.parts([first])[0], store.parts([second])[0], 5.0)
        near += 0.0 < true < 4.8
        if not inside and true < 4.8:
            assert abs(found - true) <= 2 * CHORD_TOLERANCE
        if true > 5.0:
            assert found == np.inf
    assert near > 5


def test_gaps_of_boxes_are_the_largest_over_the_axes() -> None:
    part = Component("part", "body", rod(1.0, 1.0), "steel", "turning", ())
    first, second = PartMesh(part, lambda: FLAT), PartMesh(part, lambda: FLAT + np.array([7.0, 1.0, 2.0]))
    assert box_gaps([first], [second]) == pytest.approx(np.array([[3.0]]))


def bent_band(random: np.random.Generator) -> Lofted:
    """Return a band through twisted sections with a hole in it."""
    sections = []
    for k in range(5):
        turn, lean = 0.3 * k + random.uniform(0.0, 0.2), random.uniform(-0.3, 0.3)
        flat = [(-6.0, -1.0), (6.0, -1.0), (7.0, 0.0), (6.0, 1.0), (-6.0, 1.0)]
        radius = [30.0 + z * np.cos(lean) + x * np.sin(lean) for x, z in flat]
        sections.append(tuple(
            (float(r * np.cos(turn)), float(r * np.sin(turn)), x) for (x, _), r in zip(flat, radius, strict=True)
        ))  # fmt: skip
    return Lofted(tuple(sections), (Drilled((40.0, 12.0, 0.0), (-1.0, 0.0, 0.0), 3.0, 30.0),))


@pytest.mark.skipif(not extras.available("cad"), reason="no extra cad; pip install layflat[cad]")
def test_what_encloses_a_band_drops_no_part_that_is_near_it() -> None:
    random, store = np.random.default_rng(8), MeshStore()
    near = dropped = 0
    for _ in range(6):
        band = Component("band", "body", bent_band(random), "hose", "cutting", (
            PartPlace(axes_towards(*random.normal(size=3)), random.uniform(-5.0, 5.0, 3)),))  # fmt: skip
        mesh = store.parts([band])[0]
        assert mesh.outer is not None
        low, high = mesh.box
        assert (mesh.triangles >= low).all()
        assert (mesh.triangles <= high).all()
        for _ in range(25):
            at = PartPlace(axes_towards(*random.normal(size=3)), random.uniform(low, high))
            ball = store.parts([Component("rod", "body", rod(3.0, 9.0), "steel", "turning", (at,))])[0]
            alone = PartMesh(band, lambda mesh=mesh: mesh.triangles)  # type: ignore[misc]
            true, reach = least_distance(alone, ball, 30.0), random.uniform(0.1, 4.0)
            found = least_distance(mesh, ball, reach)
            assert found == (true if true <= reach else np.inf)
            around = least_distance(mesh.outer, ball, 30.0)
            assert around <= true + 1e-3
            near += true <= reach
            dropped += around > reach
    assert near > 20
    assert dropped > 20


def test_what_encloses_a_band_is_closed_and_takes_no_kernel(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(extras, "_is_installed", lambda module: module != "OCP")
    band = bent_band(np.random.default_rng(2))
    sections = np.array(band.sections)
    corners = {tuple(point) for point in enclosing_triangles(band).reshape(-1, 3)}
    assert corners == {tuple(point) for point in sections.reshape(-1, 3)}


@pytest.mark.skipif(not extras.available("cad"), reason="no extra cad; pip install layflat[cad]")
def test_solids_of_bands_are_made_only_where_something_is_near() -> None:
    made: list[Shape] = []

    def solid(shape: Shape) -> object:
        made.append(shape)
        return cad.solid(shape)

    store, band = MeshStore(solid), bent_band(np.random.default_rng(4))
    place = PartPlace(np.eye(3), np.zeros(3))
    hose = store.parts([Component("band", "body", band, "hose", "cutting", (place,))])[0]
    for origin, expected in ((60.0, 0), (30.0, 1)):
        pin = PartPlace(np.eye(3), np.array([origin, 3.0, 0.0]))
        part = store.parts([Component("rod", "body", rod(3.0, 9.0), "steel", "turning", (pin,))])[0]
        distance = least_distance(hose, part, 2.0)
        assert (distance == np.inf) is (expected == 0)
        assert sum(isinstance(shape, Lofted) for shape in made) == expected
