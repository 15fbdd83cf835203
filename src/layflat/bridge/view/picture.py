"""A picture of an arm, drawn without a screen."""

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
from layflat.bridge.arm import engine, without_warnings
from layflat.bridge.meshes import Meshes
from layflat.bridge.mjcf import add_geom, numbers, text_of
from layflat.bridge.pieces import COLOURS, Piece
from layflat.bridge.view.scenery import FIELD, SQUARE, Scenery, scenery, viewpoint
from layflat.errors import InputError, NoDrawingError
from layflat.files import whole_file
from layflat.machine import Machine

LIBRARIES = {"egl": "libEGL.so.1", "osmesa": "libOSMesa.so.8"}  # ways to draw, the faster first, and what each needs
INSTALL = "install one: apt-get install libegl1 libgl1-mesa-dri (or libosmesa6)"


def context(width: int, height: int) -> Any:
    """Return a current context to draw off screen, by MUJOCO_GL's way or the first there is; NoDrawingError without."""
    way = os.environ.get("MUJOCO_GL", "").lower() or _there()
    try:
        made = import_module(f"mujoco.{way}").GLContext(width, height)
        made.make_current()
    except Exception as error:  # each library has errors of its own
        reason = (str(error).splitlines() or [type(error).__name__])[0].split(". ")[0]
        raise NoDrawingError(f"no picture can be drawn by {way} ({reason}); {INSTALL}") from None
    return made


def _there() -> str:
    for way, library in LIBRARIES.items():
        try:
            ctypes.CDLL(library)
        except OSError:
            continue
        return way
    raise NoDrawingError(f"no picture can be drawn: there is no OpenGL library; {INSTALL}")


WIDTH, HEIGHT = 1280, 960  # px
MOST = 400  # points by which a way is drawn
LEAST = 1e-6  # between two of them, m


def save_picture(machine: Machine, angles: Sequence[float], path: Path, *, way: Sequence[Array] | Array = ()) -> Path:
    """Draw an arm at some angles (rad) on a floor of squares of 100 mm, write a PNG and return its path.

    Args:
        machine: whose arm it is.
        angles: rad, an item a joint.
        path: of the PNG.
        way: angles (rad, (joints,) each) between which the tip's way is drawn.

    Raises:
        InputError: the arm is of a kind without bodies, or a mesh can't be drawn.
        NoDrawingError: there is no OpenGL.
        MissingExtraError: MuJoCo is not installed.
        OutputError: it can't be written there.
    """
    image = extras.module("view", "PIL.Image")
    seen = picture(scenery(machine, angles), angles, way=way)
    with whole_file(path) as temporary:
        image.fromarray(seen).save(temporary, format="PNG")
    return path


def picture(shown: Scenery, angles: Sequence[float], *, way: Sequence[Array] | Array = ()) -> Picture:
    """Return the picture, (height, width, 3); see `save_picture`."""
    mj = engine("view")
    pieces = shown.placed(angles)
    meshes = Meshes(pieces, "", engine=True)
    tips = [shown.level @ shown.tip(at) for at in way[:: max(len(way) // MOST, 1)]]
    root = _room(shown, pieces, meshes, tips)
    gl = context(WIDTH, HEIGHT)
    try:
        try:
            with without_warnings(mj):
                model = mj.MjSpec.from_string(text_of(root), assets=meshes.contents()).compile()
        except ValueError as error:
            said = " ".join(str(error).split())
            raise InputError(
                f"can't be drawn ({said})", where=shown.machine.origin, right="give other shapes"
            ) from None
        return _drawn(mj, model)
    finally:
        gl.free()


def _drawn(mj: Any, model: Any) -> Picture:
    data, camera = mj.MjData(model), mj.MjvCamera()
    mj.mj_forward(model, data)
    scene, gpu = mj.MjvScene(model, maxgeom=model.ngeom + 100), mj.MjrContext(model, 100)
    camera.type, camera.fixedcamid = mj.mjtCamera.mjCAMERA_FIXED, 0
    everything: Any = mj.mjtCatBit.mjCAT_ALL.value
    mj.mjr_setBuffer(mj.mjtFramebuffer.mjFB_OFFSCREEN.value, gpu)
    scene.flags[mj.mjtRndFlag.mjRND_FOG.value] = True
    mj.mjv_updateScene(model, data, mj.MjvOption(), None, camera, everything, scene)
    found, frame = np.empty((HEIGHT, WIDTH, 3), np.uint8), mj.MjrRect(0, 0, WIDTH, HEIGHT)
    mj.mjr_render(frame, scene, gpu)
    mj.mjr_readPixels(found, None, frame, gpu)
    gpu.free()
    return np.ascontiguousarray(found[::-1])


def _room(shown: Scenery, pieces: list[Piece], meshes: Meshes, way: Sequence[Array]) -> Element:
    """Return a model of the arm as it stands: nothing in it moves."""
    eye = viewpoint(pieces, shown.floor, WIDTH / HEIGHT)
    centre, radius = eye.centre, eye.radius
    root = Element("mujoco", model=shown.machine.name)
    SubElement(root, "compiler", angle="radian")
    SubElement(root, "statistic", center=numbers(centre), extent=repr(radius))
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
    repeat = numbers([1.0 / SQUARE, 1.0 / SQUARE])
    SubElement(assets, "material", name="floor", texture="floor", texrepeat=repeat, texuniform="true", specular="0")
    world = SubElement(root, "worldbody")
    down = np.array([-2.0, 2.0, -7.0])
    lamp = {"diffuse": "0.4 0.4 0.4", "specular": "0.15 0.15 0.15", "attenuation": "1 0 0", "exponent": "0"}
    SubElement(world, "light", lamp, pos=numbers(centre - radius * down), dir=numbers(down), cutoff="40")
    floor = numbers((0.0, 0.0, shown.floor))
    SubElement(world, "geom", name="floor", type="plane", size="0 0 1", pos=floor, material="floor")
    for i, piece in enumerate(pieces):
        add_geom(world, piece, assets, meshes, f"piece-{i}", painted=True)
    for begin, end in pairwise(way):
        if np.linalg.norm(end - begin) < LEAST:
            continue
        SubElement(
            world, "geom", type="capsule", size="0.004", fromto=numbers([*begin, *end]), rgba=numbers(COLOURS["tip"])
        )
    place, axes = numbers(eye.place), numbers([*eye.right, *eye.up])
    SubElement(world, "camera", name="view", pos=place, xyaxes=axes, fovy=repr(FIELD))
    return root
