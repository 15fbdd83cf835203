#!/usr/bin/env bash
# build123d 0.13.0: export_gltf() puts a moved part in a wrong place, and gives parts of one shape one colour.
#
# glTF has Y up, CAD has Z up, so the exporter turns the part by 90 degrees; but it turns the part about its own origin,
# not about that of the world, so that a part whose location is not zero lands elsewhere, in silence: a box 100 mm up lies
# 100 mm in front. Children of a compound at the origin are right; a compound that was moved is not.
# And two children that share their geometry (moved() copies, as instances are made) and have colours of their own, red and
# blue, get one material: the colour of the last one. export_step() keeps both colours.
#
# Output seen: "box 100 mm up: y from 0.0 mm, z from 80.0 mm (right: 100, -20); colours of red and blue: [[0.0, 0.0, 1.0]]";
# 2026-11-29, Python 3.11. Exits with 1 if the behaviour has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q --disable-pip-version-check build123d==0.13.0 trimesh==5.2.0
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import json
import struct
import sys
from pathlib import Path

import build123d as cad
import trimesh

box = cad.Solid.make_box(10, 20, 30)
cad.export_gltf(box.moved(cad.Location((0, 0, 100))), "moved.glb", binary=True)
low = trimesh.load("moved.glb").bounds[0] * 1000

red, blue = box.moved(cad.Location((0, 0, 100))), box.moved(cad.Location((0, 0, 200)))
red.color, blue.color = cad.Color(1, 0, 0), cad.Color(0, 0, 1)
cad.export_gltf(cad.Compound(children=[red, blue]), "two.glb", binary=True)
data = Path("two.glb").read_bytes()
content = json.loads(data[20 : 20 + struct.unpack_from("<I", data, 12)[0]])
colours = [one["pbrMetallicRoughness"]["baseColorFactor"][:3] for one in content["materials"]]
print(f"box 100 mm up: y from {low[1]:.1f} mm, z from {low[2]:.1f} mm (right: 100, -20); colours of red and blue: {colours}")
right = abs(low[1]) < 0.01 and abs(low[2] - 80) < 0.01 and colours == [[0.0, 0.0, 1.0]]
sys.exit(0 if right else 1)
PYTHON
