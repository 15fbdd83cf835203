"""Files and names that some pages take for given: logs of a bench and of a rig, files of an earlier version."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from layflat.machine import load
from layflat.sim import rollout
from layflat.sim.dataset import save_run
from tests.docs.blocks import ROOT

JOINT = "paper-small-joint"
MOVES = [("0 s", "0 deg"), ("0.4 s", "35 deg"), ("1.4 s", "-40 deg")]


def write_bench_log(folder: Path) -> dict[str, Any]:
    """Write a log of a bench with columns of its own, a run, and the description of the joint on the bench."""
    run = rollout(JOINT, MOVES, duration="2.5 s")
    save_run(run, folder / "run.nc")
    joint = run.sel(joint="small")
    table = np.stack([1e3 * run["time"], np.degrees(joint["measured_angle"]), joint["voltage"]], axis=1)
    header = "t [ms],theta [deg],valve [V]"
    np.savetxt(folder / "bench.csv", table, delimiter=",", header=header, comments="", fmt="%.9g")
    (folder / "mine.toml").write_text(f'extends = "{JOINT}"\nname = "mine"\n', encoding="utf-8")
    return {}


def write_rig_log(folder: Path) -> dict[str, Any]:
    """Write a log as a recorder of a rig leaves it when it is killed."""
    from layflat.rig.record import SHARED_COLUMNS, RowLayout
    from layflat.rig.recorder.bag import BagWriter, LogHeading
    from tests.rig.recorder.rigrows import BEGIN

    machine = load(JOINT)
    run = rollout(machine, MOVES, duration="2.5 s")
    layout = RowLayout.for_machine(machine)
    rows = np.zeros((run.sizes["time"], layout.width))
    rows[:, 0] = run["time"]
    rows[:, 1] = 1.7e9 + rows[:, 0]
    rows[:, layout.shared["supply"]] = run["supply"]
    for column, name in enumerate(layout.by_joint, start=len(SHARED_COLUMNS)):
        rows[:, column] = run[name][:, 0] if name in run else 0.0
    with (folder / "run.mcap.part").open("wb") as file:
        BagWriter(file, LogHeading.for_machine(machine, driver="simulated"), BEGIN, chunked=False).add(rows)
    return {}


def write_descriptions(folder: Path) -> dict[str, Any]:
    """Write a machine and a study of an earlier version."""
    text = 'extends = "paper-arm-adjustable"\nname = "mine"\n\n[joint.small.regulator]\nleast = 0.05\n'
    (folder / "mine.toml").write_text(text, encoding="utf-8")
    study = ROOT / "src/layflat/study/builtin/brake-and-inertia.toml"
    (folder / "study.toml").write_text(study.read_text(encoding="utf-8"), encoding="utf-8")
    return {}


SETUPS: dict[str, Callable[[Path], dict[str, Any]]] = {
    "conventions": write_descriptions,
    "logs": write_bench_log,
    "rig-logs": write_rig_log,
}
"""Functions that prepare the folder of a page, by its name, and return names for its code."""
