"""Picture of the paper's small joint, whole and taken apart, as it is built: `python -m docs.exploded`.

Needs the extras `cad` and `view`, and OpenGL.
"""

import re
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from PIL import Image, ImageChops

from layflat import load
from layflat.bridge.view.picture import gl_context
from layflat.solids.assembly import Assembly, assemble
from layflat.solids.colours import MATERIAL_COLOURS
from layflat.solids.component import Component
from layflat.solids.meshes import solid_mesh
from layflat.solids.sizes import MM

WIDTH, HEIGHT, SAMPLING = 1280, 700, 2  # px, and rendered over shown px
MARGIN = 16  # of white around the picture, px
FIELD_OF_VIEW = 20.0  # vertical, deg
BESIDE = 0.40  # distance of the two joints, m
APART = (
    (r"foot plate|.* of the foot", (0, 0, -0.115)),
    (r"brake (beam|spring)|(washer|nut|stud) .*brake.*", (0, 0, -0.085)),
    (r"brake pad", (0, 0, -0.07)),
    (r"brake disc|set screw of the disc", (0, 0, -0.055)),
    (r"lower end plate", (0, 0, -0.04)),
    (r"upper end plate", (0, 0, 0.04)),
    (r"(screw|washer) of an end plate", (0, 0, 0.075)),
    (r"standoff|lower screw of a standoff|.*coupling", (0, 0, 0.08)),
    (r"sensor plate|upper screw of a standoff", (0, 0, 0.105)),
    (r"angle sensor", (0, 0, 0.12)),
    (r"bush|bump stop|stud of a bump stop|retaining ring", (0, 0, 0.02)),
    (r".*shell A", (0, 0.16, 0)),
    (r".*shell B", (0, -0.16, 0)),
    (r"strap of hose A", (0, 0.09, 0)),
    (r"strap of hose B", (0, -0.09, 0)),
    (r"hose A|hinge of hose A|inlet of hose A", (0, 0.05, 0)),
    (r"hose B|hinge of hose B|inlet of hose B", (0, -0.05, 0)),
    (r"shaft", (0.06, 0, 0)),
)
"""Patterns of names, and how far those components are moved, m."""
MIRRORED = {
    r"(screw|washer) of an end plate",
    r"bush|bump stop|stud of a bump stop|retaining ring",
}  # parts below go down
LINK = "strut|tool|the arm"  # pattern of names of what belongs to no joint
OUTPUT_SHIFT = (0.14, 0.0, 0.0)  # of the output's other components, m


def shift_of(component: Component, at: Any) -> Any:
    """Return how far the part of a component at a place is moved in the picture taken apart, m, (3,)."""
    for pattern, shift in APART:
        if re.fullmatch(pattern, component.name):
            below = at.origin[2] < 0 and pattern in MIRRORED
            return np.array(shift) * ((1, 1, -1) if below else (1, 1, 1))
    return np.array(OUTPUT_SHIFT if component.group == "output" else (0.0, 0.0, 0.0))


def built_model(assembly: Assembly) -> Any:
    """Return the model of a joint, whole and beside it taken apart."""
    spec = mujoco.MjSpec()
    spec.visual.global_.offwidth, spec.visual.global_.offheight = SAMPLING * WIDTH, SAMPLING * HEIGHT
    spec.visual.headlight.ambient, spec.visual.headlight.diffuse = [0.45] * 3, [0.25] * 3
    spec.visual.headlight.specular = [0.0] * 3
    spec.visual.global_.fovy = FIELD_OF_VIEW
    spec.visual.quality.shadowsize = 8192
    spec.add_texture(
        name="sky", type=mujoco.mjtTexture.mjTEXTURE_SKYBOX, builtin=mujoco.mjtBuiltin.mjBUILTIN_FLAT,
        rgb1=[1, 1, 1], rgb2=[1, 1, 1], width=8, height=48,
    )  # fmt: skip
    spec.worldbody.add_light(
        pos=[1.5, 1.2, 2.5], dir=[-0.5, -0.4, -0.9], diffuse=[0.5] * 3, specular=[0.2] * 3, castshadow=True
    )
    for number, one in enumerate(
        part for part in assembly.components if not re.search("strut|tool|the arm", part.name)
    ):
        mesh = solid_mesh(assembly.solid(one))
        spec.add_mesh(
            name=str(number), uservert=(mesh.points / MM).ravel(), usernormal=mesh.normals.ravel(),
            userface=mesh.triangles.ravel(), userfacenormal=mesh.triangles.ravel(),
            inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
        )  # fmt: skip
        colour = MATERIAL_COLOURS[one.material]
        rgba = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)] + [1.0]
        for at in one.places:
            quaternion = np.zeros(4)
            mujoco.mju_mat2Quat(quaternion, at.axes.ravel())
            for moved in (np.array([0.0, -BESIDE, 0.0]), shift_of(one, at)):
                spec.worldbody.add_geom(
                    type=mujoco.mjtGeom.mjGEOM_MESH, meshname=str(number), rgba=rgba,
                    pos=at.origin / MM + moved, quat=quaternion,
                )  # fmt: skip
    return spec.compile()


def rendered(model: Any) -> Image.Image:
    """Return the picture of a model."""
    width, height = SAMPLING * WIDTH, SAMPLING * HEIGHT
    gl = gl_context(width, height)
    data, camera = mujoco.MjData(model), mujoco.MjvCamera()
    mujoco.mj_forward(model, data)
    scene, gpu = mujoco.MjvScene(model, maxgeom=model.ngeom + 100), mujoco.MjrContext(model, 100)
    camera.lookat, camera.distance, camera.azimuth, camera.elevation = (0.0, -0.14, -0.015), 1.5, 215.0, -20.0
    scene.flags[mujoco.mjtRndFlag.mjRND_HAZE] = False
    mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, gpu)
    mujoco.mjv_updateScene(model, data, mujoco.MjvOption(), None, camera, mujoco.mjtCatBit.mjCAT_ALL.value, scene)
    pixels, frame = np.empty((height, width, 3), np.uint8), mujoco.MjrRect(0, 0, width, height)
    mujoco.mjr_render(frame, scene, gpu)
    mujoco.mjr_readPixels(pixels, None, frame, gpu)
    gpu.free()
    gl.free()
    picture = Image.fromarray(pixels[::-1]).resize((WIDTH, HEIGHT), Image.Resampling.LANCZOS)
    left, top, right, bottom = ImageChops.invert(picture).getbbox() or (0, 0, WIDTH, HEIGHT)
    return picture.crop((left - MARGIN, top - MARGIN, right + MARGIN, bottom + MARGIN))


def main() -> None:
    """Write docs/building.png."""
    picture = rendered(built_model(assemble(load("paper-small-joint"))))
    picture.save(Path(__file__).parent / "building.png", optimize=True)


if __name__ == "__main__":
    main()
