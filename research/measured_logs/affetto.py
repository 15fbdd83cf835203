"""Fit of the logs of a pneumatic android's elbow, all together, and prediction of others from their commands alone.

    python -m research.measured_logs.affetto FOLDER [--validate 006,010] [--out build/measured-logs]

FOLDER holds motion_data_*.csv of the project affetto-nn-ctrl (Osaka University, MIT licence); affetto.toml maps their
columns. Writes a figure, and all errors and values as JSON.
"""

import argparse
import json
import sys
import time
from dataclasses import asdict
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from layflat.errors import InputError, LayflatError
from layflat.files import whole_file
from layflat.identify import Fit
from layflat.identify.benches.loader import load_bench
from layflat.identify.benches.regulated import RegulatedModel
from layflat.identify.fit import fit_selected
from layflat.identify.logs import read_log
from layflat.identify.report_text import describe_expected_errors
from layflat.plot.runs import ComparedSignal, measured_and_simulated
from layflat.plot.style import save_figure

MAPPING = Path(__file__).with_suffix(".toml")


def errors(found: Fit, reading: float) -> dict[str, dict[str, float | bool]]:
    """Return the rms errors of each log: angle in % of the reading, pressures in kPa."""
    logs: dict[str, dict[str, float | bool]] = {}
    for quality in found.qualities():
        own = logs.setdefault(quality.log, {"validation": quality.validation})
        if quality.output == "angle":
            own["angle_percent"] = 100.0 * quality.rms / reading
        elif quality.unit == "Pa":
            own[f"{quality.output}_kpa"] = 1e-3 * quality.rms
    return logs


def compared(found: Fit, name: str, fitted: bool) -> list[ComparedSignal]:
    """Return the signals of a log beside those predicted from its set-points alone."""
    model = found.model
    assert isinstance(model, RegulatedModel)
    course = next(log.signals for log in model.logs if log.name == name)
    places = {o.name: found.simulated[s] for o, s in zip(model.outputs, model.slices, strict=True) if o.log == name}
    mask = np.full(len(course.time), fitted)
    return [
        ComparedSignal(
            f"{name} {signal}", unit, course.time, scale * getattr(course, signal), scale * places[signal], mask
        )
        for signal, unit, scale in (
            ("angle", "deg", np.degrees(1.0)),
            ("pressure_a", "kPa", 1e-3),
            ("pressure_b", "kPa", 1e-3),
        )
    ]


def tables(logs: dict[str, dict[str, float | bool]], found: Fit) -> list[Table]:
    """Return tables of the errors of the logs and of the fitted values."""
    first = Table("log", "", "angle (% rms)", "pressure A (kPa rms)", "pressure B (kPa rms)")
    for name, own in logs.items():
        kind = "validation" if own["validation"] else "fitted"
        numbers = [f"{own[key]:.1f}" for key in ("angle_percent", "pressure_a_kpa", "pressure_b_kpa")]
        first.add_row(name, kind, *numbers)
    second = Table("value", "found", "95 % interval", "unit", "")
    for one in found.estimates:
        remark = "" if one.identified else "not identifiable from these logs"
        second.add_row(
            one.unknown.path, f"{one.value:.3g}", f"{one.low:.3g} .. {one.high:.3g}", one.unknown.unit, remark
        )
    return [first, second]


def main() -> None:
    """Fit, print and draw."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--validate", default="006,010", help="logs that are only predicted, by their numbers")
    parser.add_argument("--out", type=Path, default=Path("build/measured-logs"))
    given = parser.parse_args()
    rig = load_bench("regulated-elbow")
    paths = sorted(given.folder.glob("motion_data_*.csv"))
    if not paths:
        raise InputError("holds no motion_data_*.csv", where=str(given.folder), right="give the folder of the logs")
    logs = {path.stem.rsplit("_", 1)[-1]: read_log(path, MAPPING) for path in paths}
    validation = given.validate.split(",") if given.validate else []
    others = {name: logs.pop(name) for name in validation}
    model = RegulatedModel(rig, logs, others, fitted_share=1.0)
    began = time.perf_counter()
    with Progress(console=Console(stderr=True), transient=True, disable=not sys.stderr.isatty()) as bar:
        task = bar.add_task("fitting", total=1.0)
        found = fit_selected(model, progress=lambda share, text: bar.update(task, completed=share, description=text))
    seconds = time.perf_counter() - began
    by_log = errors(found, rig.stroke.reading)
    console = Console(width=100)
    for table in tables(by_log, found):
        console.print(table)
    print(*found.remarks, describe_expected_errors(found), sep="\n")
    drawn = [compared(found, name, name not in validation) for name in validation or list(logs)[:2]]
    picture = measured_and_simulated([signal for signals in drawn for signal in signals])
    print(f"wrote {save_figure(picture, given.out / 'affetto.png')}")
    values = {
        one.unknown.path: {"value": one.value, "low": one.low, "high": one.high, "unit": one.unknown.unit}
        for one in found.estimates
    }
    out = given.out / "affetto.json"
    with whole_file(out) as temporary:
        report = {
            "logs": by_log,
            "values": values,
            "converged": found.converged,
            "expected": [asdict(one) for one in found.expected],
            "seconds": round(seconds, 1),
        }
        temporary.write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")
    print(f"wrote {out} after a fit of {seconds:.0f} s")


if __name__ == "__main__":
    try:
        main()
    except LayflatError as error:
        print(error, file=sys.stderr)
        sys.exit(2)
