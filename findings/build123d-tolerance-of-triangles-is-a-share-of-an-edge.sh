#!/usr/bin/env bash
# build123d 0.13.0: the tolerance of `tessellate` and `export_stl` is no length, but a share of the length of each edge.
#
# The parameter is documented as a tolerance, and lengths are in mm. The kernel's mesher is called as relative, though:
# each edge gets the tolerance times its own size. A disc of 100 mm in triangles "within 0.05" lies up to 1.1 mm inside
# the true one (a wide angular tolerance leaves it to the linear one); one of 2 mm lies 0.02 mm inside.
# A good engineer takes the number for a distance, as in the kernel's own default (`isRelative = false`), and measures
# clearances or exports prints that are wrong by twenty times the tolerance. Calling the mesher first, as absolute, mends
# it: `tessellate` keeps triangles that are there.
# Run on 2026-11-29, Python 3.11. Exits with 1 if the behaviour has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q --disable-pip-version-check build123d==0.13.0
cd "$folder"
venv/bin/python - <<'PYTHON'
import sys
from math import atan2, cos, hypot, pi

from build123d import Solid
from OCP.BRepMesh import BRepMesh_IncrementalMesh

TOLERANCE, ANGLE = 0.05, 1.5  # mm, rad


def sag(radius, *, absolute=False):
    """Greatest distance of the rim's chords from the circle, by the greatest angle between its points."""
    disc = Solid.make_cylinder(radius, 1.0)
    if absolute:
        BRepMesh_IncrementalMesh(disc.wrapped, TOLERANCE, False, ANGLE, False)
    points, _ = disc.tessellate(TOLERANCE, ANGLE)
    angles = sorted({round(atan2(p.Y, p.X), 9) for p in points if hypot(p.X, p.Y) > 0.99 * radius})
    gaps = [b - a for a, b in zip(angles, [*angles[1:], angles[0] + 2 * pi])]
    return radius * (1 - cos(max(gaps) / 2))


large, small, mended = sag(50.0), sag(1.0), sag(50.0, absolute=True)
print(f"triangles within {TOLERANCE}: {large:.2f} mm inside a disc of 100 mm, {small:.3f} mm inside one of 2 mm")
print(f"meshed as absolute before: {mended:.3f} mm")
sys.exit(0 if large > 10 * TOLERANCE and mended <= TOLERANCE else 1)
PYTHON
