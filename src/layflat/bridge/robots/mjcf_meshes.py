"""Meshes of an MJCF: the file where it has the mesh as MuJoCo draws it, else the mesh as MuJoCo has it."""

from pathlib import Path
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.bridge.meshes import binary_stl, is_binary_stl, stl_triangles
from layflat.bridge.robots.robot import Look, Pose

CLOSE = 1e-4  # by which corners may differ, as a share of a mesh's size: MuJoCo has them in single precision
MAX_CORNERS = 300  # that are compared


def mesh_look(spec: Any, model: Any, file: Path, geom: Pose, mesh: int, inner: Pose) -> Look:
    """Return the mesh of a geom in the frame of its file, with its scale, where the file has it so; else as it is.

    A default, a frame with a scale, a reference pose or another file of the name may stand between a file and what
    MuJoCo draws. So the corners of both are compared.

    Args:
        spec: the model's specification.
        model: the compiled model.
        file: of the model.
        geom: pose of the geom in its body.
        mesh: index of the mesh in the model.
        inner: pose of the compiled mesh in the frame of its file.
    """
    first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
    corners = model.mesh_vert[first : first + count].astype(float)
    named = model.mesh(mesh).name
    described = spec.mesh(named)
    if described is not None and described.file:
        path = file.parent / spec.meshdir / described.file
        scale: tuple[float, float, float] = tuple(map(float, described.scale))  # type: ignore[assignment]
        in_file = _corners(path)
        if in_file is not None and _are_among(corners @ inner.axes.T + inner.place, in_file * np.array(scale)):
            return Look("mesh", geom.then(inner.back()), file=path, scale=scale)
    faces = model.mesh_face[model.mesh_faceadr[mesh] : model.mesh_faceadr[mesh] + model.mesh_facenum[mesh]]
    return Look("mesh", geom, file=Path(f"{named or f'mesh-{mesh}'}.stl"), content=binary_stl(corners[faces]))


def _corners(path: Path) -> Array | None:
    """Return the corners (n, 3) in a binary STL or an OBJ, in its own unit; None where it can't be read."""
    try:
        content = path.read_bytes()
        if path.suffix.lower() == ".stl" and is_binary_stl(content):
            return stl_triangles(content).reshape(-1, 3)
        if path.suffix.lower() == ".obj":
            lines = [line.split()[1:4] for line in content.splitlines() if line.startswith((b"v ", b"v\t"))]
            return np.array(lines, float).reshape(-1, 3) if lines else None
    except (OSError, ValueError):
        return None
    return None


def _are_among(corners: Array, others: Array) -> bool:
    """Return whether corners (n, 3) are where some of others are, and the others reach no further."""
    from scipy.spatial import cKDTree  # noqa: PLC0415  # SciPy takes long to import

    room = CLOSE * float(np.ptp(others, axis=0).max())
    same_box = np.allclose(corners.min(axis=0), others.min(axis=0), rtol=0.0, atol=room) and np.allclose(
        corners.max(axis=0), others.max(axis=0), rtol=0.0, atol=room
    )
    if not same_box:
        return False
    distances, _ = cKDTree(others).query(corners[:: max(len(corners) // MAX_CORNERS, 1)])
    return bool(np.max(distances) <= room)
