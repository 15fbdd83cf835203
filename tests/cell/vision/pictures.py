"""Pictures with known truth: balls and flat things on a table, through an exact lens, drawn with numpy alone.

Each pixel's ray is traced: to the table, to balls (outlines exact to a hundredth of a pixel by their cone), to flat
shapes. Pixel (0, 0) is the middle of the first pixel.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
Picture = NDArray[np.uint8]


@dataclass(frozen=True)
class TrueCamera:
    focal: tuple[float, float] = (1500.0, 1502.0)
    middle: tuple[float, float] = (645.0, 473.0)
    distortion: tuple[float, float, float, float, float] = (-0.16, 0.05, 4e-4, -3e-4, 0.0)
    size: tuple[int, int] = (1280, 960)
    position: tuple[float, float, float] = (0.42, 0.03, 1.0)
    tilt: tuple[float, float, float] = (0.03, -0.02, 0.01)

    @cached_property
    def rotation(self) -> Array:
        """Base frame to camera frame: looking down, picture's x along the base's x, then tilted."""
        a, b, c = self.tilt
        x = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
        y = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
        z = np.array([[np.cos(c), -np.sin(c), 0], [np.sin(c), np.cos(c), 0], [0, 0, 1]])
        return np.asarray(x @ y @ z @ np.diag([1.0, -1.0, -1.0]))

    def distorted(self, xy: Array) -> Array:
        k1, k2, p1, p2, k3 = self.distortion
        x, y = xy[..., 0], xy[..., 1]
        r2 = x * x + y * y
        radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
        return np.stack(
            [x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x), y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y],
            axis=-1,
        )

    def project(self, places: Array) -> Array:
        seen = (places - np.array(self.position)) @ self.rotation.T
        return self.distorted(seen[..., :2] / seen[..., 2:]) * self.focal + self.middle

    @cached_property
    def rays(self) -> Array:
        """Unit vectors in the base frame, (H, W, 3)."""
        return lens_rays(replace(self, position=(0.0, 0.0, 0.0), tilt=(0.0, 0.0, 0.0))) @ self.rotation

    @cached_property
    def pixel(self) -> float:
        """Angle between neighbouring rays in the middle."""
        return 1.0 / self.focal[0]

    @cached_property
    def floor(self) -> Array:
        """Where rays meet z = 0, (H, W, 2)."""
        return self.plane(0.0)

    def plane(self, height: float) -> Array:
        far = (height - self.position[2]) / self.rays[..., 2:]
        return np.array(self.position[:2]) + far * self.rays[..., :2]


@cache
def lens_rays(camera: TrueCamera) -> Array:
    """Unit vectors in the camera frame, (H, W, 3), the same for each pose."""
    u, v = np.meshgrid(np.arange(camera.size[0]), np.arange(camera.size[1]))
    bent = (np.stack([u, v], axis=-1) - camera.middle) / camera.focal
    straight = bent.copy()
    for _ in range(9):
        straight += bent - camera.distorted(straight)
    rays = np.concatenate([straight, np.ones((*u.shape, 1))], axis=-1)
    return np.asarray(rays / np.linalg.norm(rays, axis=-1, keepdims=True))


@dataclass(frozen=True)
class Ball:
    kind: str
    x: float
    y: float
    radius: float
    colour: tuple[float, float, float]
    spot: tuple[float, float, float] | None = None  # a calyx on top
    shine: float = 0.25
    floor: float = 0.0  # height of what it rests on

    @property
    def centre(self) -> Array:
        return np.array([self.x, self.y, self.floor + self.radius])


@dataclass(frozen=True)
class Flat:
    """A flat shape `height` over the table: an ellipse or a rectangle."""

    x: float
    y: float
    long: float
    wide: float
    colour: tuple[float, float, float]
    yaw: float = 0.0
    oval: bool = False
    height: float = 0.0


@dataclass(frozen=True)
class Plate:
    """A textured square or rectangle: a marker or a board; grey texture, rows from its upper edge down."""

    texture: Picture
    corner: Array  # upper left, m
    right: Array  # to the upper right, m
    down: Array  # to the lower left, m


@dataclass(frozen=True)
class Light:
    direction: tuple[float, float, float]
    strength: float


@dataclass
class Scene:
    balls: Sequence[Ball] = ()
    flats: Sequence[Flat] = ()
    plates: Sequence[Plate] = ()
    table: tuple[float, float, float] = (60.0, 95.0, 140.0)
    lights: Sequence[Light] = (Light((0.3, 0.2, 1.0), 0.35), Light((-0.5, 0.1, 1.0), 0.25))
    ambient: float = 0.45
    tint: tuple[float, float, float] = (1.0, 1.0, 1.0)
    slope: tuple[float, float] = (0.0, 0.0)  # change of light across a metre
    covers: Sequence[Flat] = field(default_factory=tuple)  # above everything: an arm


def take(scene: Scene, camera: TrueCamera, seed: int = 0, noise: float = 2.5, blur: float = 0.6) -> Picture:
    """The picture that a camera takes, RGB."""
    rng = np.random.default_rng(seed)
    floor = camera.floor
    flat_light = scene.ambient + sum(light.strength * _unit(light)[2] for light in scene.lights)
    picture: NDArray[np.float32] = np.empty((*floor.shape[:2], 3), np.float32)
    picture[:] = np.array(scene.table) * flat_light
    for flat in scene.flats:
        _paint_flat(picture, camera, flat, flat_light)
    for plate in scene.plates:
        _paint_plate(picture, camera, plate, flat_light)
    for ball in scene.balls:
        _shade_table(picture, camera, ball, scene)
    for ball in sorted(scene.balls, key=lambda ball: ball.radius):
        _paint_ball(picture, camera, ball, scene)
    for cover in scene.covers:
        _paint_flat(picture, camera, cover, flat_light)
    across = 1.0 + scene.slope[0] * (floor[..., 0] - 0.4) + scene.slope[1] * floor[..., 1]
    picture *= (across[..., None] * np.array(scene.tint)).astype(np.float32)
    picture = _blurred(picture, blur)
    if noise:
        picture += np.float32(noise) * rng.standard_normal(picture.shape, dtype=np.float32)
    return np.asarray(np.clip(picture + np.float32(0.5), 0, 255).astype(np.uint8))


def marker_texture(number: int, dictionary: str = "DICT_4X4_50") -> Picture:
    import cv2

    words = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, dictionary))
    inner = cv2.aruco.generateImageMarker(words, number, 240)
    return np.pad(inner, 40, constant_values=255)


def marker_plate(number: int, x: float, y: float, side: float, yaw: float = 0.0) -> Plate:
    """A marker of that side with a white rim of a sixth of it."""
    c, s = np.cos(yaw), np.sin(yaw)
    right, down = np.array([c, s, 0.0]), np.array([s, -c, 0.0])
    full = side * 320 / 240
    return Plate(marker_texture(number), np.array([x, y, 0.0]) - (right + down) * full / 2, right * full, down * full)


def _unit(light: Light) -> Array:
    direction = np.array(light.direction)
    return np.asarray(direction / np.linalg.norm(direction))


def _window(camera: TrueCamera, places: Array, margin: int = 3) -> tuple[slice, slice] | None:
    px = camera.project(places)
    low = np.maximum(np.floor(px.min(axis=0)).astype(int) - margin, 0)
    high = np.minimum(np.ceil(px.max(axis=0)).astype(int) + margin + 1, camera.size)
    return None if (high <= low).any() else (slice(low[1], high[1]), slice(low[0], high[0]))


def _mix(picture: NDArray[np.float32], window: tuple[slice, slice], share: Array, colour: Array) -> None:
    picture[window] += share[..., None] * (colour - picture[window])


def _box(x: float, y: float, reach: float, heights: tuple[float, ...]) -> Array:
    return np.array([[x + i * reach, y + j * reach, z] for i in (-1, 1) for j in (-1, 1) for z in heights])


def _paint_flat(picture: NDArray[np.float32], camera: TrueCamera, flat: Flat, light: float) -> None:
    window = _window(camera, _box(flat.x, flat.y, np.hypot(flat.long, flat.wide) / 2, (flat.height,)))
    if window is None:
        return
    far = (flat.height - camera.position[2]) / camera.rays[window][..., 2:]
    at = np.array(camera.position[:2]) + far * camera.rays[window][..., :2] - [flat.x, flat.y]
    c, s = np.cos(flat.yaw), np.sin(flat.yaw)
    along, across = at @ [c, s], at @ [-s, c]
    a, b = flat.long / 2, flat.wide / 2
    metre = camera.focal[0] / (camera.position[2] - flat.height)
    if flat.oval:
        rho = np.sqrt((along / a) ** 2 + (across / b) ** 2) + 1e-9
        slope = np.hypot(along / a**2, across / b**2) / rho
        inside = (1.0 - rho) / np.maximum(slope, 1e-9)
    else:
        inside = np.minimum(a - np.abs(along), b - np.abs(across))
    _mix(picture, window, np.clip(0.5 + inside * metre, 0, 1), np.array(flat.colour) * light)


def _paint_plate(picture: NDArray[np.float32], camera: TrueCamera, plate: Plate, light: float) -> None:
    import cv2

    corners = np.array([plate.corner + i * plate.right + j * plate.down for i in (0, 1) for j in (0, 1)])
    window = _window(camera, corners)
    if window is None:
        return
    rays, eye = camera.rays[window], np.array(camera.position)
    frame = np.column_stack([plate.right, plate.down, np.cross(plate.right, plate.down)])
    back = np.linalg.inv(frame)
    start, ahead = back @ (eye - plate.corner), rays @ back.T
    at = start[:2] - ahead[..., :2] * (start[2] / ahead[..., 2:])
    rows, columns = plate.texture.shape
    u, v = (np.float32(count) * at[..., i].astype(np.float32) for i, count in enumerate((columns, rows)))
    (u_down, u_right), (v_down, v_right) = np.gradient(u), np.gradient(v)
    shade, share = np.zeros_like(u), np.zeros_like(u)
    steps = np.array([-1, 0, 1], np.float32) / 3
    for right in steps:
        for down in steps:
            there_u, there_v = u + right * u_right + down * u_down, v + right * v_right + down * v_down
            inside = (there_u >= 0) & (there_u <= columns) & (there_v >= 0) & (there_v <= rows)
            half = np.float32(0.5)
            shade += inside * cv2.remap(
                plate.texture, there_u - half, there_v - half, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
            )
            share += inside
    grey = shade / np.maximum(share, 1)
    _mix(picture, window, share / 9, grey[..., None] * 0.9 * light * np.ones(3))


def _shade_table(picture: NDArray[np.float32], camera: TrueCamera, ball: Ball, scene: Scene) -> None:
    whole = scene.ambient + sum(light.strength * _unit(light)[2] for light in scene.lights)
    for light in scene.lights:
        to = _unit(light)
        foot = ball.centre[:2] - to[:2] / to[2] * ball.centre[2]
        window = _window(camera, _box(foot[0], foot[1], 1.6 * ball.radius / to[2], (0.0,)))
        if window is None:
            continue
        at = camera.floor[window]
        gap = np.concatenate([ball.centre[:2] - at, np.full((*at.shape[:2], 1), ball.centre[2])], axis=-1)
        miss = np.linalg.norm(gap - (gap @ to)[..., None] * to, axis=-1)
        dark = np.clip(0.5 + (ball.radius - miss) / (0.25 * ball.radius), 0, 1)
        picture[window] *= 1.0 - (dark * light.strength * to[2] / whole)[..., None]


def _paint_ball(picture: NDArray[np.float32], camera: TrueCamera, ball: Ball, scene: Scene) -> None:
    window = _window(camera, _box(ball.x, ball.y, ball.radius, (ball.floor, ball.floor + 2 * ball.radius)))
    if window is None:
        return
    rays = camera.rays[window]
    towards = ball.centre - np.array(camera.position)
    far = np.linalg.norm(towards)
    along = rays @ towards
    angle = np.arccos(np.clip(along / far, -1, 1))
    share = np.clip(0.5 + (np.arcsin(ball.radius / far) - angle) / camera.pixel, 0, 1)
    root = np.sqrt(np.maximum(along**2 - far**2 + ball.radius**2, 0))
    normal = ((along - root)[..., None] * rays - towards) / ball.radius
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    light, shine = np.full(share.shape, scene.ambient) * (0.75 + 0.25 * normal[..., 2]), np.zeros(share.shape)
    for lamp in scene.lights:
        to = _unit(lamp)
        light += lamp.strength * np.maximum(normal @ to, 0)
        halfway = to - rays
        halfway /= np.linalg.norm(halfway, axis=-1, keepdims=True)
        shine += lamp.strength * np.maximum((normal * halfway).sum(axis=-1), 0) ** 60
    skin = np.broadcast_to(np.array(ball.colour), (*share.shape, 3)).copy()
    if ball.spot is not None:
        skin[normal[..., 2] > 0.95] = ball.spot
    _mix(picture, window, share, skin * light[..., None] + 255 * ball.shine * shine[..., None])


def _blurred(picture: NDArray[np.float32], sigma: float) -> NDArray[np.float32]:
    import cv2

    return np.asarray(cv2.GaussianBlur(picture, (0, 0), sigma)) if sigma else picture
