"""A model of MuJoCo from an MJCF, or one line on why MuJoCo does not take it."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from layflat.bridge.arm import without_warnings
from layflat.bridge.formats import realizable_inertia
from layflat.errors import InputError
from layflat.physics.arms.bodies import moments

ADVICE = {
    "mass and inertia of moving": "give it an inertial, or geoms with mass",
    "A + B >= C": "no principal moment of inertia can be greater than the other two together",
    "axis too small": 'give an axis such as "0 0 1"',
    "opening file": "put the file there, or leave meshes out: --no-meshes",
    "inertia from mesh": "give the body an inertial: without its mesh nobody knows its mass",
}
"""Advice by a part of MuJoCo's message."""


def compile_mjcf(mj: Any, file: Path, text: str, *, meshes: bool) -> tuple[Any, Any, list[str]]:
    """Return the specification of a model, the compiled model, and notes on what had to be changed to compile it.

    Args:
        mj: the package `mujoco`.
        file: of the model, beside which MuJoCo looks for what it names.
        text: what stands in the file, where MuJoCo can't read its encoding; else empty.
        meshes: whether to read meshes. Without, bodies that have an inertial lose them, and others are refused.

    Raises:
        InputError: MuJoCo refuses the file.
    """
    try:
        with without_warnings(mj):
            spec = _read(mj, file, text)
            if not meshes:
                _delete_meshes(spec, file)
            try:
                return spec, spec.compile(), []
            except ValueError as error:
                if "A + B >= C" not in str(error):
                    raise
            notes = list(_round_inertias(spec))
            return spec, spec.compile(), notes
    except InputError:
        raise
    except Exception as error:  # ValueError and others
        said = " ".join(str(error).split()).removeprefix("XML Error: ").removeprefix("Error: ")
        right = next((line for part, line in ADVICE.items() if part in said), "mend the file: MuJoCo must take it")
        _refuse(file, said[:1].lower() + said[1:], right)


def _read(mj: Any, file: Path, text: str) -> Any:
    if not text:
        return mj.MjSpec.from_file(str(file))
    if "<include" in text:
        _refuse(file, "is not in UTF-8, and includes other files", "save it as UTF-8")
    spec = mj.MjSpec.from_string(text)
    spec.modelfiledir = str(file.parent)
    return spec


def _delete_meshes(spec: Any, file: Path) -> None:
    """Take meshes out of a model, where the masses of bodies do not come of them."""
    for geom in [geom for geom in spec.geoms if geom.meshname]:
        body = geom.parent
        if not body.explicitinertial and body is not spec.worldbody and geom.mass != 0.0 and geom.density != 0.0:
            what = f"body {body.name!r} gets its mass of the mesh {geom.meshname!r}"
            _refuse(file, what, "give it an inertial, or take meshes along: without --no-meshes")
        spec.delete(geom)
    for mesh in list(spec.meshes):
        spec.delete(mesh)


def _round_inertias(spec: Any) -> Iterator[str]:
    """Set inertias that miss those of a body by rounding to the nearest one; yield a note on each."""
    for body in spec.bodies:
        if not body.explicitinertial:
            continue
        full = np.array(body.fullinertia, float)
        is_full = bool(np.isfinite(full).all())
        inertia = moments(full.tolist()) if is_full else np.diag(np.array(body.inertia, float))
        nearest = realizable_inertia(inertia)
        if nearest is None or nearest is inertia:
            continue
        if is_full:
            body.fullinertia = [*nearest.diagonal(), nearest[0, 1], nearest[0, 2], nearest[1, 2]]
        else:
            body.inertia = nearest.diagonal()
        share = np.abs(nearest - inertia).max() / np.abs(inertia).max()
        yield f"inertia of body {body.name!r} is rounded to that of no body: taken {share:.1g} of it smaller"


def _refuse(file: Path, what: str, right: str) -> NoReturn:
    raise InputError(what, where=str(file), right=right)
