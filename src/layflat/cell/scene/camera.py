"""Simulated cameras: their images are vision's only input from the scene."""

from typing import Any, Literal, Self

import numpy as np

from layflat.arrays import Picture
from layflat.bridge.view.picture import gl_context
from layflat.cell.extras import mujoco, opencv
from layflat.cell.file.imaging import Camera
from layflat.cell.scene.furniture import BOARD_GROUP, camera_optics
from layflat.cell.scene.scene import Scene

__all__ = ["SimulatedCamera"]

# Visual quality of the model in overviews: no visible difference there, in half the rendering time.
OVERVIEW_QUALITY = {"shadowsize": 1024, "numquads": 1, "numslices": 20, "numstacks": 10}


class SimulatedCamera:
    """The overhead camera of a scene, and an overview for people. Close it when done, or use it in a `with` block.

    The pictures of a scene differ by their noise, which is the same for the same scene, seed and order of pictures.
    Raises NoDrawingError, which names the package to install, where there is no OpenGL.
    """

    def __init__(self, scene: Scene) -> None:
        """Make an OpenGL context off screen, and the generator of the noise."""
        self._mj, self._scene = mujoco(), scene
        self._optics = camera_optics(scene.cell.camera)
        self._rng = np.random.default_rng([scene.seed, 0xCA3E6A])
        frame = scene.model.vis.global_
        self._gl = gl_context(frame.offwidth, frame.offheight)
        self._drawn = self._mj.MjvScene(scene.model, maxgeom=2000)
        self._contexts: dict[str, Any] = {}
        self._option, self._view = self._mj.MjvOption(), self._mj.MjvCamera()
        self._view.type = self._mj.mjtCamera.mjCAMERA_FIXED

    def picture(self, view: Literal["camera", "overview"] = "camera") -> Picture:
        """Return an image, RGB: of the camera with lens, blur and noise, or an ideal overview of the whole cell."""
        cell = self._scene.cell
        if view == "overview":
            return self._ideal(view, cell.overview.width, cell.overview.height)
        return expose(self._optics.bend(self._ideal(view, *self._optics.wide)), cell.camera, self._rng)

    def close(self) -> None:
        """Free the rendering contexts."""
        if self._gl is not None:
            self._gl.make_current()
            for context in self._contexts.values():
                context.free()
            self._gl.free()
            self._gl = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _ideal(self, view: str, width: int, height: int) -> Picture:
        """Return the image of a pinhole camera without noise."""
        mj, scene = self._mj, self._scene
        self._gl.make_current()
        context = self._context(view)
        mj.mjr_setBuffer(mj.mjtFramebuffer.mjFB_OFFSCREEN.value, context)
        self._view.fixedcamid = scene.model.camera(view).id
        self._option.geomgroup[BOARD_GROUP] = scene.board_held
        everything: Any = mj.mjtCatBit.mjCAT_ALL.value
        mj.mjv_updateScene(scene.model, scene.data, self._option, None, self._view, everything, self._drawn)
        picture = np.empty((height, width, 3), np.uint8)
        rectangle = mj.MjrRect(0, 0, width, height)
        mj.mjr_render(rectangle, self._drawn, context)
        mj.mjr_readPixels(picture, None, rectangle, context)
        return picture[::-1]

    def _context(self, view: str) -> Any:
        """Return the rendering context of a view, with the visual quality that it needs."""
        if view not in self._contexts:
            model = self._scene.model
            quality = model.vis.quality
            fine = {name: getattr(quality, name) for name in OVERVIEW_QUALITY}
            for name, value in (OVERVIEW_QUALITY if view == "overview" else fine).items():
                setattr(quality, name, value)
            self._contexts[view] = self._mj.MjrContext(model, self._mj.mjtFontScale.mjFONTSCALE_100.value)
            for name, value in fine.items():
                setattr(quality, name, value)
        return self._contexts[view]


def expose(picture: Picture, camera: Camera, rng: np.random.Generator) -> Picture:
    """Return a picture, (H, W, 3), after blur, exposure and noise of a camera.

    Args:
        picture: image behind the lens, (H, W, 3) RGB.
        camera: description with the parameters.
        rng: generator of the noise.
    """
    values = picture.astype(np.float32)
    if camera.blur > 0.0:
        values = opencv().GaussianBlur(values, (0, 0), camera.blur)
    values *= np.float32(camera.exposure)
    deviation = np.sqrt(np.float32(camera.read_noise) ** 2 + np.float32(camera.shot_noise) * values)
    values += deviation * rng.standard_normal(values.shape, dtype=np.float32)
    result: Picture = np.clip(np.rint(values), 0, 255).astype(np.uint8)
    return result
