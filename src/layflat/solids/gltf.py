"""An assembly as glTF 2.0 for browsers (GLB): metres, Y up, a node for each part, one mesh for equal parts.

Nodes form a tree by joint and by what moves together: the node of a joint's output turns about its own z-axis by the
joint's angle, those of its shells about theirs by their opening; `extras` of the nodes say how far
(angles in rad from mid-stroke, openings in rad).
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from layflat import extras, files
from layflat.lazy import numpy as np
from layflat.solids import cad
from layflat.solids.cams import opening
from layflat.solids.colours import linear_colour
from layflat.solids.meshes import solid_mesh
from layflat.solids.shapes import PartPlace, place
from layflat.solids.sizes import MM

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from pathlib import Path

    from layflat.arrays import Array
    from layflat.solids.component import Component
    from layflat.solids.shapes import Shape
    from layflat.solids.sizes import JointSizes

Y_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])  # axes of the base's frame in that of glTF
METALLIC_FACTOR, ROUGHNESS_FACTOR = 0.1, 0.6  # of all materials
OPENING_POINTS = 25  # of a shell's opening over the joint's angle
MAX_SHORT = 65535  # index of a point that fits into two bytes
POSITION_STEP = 1e-9  # m, to which places are rounded: equal poses give equal files


@dataclass(frozen=True)
class Frame:
    """Frame of parts that move together, in the frame of the base, mm; `parent` is the name of another one."""

    place: PartPlace
    parent: str = ""
    extras: dict[str, Any] = field(default_factory=dict)


def moving_frames(components: Sequence[Component], sizes: Mapping[str, JointSizes]) -> dict[str, Frame]:
    """Return the frames of bodies, outputs and shells by names such as "small/output", parents before children.

    That of an output lies in its shaft, and that of a shell in its hinge; z is the axis about which they turn.

    Args:
        components: in the frame of the base.
        sizes: sizes of each joint's parts by its name, from base to tip.
    """
    frames: dict[str, Frame] = {}
    before = ""
    for joint, one in sizes.items():
        found = {part.name: part for part in components if part.joint == joint}
        limit = one.swing
        angles = np.linspace(-limit, limit, OPENING_POINTS)
        frames[f"{joint}/body"] = Frame(found["cylinder"].places[0], before, {"joint": joint, "group": "body"})
        frames[f"{joint}/output"] = Frame(
            found["shaft"].places[0], f"{joint}/body", {"joint": joint, "group": "output", "limit": round(limit, 6)}
        )
        x, y = one.line.hinge[0] * MM, one.line.hinge[1] * MM
        for side, sign in (("a", 1.0), ("b", -1.0)):
            shell = found.get(f"shell {side.upper()}")
            if shell is not None:
                openings = [round(opening(one, one.stroke / 2 + sign * float(angle)), 6) for angle in angles]
                values = {
                    "joint": joint,
                    "group": f"shell {side}",
                    "angles": [round(float(angle), 6) for angle in angles],
                    "openings": openings,
                }
                frames[f"{joint}/shell {side}"] = Frame(
                    place(x, y).then(shell.places[0]), f"{joint}/body", values)  # fmt: skip
        before = f"{joint}/output"
    return frames


def frame_of(component: Component, frames: Mapping[str, Frame]) -> str:
    """Return the name of the frame with which a component moves; hoses, hinges and straps are with the body."""
    own = f"{component.joint}/{component.group}"
    body = f"{component.joint}/body"
    return own if own in frames else body if body in frames else ""


def write_glb(
    path: Path,
    name: str,
    components: Sequence[Component],
    sizes: Mapping[str, JointSizes],
    solid: Callable[[Component], Any] | None = None,
) -> Path:
    """Write components as a GLB and return its path. Needs the extra `cad`.

    Args:
        path: of the file.
        name: of the root node.
        components: in the frame of the base, mm.
        sizes: sizes of each joint's parts by its name, from base to tip.
        solid: function that returns the solid of a component in its own frame; default: it is made.

    Raises:
        MissingExtraError: the extra `cad` is not installed.
        OutputError: the file can't be written.
    """
    gltf = extras.import_extra("cad", "pygltflib", where=str(path))
    scene = _Scene(gltf, solid or (lambda one: cad.solid(one.shape)))
    frames = moving_frames(components, sizes)
    base = PartPlace(Y_UP, np.zeros(3))
    root = scene.add_node(name, base, None)
    nodes = {"": root}
    for frame_name, frame in frames.items():
        outer = frames[frame.parent].place if frame.parent else place()
        nodes[frame_name] = scene.add_node(
            frame_name, _place_within(frame.place, outer), nodes[frame.parent], frame.extras
        )
    totals: Counter[str] = Counter()
    for one in components:
        totals[_label(one)] += one.quantity
    numbers: Counter[str] = Counter()
    for one in components:
        home, label = frame_of(one, frames), _label(one)
        outer = frames[home].place if home else place()
        for at in one.places:
            numbers[label] += 1
            numbered = f"{label} {numbers[label]}" if totals[label] > 1 else label
            scene.add_part(numbered, one, _place_within(at, outer), nodes[home])
    with files.whole_file(path) as temporary:
        temporary.write_bytes(scene.to_bytes(root))
    return path


def _label(component: Component) -> str:
    """Return the name of the nodes of a component, without their numbers."""
    return f"{component.joint}/{component.name}".strip("/")


def _place_within(at: PartPlace, outer: PartPlace) -> PartPlace:
    """Return a place in a frame that has a place itself."""
    return PartPlace(outer.axes.T @ at.axes, outer.axes.T @ (at.origin - outer.origin))


def quaternion(axes: Array) -> list[float]:
    """Return the unit quaternion (x, y, z, w) of axes (3, 3), with w of 0 or more."""
    from scipy.spatial.transform import Rotation  # noqa: PLC0415  # SciPy takes long to import

    return [round(float(value), 9) + 0.0 for value in Rotation.from_matrix(axes).as_quat(canonical=True)]


class _Scene:
    """Growing content of a glTF file."""

    def __init__(self, gltf: Any, solid: Callable[[Component], Any]) -> None:
        self._gltf, self._solid = gltf, solid
        self._content = gltf.GLTF2(asset=gltf.Asset(generator="layflat"))
        self._blob = bytearray()
        self._meshes: dict[tuple[Shape, str], int] = {}
        self._materials: dict[str, int] = {}

    def add_node(self, name: str, at: PartPlace, parent: int | None, values: dict[str, Any] | None = None) -> int:
        """Add a node and return its index.

        Args:
            name: of the node.
            at: place in the parent's frame, mm.
            parent: index of its parent; None for the root.
            values: its extras.
        """
        node = self._gltf.Node(name=name, extras=values or {}, rotation=quaternion(at.axes))
        node.translation = [round(float(value) / MM / POSITION_STEP) * POSITION_STEP for value in at.origin]
        self._content.nodes.append(node)
        index = len(self._content.nodes) - 1
        if parent is not None:
            self._content.nodes[parent].children.append(index)
        return index

    def add_part(self, name: str, component: Component, at: PartPlace, parent: int) -> None:
        """Add a node of one part of a component.

        Args:
            name: of the node.
            component: whose mesh it shows.
            at: place in the parent's frame, mm.
            parent: index of its parent.
        """
        key = (component.shape, component.material)
        if key not in self._meshes:
            self._meshes[key] = self._add_mesh(component)
        index = self.add_node(name, at, parent, {"component": component.name, "material": component.material})
        self._content.nodes[index].mesh = self._meshes[key]

    def to_bytes(self, root: int) -> bytes:
        """Return the file with a node as the root of its scene."""
        content, gltf = self._content, self._gltf
        content.scenes.append(gltf.Scene(nodes=[root]))
        content.scene = 0
        content.buffers.append(gltf.Buffer(byteLength=len(self._blob)))
        content.set_binary_blob(bytes(self._blob))
        return b"".join(content.save_to_bytes())

    def _add_mesh(self, component: Component) -> int:
        gltf, mesh = self._gltf, solid_mesh(self._solid(component))
        points = (mesh.points / MM).astype("<f4")
        attributes = gltf.Attributes(
            POSITION=self._add_values(points, gltf.FLOAT, gltf.VEC3, gltf.ARRAY_BUFFER, bounds=True),
            NORMAL=self._add_values(mesh.normals.astype("<f4"), gltf.FLOAT, gltf.VEC3, gltf.ARRAY_BUFFER),
        )
        short = len(points) <= MAX_SHORT
        indices = mesh.triangles.reshape(-1, 1).astype("<u2" if short else "<u4")
        kind = gltf.UNSIGNED_SHORT if short else gltf.UNSIGNED_INT
        triangles = self._add_values(indices, kind, gltf.SCALAR, gltf.ELEMENT_ARRAY_BUFFER)
        primitive = gltf.Primitive(
            attributes=attributes, indices=triangles, material=self._material(component.material)
        )
        self._content.meshes.append(gltf.Mesh(name=component.name, primitives=[primitive]))
        return len(self._content.meshes) - 1

    def _add_values(self, values: Array, kind: int, form: str, target: int, *, bounds: bool = False) -> int:
        """Add an accessor for an array (n, width), and return its index."""
        gltf, data = self._gltf, values.tobytes()
        view = gltf.BufferView(buffer=0, byteOffset=len(self._blob), byteLength=len(data), target=target)
        self._blob += data + bytes(-len(data) % 4)
        self._content.bufferViews.append(view)
        accessor = gltf.Accessor(
            bufferView=len(self._content.bufferViews) - 1, componentType=kind, count=len(values), type=form
        )
        if bounds:
            accessor.min, accessor.max = (edge.astype(float).tolist() for edge in (values.min(0), values.max(0)))
        self._content.accessors.append(accessor)
        return len(self._content.accessors) - 1

    def _material(self, name: str) -> int:
        if name not in self._materials:
            colour = [round(value, 6) for value in (*linear_colour(name), 1.0)]
            surface = self._gltf.PbrMetallicRoughness(
                baseColorFactor=colour, metallicFactor=METALLIC_FACTOR, roughnessFactor=ROUGHNESS_FACTOR
            )
            self._content.materials.append(self._gltf.Material(name=name, pbrMetallicRoughness=surface))
            self._materials[name] = len(self._content.materials) - 1
        return self._materials[name]
