"""Compare arms of other packages before and after layflat, as other tools read them: `make conformance`."""

import argparse
import re
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.conformance import readers
from benchmarks.conformance.arms import FILES, Arm, Refused, arms
from benchmarks.conformance.readers import View
from layflat.bridge import save_arm
from layflat.bridge.losses import losses
from layflat.bridge.robots import ImportedArm, import_arm
from layflat.errors import LayflatError
from layflat.files import write_text
from layflat.machine import load

SAME = 1e-9  # difference as a share, of tools that take a file as it is
CLOSE = 1e-6  # likewise, of PyBullet, which goes by way of principal axes
HEAD = """# Arms of other packages, as other tools read them

This table lists, for each robot of five packages on PyPI, the longest open chain in it that layflat takes, and by how
much other tools' views of the exported arm differ from MuJoCo's view of the robot's own file. `make conformance` makes
it anew.

- **joints**: how many, and the tool that the robot's own file is compared in: Pinocchio where MuJoCo refuses a body
  that is not of the arm.
- **M, gravity**: the greatest difference of mass matrix and torques of gravity, as a share of the greatest item, at a
  random position of the joints; URDF is compared without armature, which it can't carry and the export says.
- **tip**, **limits**: the greatest difference between MuJoCo, Pinocchio, PyBullet and yourdfpy.
- **meshes**: how many MuJoCo (MJCF), PyBullet and yourdfpy (URDF) find.
- "refused" is the line that `layflat arm import` prints, with `--to` at the end of the longest chain.

"""
COLUMNS = (
    "| robot | joints | M, MJCF | M, URDF | M, Pinocchio | M, PyBullet | gravity | tip (mm) | limits (deg) | meshes |\n"
    "|---|---|---|---|---|---|---|---|---|---|"
)


def main() -> None:
    """Write the page and print its table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("docs/arm-conformance.md"))
    parser.add_argument("--only", nargs="*", choices=list(FILES), default=list(FILES), help="packages")
    options = parser.parse_args()
    rows, right = [], 0
    for arm in arms(options.only):
        line, is_right = _row(arm)
        right += is_right
        rows.append(line)
        print(line, flush=True)
    count = len(rows)
    summary = f"\n{right} of {count} files are the same arm in every tool, or are refused in one line.\n"
    table = "\n".join([COLUMNS, *rows])
    write_text(options.out, f"{HEAD}{table}\n{summary}")
    print(summary)


def _row(arm: Arm | Refused) -> tuple[str, bool]:
    start = f"| {arm.package}: {Path(arm.name).parent.name}/{Path(arm.name).name} "
    if isinstance(arm, Refused):
        return f"{start}| | refused: {arm.reason} | | | | | | | |", arm.reason != "is not installed"
    try:
        imported = _imported(arm)
    except LayflatError as error:
        reason = _tidy(str(error).removeprefix(f"{arm.file}: "))
        return f"{start}| | refused: {reason} | | | | | | | |", "\n" not in str(error)
    with TemporaryDirectory() as folder:
        return _compared(start, arm, imported, Path(folder))


def _imported(arm: Arm) -> ImportedArm:
    """Import an arm, once more with the folder of a package that the first message asks for."""
    try:
        return import_arm(arm.file, to=arm.to, stroke=arm.stroke)
    except LayflatError as error:
        package = re.search(r"--package (\S+)=FOLDER", str(error))
        if package is None:
            raise
        return import_arm(arm.file, to=arm.to, stroke=arm.stroke, packages={package[1]: arm.file.parents[1]})


def _compared(start: str, arm: Arm, imported: ImportedArm, folder: Path) -> tuple[str, bool]:
    machine = load(imported.save(folder)[0])
    mjcf, urdf = (save_arm(machine, folder / f"out{suffix}")[0] for suffix in (".xml", ".urdf"))
    joints = list(machine.joints)
    angles = np.random.default_rng(1).uniform(-0.4, 0.4, len(joints))
    positions = angles + np.array([turn.middle for turn in imported.turning])
    gravity = np.array(machine.arm.gravity, float)
    names = [link.name for link in imported.chain.robot.to(arm.to) if link.kind != "fixed"]
    tool, truth = readers.of_original(arm.file, names, positions, gravity)
    armature = np.diag([stage.joint.armature for stage in imported.chain.stages])
    views: dict[str, View] = {}
    views["MJCF"] = readers.in_mujoco(readers.original(mjcf), joints, angles, "tip")
    after = readers.as_it_is(urdf)
    views["URDF"] = readers.in_mujoco(after, joints, angles)
    views["Pinocchio"] = readers.in_pinocchio(urdf, joints, angles, gravity, "tool")
    views["PyBullet"] = readers.in_pybullet(urdf, joints, angles, gravity)
    views["yourdfpy"] = readers.in_yourdfpy(urdf, joints, angles)
    assert truth.mass is not None
    assert truth.pull is not None
    masses = {
        tool: _difference(view.mass, truth.mass if tool == "MJCF" else truth.mass - armature)
        for tool, view in views.items()
        if view.mass is not None
    }
    pulls = [_difference(view.pull, truth.pull) for view in views.values() if view.pull is not None]
    tips = np.array([view.tip for view in views.values() if view.tip is not None])
    ranges = np.array([view.limits for view in views.values() if view.limits is not None])
    spread: Callable[[np.ndarray], float] = lambda values: float(np.ptp(values, axis=0).max())  # noqa: E731
    meshes = " ".join(str(view.meshes) for tool, view in views.items() if tool in {"MJCF", "PyBullet", "yourdfpy"})
    tip, limits = 1e3 * spread(tips), float(np.degrees(spread(ranges)))
    said = bool(losses(machine, ".urdf")) or not armature.any()
    exact = max(masses["MJCF"], masses["URDF"], masses["Pinocchio"]) < SAME
    is_right = exact and said and max(masses["PyBullet"], *pulls) < CLOSE and max(tip, limits) < 1e-3
    figures = [f"{masses[tool]:.0e}" for tool in ("MJCF", "URDF", "Pinocchio", "PyBullet")]
    cells = [f"{len(joints)} ({tool})", *figures, f"{max(pulls):.0e}", f"{tip:.0e}", f"{limits:.0e}", meshes]
    return f"{start}| {' | '.join(cells)} |", is_right


def _tidy(text: str) -> str:
    """Return a message without the place of this computer's packages."""
    return re.sub(r"/\S*/site-packages/", "", text).replace("|", "\\|")


def _difference(ours: np.ndarray | None, theirs: np.ndarray) -> float:
    assert ours is not None
    return float(np.abs(ours - theirs).max() / max(np.abs(theirs).max(), 1e-9))


if __name__ == "__main__":
    main()
