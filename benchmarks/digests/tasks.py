"""What uses simulations: studies, identification, tuning, packing, design."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from benchmarks.digests.runs import MOVING, TURNED, Arrays


class NotPossibleError(Exception):
    """Something that an item needs is missing on this machine."""


GRID = """
name = "grid"
machine = "paper-small-joint"
sampling = "grid"
noise_seeds = 2

[[scenario]]
name = "step"
duration = "0.6 s"
demand = [["0 s", "-10 deg"], ["0.1 s", "10 deg"]]

[[scenario]]
name = "push"
duration = "0.6 s"
load = [["0.3 s", "3 N m"]]

[vary."joint.small.brake.torque"]
low = "0 N m"
high = "4 N m"
points = 4

[vary."scenario.payload"]
values = ["0 kg", "1 kg", "2 kg"]

[[variant]]
name = "as it is"

[[variant]]
name = "without dither"
set = { valve = { dither = { amplitude = 0.0 } } }
"""

SALTELLI = """
name = "saltelli"
machine = "paper-arm"
sampling = "saltelli"
runs = 4

[scenario]
duration = "0.6 s"
demand = [["0 s", ["0 deg", "0 deg"]], ["0.1 s", ["15 deg", "-10 deg"]]]

[vary."valve.conductance"]
low = 0.8
high = 1.2
relative = true

[vary."scenario.payload"]
low = "0 kg"
high = "2 kg"
"""


def studies() -> Arrays:
    """The tables of a grid with variants and of a sensitivity study."""
    from layflat.study import read_study, run_study, study_table  # noqa: PLC0415

    found: Arrays = {}
    for text in (GRID, SALTELLI):
        with TemporaryDirectory() as folder:
            path = Path(folder) / "study.toml"
            path.write_text(text, encoding="utf-8")
            study = read_study(path)
            run_study(study, Path(folder) / "out", chunk=16)
            rows = study_table(Path(folder) / "out").select_dtypes("number")
            found |= {f"{study.name}: {name}": rows[name].to_numpy(dtype=float) for name in rows.columns}
    return found


def identification() -> Arrays:
    """The friction of a joint, from logs of one that differs from its description."""
    from layflat import changed, load, rollout  # noqa: PLC0415
    from layflat.identify import identification as module  # noqa: PLC0415

    prepare = getattr(module, "prepare_identification", None) or getattr(module, "begin")  # noqa: B009  # earlier revisions
    machine = changed(load("paper-small-joint"), "joint.small.brake.torque", 3.1)
    machine = changed(machine, "joint.small.brake.viscous", 0.05)
    levels = (0.0, 0.35, -0.25, 0.4, -0.4, 0.1, 0.15, 0.0)
    header = "time [s],angle.small [deg],voltage.small [V],measured_pressure.small [bar]"
    with TemporaryDirectory() as folder:
        logs = [Path(folder) / f"log{seed}.csv" for seed in (0, 1)]
        for seed, path in enumerate(logs):
            log = rollout(machine, lambda t: [levels[int(2.0 * t) % 8]], duration=4.0, start=0.0, seed=seed)
            one = log.isel(joint=0)
            columns: list[Any] = [
                one["time"], np.degrees(one["measured_angle"]), one["voltage"], 1e-5 * one["measured_pressure"]
            ]  # fmt: skip
            np.savetxt(path, np.stack(columns, axis=1), delimiter=",", header=header, comments="", fmt="%.9g")
        session = prepare(logs[:1], "paper-small-joint", Path(folder), blocks="friction", validate=logs[1:])
        found = session.fit(starts=0)
    return {
        "values": found.values,
        "intervals": [(estimate.low, estimate.high) for estimate in found.estimates],
        "predicted": found.simulated,
        "errors": [quality.rms for quality in found.qualities()],
        "simulations": found.simulations,
    }


def tuning() -> Arrays:
    """Two generations of a search for gains."""
    from layflat.tune import begin_tuning  # noqa: PLC0415

    with TemporaryDirectory() as folder:
        found = begin_tuning("paper-small-joint", Path(folder), generations=2)
        found.search()
    history = getattr(found, "history", None) or getattr(found, "told")  # noqa: B009  # as earlier revisions name it
    return {"gains": [best.values for best in history], "costs": [best.cost for best in history]}


def packing() -> Arrays:
    """Two picks by a camera, and the state of the whole scene in every cycle."""
    from layflat.cell import load  # noqa: PLC0415
    from layflat.cell.work.run import calibrate_cell  # noqa: PLC0415
    from layflat.errors import NoDrawingError  # noqa: PLC0415

    try:
        calibration: Any = calibrate_cell(load("packing"))
    except NoDrawingError as error:
        raise NotPossibleError(str(error)) from error
    return packed(calibration)


def packing_blind() -> Arrays:
    """The same where nothing can be drawn."""
    return packed(None)


def packed(calibration: Any) -> Arrays:
    """Two picks."""
    from layflat.cell import load  # noqa: PLC0415
    from layflat.cell.work import run as work  # noqa: PLC0415
    from layflat.cell.work.observer import Observer  # noqa: PLC0415

    states: list[Any] = []

    class Watcher(Observer):
        def on_delivery_start(self, scene: Any, camera: Any) -> None:  # noqa: ARG002
            self.scene = scene

        def on_control_cycle(self, time: float) -> None:
            states.append([time, *self.scene.data.qpos])

    (delivery,) = work.run_packing(load("packing"), 0, 2, calibration, Watcher()).deliveries
    seen = [pick.choice.fruit for pick in delivery.picks]
    true = delivery.verdicts
    return {
        "scene": states,
        "time": delivery.time,
        "seen": [(fruit.x, fruit.y, fruit.diameter, fruit.confidence) for fruit in seen],
        "picks": [(pick.begin, pick.end, pick.air, pick.tries) for pick in delivery.picks],
        "truth": [(one.correct, one.release_error, one.peak_acceleration, one.press) for one in true],
        "vision": [*delivery.vision.positions, *delivery.vision.diameters, delivery.vision.false],
    }


def designs() -> Arrays:
    """What the design says of every joint of every built-in machine."""
    from layflat import design_joint, load  # noqa: PLC0415

    found: Arrays = {}
    for name in sorted({*MOVING, *TURNED}):
        for joint in load(name).joints:
            design = design_joint(name, joint, strict=False)
            found |= {
                f"{name} {joint}: {key}": value
                for key, value in {
                    "torque": np.stack(design.torque),
                    "tension": design.tension,
                    "stresses": [stress.total for stress in design.stresses],
                    "mass": [*design.mass.parts.values(), design.mass.uncounted],
                    "air": design.air.normal_litres,
                    **({} if design.cam is None else {"cam": design.cam.profile}),
                }.items()
            }
    return found
