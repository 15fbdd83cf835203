"""Meshes for tests: a wedge with corners at 0 and one metre along each axis."""

import struct
from pathlib import Path

import numpy as np

CORNERS = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
FACES = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))


def write_wedge(path: Path) -> Path:
    """Write it as OBJ, DAE, or STL, binary or (named "*-text.stl") as text."""
    path.parent.mkdir(parents=True, exist_ok=True)
    writers = {".obj": _obj, ".dae": _dae, ".stl": _text_stl if path.stem.endswith("-text") else _stl}
    path.write_bytes(writers[path.suffix]())
    return path


def _stl() -> bytes:
    triangles = [np.array([[0.0, 0.0, 0.0], *(CORNERS[i] for i in face)], "<f4").tobytes() + b"\0\0" for face in FACES]
    return b"\0" * 80 + struct.pack("<I", len(FACES)) + b"".join(triangles)


def _text_stl() -> bytes:
    lines = ["solid wedge"]
    for face in FACES:
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += [f"vertex {x} {y} {z}" for x, y, z in (CORNERS[i] for i in face)]
        lines += ["endloop", "endfacet"]
    return "\n".join([*lines, "endsolid wedge", ""]).encode()


def _obj() -> bytes:
    lines = [f"v {x} {y} {z}" for x, y, z in CORNERS] + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in FACES]
    return "\n".join([*lines, ""]).encode()


def _dae() -> bytes:
    corners = " ".join(str(value) for corner in CORNERS for value in corner)
    faces = " ".join(str(i) for face in FACES for i in face)
    return f"""<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="1"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="wedge"><mesh>
<source id="p"><float_array id="pa" count="12">{corners}</float_array><technique_common>
<accessor source="#pa" count="4" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/><p>{faces}</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node><instance_geometry url="#wedge"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>""".encode()
