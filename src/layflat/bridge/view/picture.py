"""Picture of an arm, rendered off screen."""

import ctypes
import os
from collections.abc import Sequence
from importlib import import_module
from itertools import pairwise
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from layflat import extras
from layflat.arrays import Array, Picture
from layflat.bridge.arm import import_mujoco, without_warnings
from layflat.bridge.meshes import Meshes
from layflat.bridge.mjcf import add_geom, format_numbers, tree_text
from layflat.bridge.pieces import COLOURS, Piece
from layflat.bridge.view.scenery import FIELD_OF_VIEW, FLOOR_SQUARE, Scenery, scenery, viewpoint
from layflat.errors import InputError, NoDrawingError
from layflat.files import whole_file
from layflat.machine import Machine

GL_LIBRARIES = {
    "egl": "libEGL.so.1",
    "osmesa": "libOSMesa.so.8",
}  # OpenGL backends, the faster first, and their libraries
GL_INSTALL_ADVICE = "install one: apt-get install libegl1 libgl1-mesa-dri (or libosmesa6)"


def gl_context(width: int, height: int) -> Any:
    """Return a current OpenGL context off screen, by the backend of MUJOCO_GL or the first available one.

    The caller frees it. Its size is in px.

    Raises:
        NoDrawingError: there is none.
    """
    backend = os.environ.get("MUJOCO_GL", "").lower() or _available_backend()
    try:
        gl = import_module(f"mujoco.{backend}").GLContext(width, height)
        gl.make_current()
    except Exception as error:  # each library has errors of its own
        reason = (str(error).splitlines() or [type(error).__name__])[0].split(". ")[0]
        raise NoDrawingError(f"no picture can be drawn by {backend} ({reason}); {GL_INSTALL_ADVICE}") from None
    return gl


def _available_backend() -> str:
    """Return the first OpenGL backend whose library is installed; raise NoDrawingError if there is none."""
    for backend, library in GL_LIBRARIES.items():
        try:
            ctypes.CDLL(library)
        except OSError:
            continue
        return backend
    raise NoDrawingError(f"no picture can be drawn: there is no OpenGL library; {GL_INSTALL_ADVICE}")


WIDTH, HEIGHT = 1280, 960  # px
MAX_PATH_POINTS = 400  # upper limit of points that a path is drawn by
MIN_PATH_SEGMENT = 1e-6  # length of a segment that is drawn, m


def save_picture(
    machine: Machine, angles: Sequence[float], path: Path, *, motion: Sequence[Array] | Array = ()
) -> Path:
    """Draw an arm at some angles (rad) on a floor of squares of 100 mm, write a PNG and return its path.

    Args:
        machine: the machine.
        angles: rad, an item a joint.
        path: path of the PNG.
        motion: angles (rad, (joints,) each) along which the tip's path is drawn.

    Raises:
        InputError: the arm is of a kind without bodies, or a mesh can't be drawn.
        NoDrawingError: there is no OpenGL.
        MissingExtraError: MuJoCo is not installed.
        OutputError: it can't be written there.
    """
    image = extras.import_extra("view", "PIL.Image")
    pixels = render_picture(scenery(machine, angles), angles, motion=motion)
    with whole_file(path) as temporary:
        image.fromarray(pixels).save(temporary, format="PNG")
    return path


