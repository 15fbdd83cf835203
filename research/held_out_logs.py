"""Cross-validation with logs of the android's elbow: expected error of a new log, and its actual error.

    python -m research.held_out_logs FOLDER [--choices 5] [--left-out 2] [--seed 0]

FOLDER holds motion_data_*.csv (see measured_logs/affetto.py). Each choice leaves some logs out at random; the
first is 006 and 010, as in the example. Minutes each; outside of the tests.
"""

import argparse
import json
from pathlib import Path

import numpy as np

from layflat.identify.benches.loader import load_bench
from layflat.identify.benches.regulated import RegulatedModel
from layflat.identify.fit import Fit, fit_selected
from layflat.identify.logs import read_log

MAPPING = Path(__file__).parent / "measured_logs" / "affetto.toml"
ACCEPTED_FACTOR = 1.5  # of the expected to the actual error, within which it counts as right


def angle_errors(found: Fit, reading: float) -> dict[bool, list[float]]:
    """Return rms errors of the angle in % of its range, of fitted logs (False) and left-out ones (True)."""
    errors: dict[bool, list[float]] = {False: [], True: []}
    for quality in found.qualities():
        if quality.output == "angle":
            errors[quality.validation].append(100.0 * quality.rms / reading)
    return errors


def choices(names: list[str], count: int, left_out: int, seed: int) -> list[tuple[str, ...]]:
    """Return which logs are left out, the choice of the example first."""
    random = np.random.default_rng(seed)
    found: list[tuple[str, ...]] = [tuple(name for name in ("006", "010") if name in names)]
    while len(found) < count:
        drawn = tuple(sorted(map(str, random.choice(names, left_out, replace=False))))
        if drawn not in found:
            found.append(drawn)
    return found


def main() -> None:
    """Fit with some logs left out, and print what was expected and what was found."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--choices", type=int, default=5)
    parser.add_argument("--left-out", type=int, default=2)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, default=Path("build/held_out.json"))
    options = parser.parse_args()
    rig = load_bench("regulated-elbow")
    logs = {path.stem[-3:]: read_log(path, MAPPING) for path in sorted(options.folder.glob("motion_data_*.csv"))}
    right, rows = 0, list[dict[str, object]]()
    for left_out in choices(list(logs), options.choices, options.left_out, options.seed):
        fitted = {name: log for name, log in logs.items() if name not in left_out}
        found = fit_selected(RegulatedModel(rig, fitted, {name: logs[name] for name in left_out}, fitted_share=1.0))
        own, held = (angle_errors(found, rig.stroke.reading)[validation] for validation in (False, True))
        expected = next(100.0 * one.rms / rig.stroke.reading for one in found.expected if one.output == "angle")
        right += 1.0 / ACCEPTED_FACTOR <= expected / np.mean(held) <= ACCEPTED_FACTOR
        rows.append({"left_out": left_out, "own": own, "held": held, "expected": expected})
        rows[-1]["remarks"] = list(found.remarks)
        each = ", ".join(f"{name} {error:.1f}" for name, error in zip(left_out, held, strict=True))
        print(f"own {np.mean(own):.1f} %, expected {expected:.1f} %, found {np.mean(held):.1f} % ({each})", flush=True)
        print(f"  {' '.join(found.remarks)}", flush=True)
    print(f"expected within a factor of {ACCEPTED_FACTOR:g} of what was found: {right} of {len(rows)}")
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.write_text(json.dumps(rows, indent=2), encoding="utf-8")


if __name__ == "__main__":
    main()
