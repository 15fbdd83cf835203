"""Contours: DXF files read back, by ezdxf and by LibreCAD, have the areas and holes of the parts."""

from __future__ import annotations

import os
import shutil
import subprocess
from io import StringIO
from typing import TYPE_CHECKING, Any

import ezdxf
import numpy as np
import pytest
from ezdxf import path as outlines
from ezdxf.filemanagement import new, read

from layflat.solids.drawings.contours import as_circle, contour_text
from layflat.solids.drawings.flat import FlatPart, cut_by_contour, flat_part
from layflat.solids.loops import HullCircle, circle, hull, polygon, rectangle, sector
from layflat.solids.shapes import Hole, Prism
from tests.programs import skip_without
from tests.solids.drawings.parts import component, made_parts

if TYPE_CHECKING:
    from pathlib import Path

    from layflat.solids.loops import Loop

PARTS = [one for joint in ("small", "large") for one in made_parts(joint) if cut_by_contour(one, flat_part(one))]
LOOPS = {
    "circle": circle(3, 4, 20),
    "rectangle": rectangle(30, 20),
    "triangle": polygon([(0, 0), (20, 0), (0, 15)]),
    "ring sector": sector(20, 30, 0.3, 4.5),
    "hull": hull([HullCircle(0, 0, 20), HullCircle(40, 5, 8), HullCircle(10, 40, 5)]),
}


def read_back(part: FlatPart) -> Any:
    """Return the document of a part's file; the audit must find nothing."""
    document = read(StringIO(contour_text(part, "part")))
    audit = document.audit()
    assert not audit.errors
    assert not audit.fixes
    return document


def enclosed_area(document: Any) -> float:
    """Return the area that the entities of the layer OUTLINE enclose, joined by their ends."""
    pieces = [outlines.make_path(one) for one in document.modelspace().query('*[layer=="OUTLINE"]')]
    points: list[Any] = []
    for piece in pieces:
        flat = [(p.x, p.y) for p in piece.flattening(1e-4)]
        if points and np.hypot(*np.subtract(points[-1], flat[0])) > 1e-6:
            raise AssertionError("the outline is open")
        points += flat
    x, y = np.array(points).T
    return abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1))) / 2


@pytest.mark.parametrize("loop", LOOPS.values(), ids=LOOPS)
def test_contours_have_true_arcs(loop: Loop) -> None:
    part = flat_part(component(Prism(loop, 5.0)))
    assert part is not None
    document = read_back(part)
    assert document.units == ezdxf.units.MM
    # Loops count arcs by chords of 5 degrees, below the true area by up to 0.13 %; ezdxf's curves lie 0.03 % above it.
    assert -1e-9 <= enclosed_area(document) / loop.area - 1 < 1.6e-3


def test_a_round_outline_is_a_circle() -> None:
    part = flat_part(component(Prism(circle(3, 4, 20), 5.0)))
    assert part is not None
    (found,) = read_back(part).modelspace().query('*[layer=="OUTLINE"]')
    assert (found.dxftype(), found.dxf.radius) == ("CIRCLE", pytest.approx(20))
    assert as_circle(circle(3, 4, 20)) == pytest.approx(HullCircle(3, 4, 20))


@pytest.mark.parametrize("one", PARTS, ids=[f"{k}-{one.name}" for k, one in enumerate(PARTS)])
def test_contours_of_a_joint_have_area_holes_and_bends_of_their_parts(one: Any) -> None:
    part = flat_part(one)
    assert part is not None
    document = read_back(part)
    space = document.modelspace()
    assert enclosed_area(document) == pytest.approx(part.outline.area, rel=2e-3)
    holes = [(*tuple(hole.dxf.center)[:2], 2 * hole.dxf.radius) for hole in space.query('CIRCLE[layer=="HOLES"]')]
    assert np.array(holes) == pytest.approx(np.array([(*hole.centre, hole.diameter) for hole in part.holes]))
    texts = [text.dxf.text for text in space.query('TEXT[layer=="NOTES"]')]
    assert all(str(number) in texts for number in range(1, len(part.holes) + 1))
    assert len(space.query('LINE[layer=="BEND"]')) == len({x for bend in part.bends for x in bend[:2]})
    assert {entity.dxf.layer for entity in space} <= {"OUTLINE", "HOLES", "BEND", "NOTES"}


def test_threads_stand_in_the_hole_table() -> None:
    part = flat_part(component(Prism(rectangle(40, 30), 6.0, (Hole((5.0, 5.0), 4.2, "M5"), Hole((-5.0, 5.0), 5.5)))))
    assert part is not None
    texts = [text.dxf.text for text in read_back(part).modelspace().query("TEXT")]
    assert texts.count("M5") == 1
    assert "5.5" in texts


def test_librecad_draws_a_contour(tmp_path: Path) -> None:
    if shutil.which("librecad") is None:
        skip_without("LibreCAD")
    part = flat_part(next(one for one in PARTS if one.name == "cam of hose A"))
    assert part is not None
    sizes = []
    for name, text in (("part", contour_text(part, "part")), ("empty", _empty())):
        (tmp_path / f"{name}.dxf").write_text(text, encoding="utf-8")
        command = ["librecad", "dxf2pdf", "-a", f"{name}.dxf"]
        home = {**os.environ, "QT_QPA_PLATFORM": "offscreen", "HOME": str(tmp_path), "XDG_CONFIG_HOME": str(tmp_path)}
        subprocess.run(command, cwd=tmp_path, check=True, timeout=60, capture_output=True, env=home)
        sizes.append((tmp_path / f"{name}.pdf").stat().st_size)
    assert sizes[0] > 3 * sizes[1]


def _empty() -> str:
    stream = StringIO()
    new("R2010").write(stream)
    return stream.getvalue()