def render_picture(shown: Scenery, angles: Sequence[float], *, motion: Sequence[Array] | Array = ()) -> Picture:
    """Return the picture of an arm, RGB in uint8, (HEIGHT, WIDTH, 3), top row first.

    Args:
        shown: the arm and its floor.
        angles: rad, an item a joint.
        motion: see `save_picture`.

    Raises:
        InputError: a mesh can't be drawn.
        NoDrawingError: there is no OpenGL.
    """
    mj = import_mujoco("view")
    pieces = shown.placed(angles)
    meshes = Meshes(pieces, "", engine=True)
    tips = [shown.level @ shown.tip(at) for at in motion[:: max(len(motion) // MAX_PATH_POINTS, 1)]]
    root = _scene_tree(shown, pieces, meshes, tips)
    gl = gl_context(WIDTH, HEIGHT)
    try:
        try:
            with without_warnings(mj):
                model = mj.MjSpec.from_string(tree_text(root), assets=meshes.contents()).compile()
        except ValueError as error:
            message = " ".join(str(error).split())
            raise InputError(
                f"can't be drawn ({message})", where=shown.machine.origin, right="give other shapes"
            ) from None
        return _render_model(mj, model)
    finally:
        gl.free()


def _render_model(mj: Any, model: Any) -> Picture:
    """Return the picture of a model from its first fixed camera, (HEIGHT, WIDTH, 3), top row first."""
    data, camera = mj.MjData(model), mj.MjvCamera()
    mj.mj_forward(model, data)
    scene, gpu = mj.MjvScene(model, maxgeom=model.ngeom + 100), mj.MjrContext(model, 100)
    camera.type, camera.fixedcamid = mj.mjtCamera.mjCAMERA_FIXED, 0
    everything: Any = mj.mjtCatBit.mjCAT_ALL.value
    mj.mjr_setBuffer(mj.mjtFramebuffer.mjFB_OFFSCREEN.value, gpu)
    scene.flags[mj.mjtRndFlag.mjRND_FOG.value] = True
    mj.mjv_updateScene(model, data, mj.MjvOption(), None, camera, everything, scene)
    pixels, frame = np.empty((HEIGHT, WIDTH, 3), np.uint8), mj.MjrRect(0, 0, WIDTH, HEIGHT)
    mj.mjr_render(frame, scene, gpu)
    mj.mjr_readPixels(pixels, None, frame, gpu)
    gpu.free()
    return np.ascontiguousarray(pixels[::-1])


def _scene_tree(shown: Scenery, pieces: list[Piece], meshes: Meshes, tips: Sequence[Array]) -> Element:
    """Return a static MJCF model of the arm's pieces, the floor and the path of the tip."""
    eye = viewpoint(pieces, shown.floor, WIDTH / HEIGHT)
    centre, radius = eye.centre, eye.radius
    root = Element("mujoco", model=shown.machine.name)
    SubElement(root, "compiler", angle="radian")
    SubElement(root, "statistic", center=format_numbers(centre), extent=repr(radius))
    visual = SubElement(root, "visual")
    SubElement(visual, "global", offwidth=str(WIDTH), offheight=str(HEIGHT))
    SubElement(visual, "quality", shadowsize="8192", offsamples="8", numslices="64", numstacks="32")
    SubElement(visual, "headlight", ambient="0.5 0.5 0.5", diffuse="0.3 0.3 0.3", specular="0 0 0")
    SubElement(visual, "map", znear="0.05", zfar="40", fogstart="4", fogend="14")
    SubElement(visual, "rgba", fog="1 1 1 1")
    assets = SubElement(root, "asset")
    square = {"type": "2d", "builtin": "checker", "rgb1": "0.97 0.97 0.97", "rgb2": "0.9 0.9 0.9"}
    SubElement(assets, "texture", square, name="floor", width="256", height="256")
    SubElement(assets, "texture", type="skybox", builtin="flat", rgb1="1 1 1", width="8", height="48")
    repeat = format_numbers([1.0 / FLOOR_SQUARE, 1.0 / FLOOR_SQUARE])
    SubElement(assets, "material", name="floor", texture="floor", texrepeat=repeat, texuniform="true", specular="0")
    world = SubElement(root, "worldbody")
    down = np.array([-2.0, 2.0, -7.0])
    lamp = {"diffuse": "0.4 0.4 0.4", "specular": "0.15 0.15 0.15", "attenuation": "1 0 0", "exponent": "0"}
    SubElement(world, "light", lamp, pos=format_numbers(centre - radius * down), dir=format_numbers(down), cutoff="40")
    floor = format_numbers((0.0, 0.0, shown.floor))
    SubElement(world, "geom", name="floor", type="plane", size="0 0 1", pos=floor, material="floor")
    for i, piece in enumerate(pieces):
        add_geom(world, piece, assets, meshes, f"piece-{i}", painted=True)
    for begin, end in pairwise(tips):
        if np.linalg.norm(end - begin) < MIN_PATH_SEGMENT:
            continue
        SubElement(
            world,
            "geom",
            type="capsule",
            size="0.004",
            fromto=format_numbers([*begin, *end]),
            rgba=format_numbers(COLOURS["tip"]),
        )
    place, axes = format_numbers(eye.position), format_numbers([*eye.right, *eye.up])
    SubElement(world, "camera", name="view", pos=place, xyaxes=axes, fovy=repr(FIELD_OF_VIEW))
    return root
