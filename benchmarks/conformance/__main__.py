"""Compare arms of other packages before and after layflat, as other tools read them: `make conformance`."""

import argparse
import re
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np

from benchmarks.conformance import readers
from benchmarks.conformance.arms import FILES, Arm, Refused, arms
from benchmarks.conformance.readers import View
from layflat.bridge import save_arm
from layflat.bridge.arm import conversion_losses
from layflat.bridge.robots import ChainEnds, ImportedArm, import_arm
from layflat.errors import LayflatError
from layflat.files import write_text
from layflat.machine import load

SAME = 1e-9  # difference as a share, of tools that take a file as it is
CLOSE = 1e-6  # likewise, of PyBullet, which goes by way of principal axes
HEAD = """# Arms of other packages, as other tools read them

This reference lists, for each robot of five packages on PyPI, the longest open chain in it that layflat imports, and by
how much other tools' views of the exported arm differ from MuJoCo's view of the robot's own file. `make conformance`
generates it.

- **joints**: how many; the robot's own file is compared in MuJoCo, or in Pinocchio where MuJoCo refuses a body that is
  not of the arm.
- **M**: the greatest difference of the mass matrix in MuJoCo (MJCF and URDF) and in Pinocchio, as a fraction of the
  greatest item, at random joint angles; URDF is compared without armature, which it can't carry.
- **PyBullet**: likewise.
- **gravity**: likewise, of the torques of gravity, in all of them.
- **tip**: the greatest difference between MuJoCo, Pinocchio, PyBullet and yourdfpy.
- **meshes**: how many MuJoCo (MJCF), PyBullet and yourdfpy (URDF) find; one number where all find the same.

"""
COMPARED_HEAD = "| robot | joints | M | PyBullet | gravity | tip (mm) | meshes |\n|---|---|---|---|---|---|---|"
REFUSED_HEAD = """## Refused
`layflat arm import`, with `--to` at the end of the longest chain, prints these lines.

| robot | line |
|---|---|"""


class Row(NamedTuple):
    """Row of the page."""

    cells: tuple[str, ...]
    right: bool  # whether the arm is the same in every tool, or is refused in one line
    refused: bool
    limits: float = 0.0  # greatest difference of the limits between tools, deg

    def __str__(self) -> str:
        """Return the row in Markdown."""
        return f"| {' | '.join(self.cells)} |"


def main() -> None:
    """Write the page and print its table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("docs/arm-conformance.md"))
    parser.add_argument("--only", nargs="*", choices=list(FILES), default=list(FILES), help="packages")
    options = parser.parse_args()
    rows = []
    for arm in arms(options.only):
        rows.append(_row(arm))
        print(rows[-1], flush=True)
    compared = "\n".join([COMPARED_HEAD, *(str(row) for row in rows if not row.refused)])
    refused = "\n".join([REFUSED_HEAD, *(str(row) for row in rows if row.refused)])
    summary = (
        f"{sum(row.right for row in rows)} of {len(rows)} files are the same arm in every tool, "
        f"or are refused in one line. Limits of joints differ by {max(row.limits for row in rows):.0e} deg at most.\n"
    )
    write_text(options.out, f"{HEAD}{compared}\n\n{summary}\n{refused}\n")
    print(summary)


def _row(arm: Arm | Refused) -> Row:
    name = f"{arm.package}: {Path(arm.name).parent.name}/{Path(arm.name).name}"
    if isinstance(arm, Refused):
        return Row((name, arm.reason), arm.reason != "is not installed", refused=True)
    try:
        imported = _imported(arm)
    except LayflatError as error:
        reason = _tidy(str(error).removeprefix(f"{arm.file}: "))
        return Row((name, reason), "\n" not in str(error), refused=True)
    with TemporaryDirectory() as folder:
        return _compared(name, arm, imported, Path(folder))


def _imported(arm: Arm) -> ImportedArm:
    """Import an arm, once more with the folder of a package that the first message asks for."""
    try:
        return import_arm(arm.file, ends=ChainEnds(to=arm.to), stroke=arm.stroke)
    except LayflatError as error:
        package = re.search(r"--package (\S+)=FOLDER", str(error))
        if package is None:
            raise
        return import_arm(
            arm.file, ends=ChainEnds(to=arm.to), stroke=arm.stroke, packages={package[1]: arm.file.parents[1]}
        )


def _compared(name: str, arm: Arm, imported: ImportedArm, folder: Path) -> Row:
    machine = load(imported.save(folder)[0])
    mjcf, urdf = (save_arm(machine, folder / f"out{suffix}")[0] for suffix in (".xml", ".urdf"))
    joints = list(machine.joints)
    angles = np.random.default_rng(1).uniform(-0.4, 0.4, len(joints))
    positions = angles + np.array([turn.middle for turn in imported.turning])
    gravity = np.array(machine.arm.gravity, float)
    names = [link.name for link in imported.chain.robot.links_to(arm.to) if link.kind != "fixed"]
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
    meshes = [str(view.meshes) for tool, view in views.items() if tool in {"MJCF", "PyBullet", "yourdfpy"}]
    tip, limits = 1e3 * spread(tips), float(np.degrees(spread(ranges)))
    said = bool(conversion_losses(machine, ".urdf")) or not armature.any()
    exact = max(masses["MJCF"], masses["URDF"], masses["Pinocchio"])
    right = exact < SAME and said and max(masses["PyBullet"], *pulls) < CLOSE and max(tip, limits) < 1e-3
    count = f"{len(joints)}" if tool == "MuJoCo" else f"{len(joints)} ({tool})"
    figures = [f"{value:.0e}" for value in (exact, masses["PyBullet"], max(pulls), tip)]
    cells = (name, count, *figures, " ".join(meshes if len(set(meshes)) > 1 else meshes[:1]))
    return Row(cells, right, refused=False, limits=limits)


def _tidy(text: str) -> str:
    """Return a message without the place of this computer's packages."""
    return re.sub(r"/\S*/site-packages/", "", text).replace("|", "\\|")


def _difference(ours: np.ndarray | None, theirs: np.ndarray) -> float:
    assert ours is not None
    return float(np.abs(ours - theirs).max() / max(np.abs(theirs).max(), 1e-9))


if __name__ == "__main__":
    main()
