"""Screws that a driver or a key reaches, or does not."""

from dataclasses import replace

import pytest

from layflat import extras
from layflat.solids.checks.meshes import MeshStore
from layflat.solids.checks.reach import reach_findings
from layflat.solids.component import Component
from layflat.solids.hardware import socket_screw
from layflat.solids.loops import rectangle
from layflat.solids.shapes import Prism, place
from layflat.solids.standard.screws import screw
from tests.solids.checks.builds import built

pytestmark = pytest.mark.skipif(not extras.available("cad"), reason="no extra cad; pip install layflat[cad]")


def severities(height: float, *, after: bool = False) -> list[str]:
    """Return the severities of the findings about an M5 screw with a wall above its head at a height, mm."""
    wall = Component("wall", "body", Prism(rectangle(40.0, 40.0), 2.0), "aluminium", "milling", (place(z=height),),
                     joint="small")  # fmt: skip
    fixed = replace(socket_screw("screw", "body", screw("M5", 20e-3), (place(),)), joint="small")
    parts = (fixed, wall) if after else (wall, fixed)
    return [one.severity for one in reach_findings(replace(built(), components=parts), MeshStore())]


def test_a_wall_in_the_way_of_the_driver_leaves_the_key_or_nothing() -> None:
    assert severities(75.0) == []
    assert severities(45.0) == ["note"]
    assert severities(15.0) == ["warning"]


def test_a_wall_that_is_mounted_later_is_not_in_the_way() -> None:
    assert severities(15.0, after=True) == []
