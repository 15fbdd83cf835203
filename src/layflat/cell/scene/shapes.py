"""Geoms of a MuJoCo spec in one line each."""

from typing import Any, Literal

from layflat.cell.extras import mujoco

UNTOUCHED = {"contype": 0, "conaffinity": 0}  # of what is seen and touches nothing


def add(body: Any, kind: Literal["box", "cylinder", "capsule", "ellipsoid", "mesh"], name: str, **others: Any) -> None:
    """Add a geom to a body; lengths in m, `size` may be shorter than MuJoCo's three."""
    if "size" in others:
        others["size"] = [*others["size"], 0.0, 0.0][:3]
    body.add_geom(name=name, type=getattr(mujoco().mjtGeom, f"mjGEOM_{kind.upper()}"), **others)
