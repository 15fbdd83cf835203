"""Friction of a small cylinder from its force loops, fitted at some pressures and validated at another.

    python -m research.measured_logs.zillen FOLDER [--validate 5bar]

FOLDER holds logs named SEAL_PRESSURE.csv (such as KDN_5bar.csv), with tab-separated columns without a header: time
(ms), laser (V), pressure (V), force (V), position (mm), pressure (bar, gauge), force (N). Each seal is fitted at all
pressures but one and predicted there. Writes build/measured-logs/zillen.png and zillen.json.
"""

import argparse
import json
from pathlib import Path

import numpy as np
import xarray

from layflat.errors import InputError
from layflat.identify import Fit, fit
from layflat.identify.benches.hysteresis import curve_errors
from layflat.identify.benches.loader import load_bench
from layflat.identify.benches.rod import RodModel
from layflat.plot.style import HEAD_ROOM, SERIES_STYLES, save_figure, styled_figure

OUT = Path("build/measured-logs")
RIG = load_bench("friction-rig")


def read(path: Path) -> xarray.Dataset:
    """Return a log in SI units, with absolute pressure."""
    time, position, pressure, force = np.loadtxt(path, usecols=(0, 4, 5, 6), unpack=True)
    return xarray.Dataset(
        {
            "position": ("time", 1e-3 * position),
            "pressure": ("time", 1e5 * pressure + RIG.ambient_pressure),
            "force": ("time", force),
        },
        {"time": 1e-3 * (time - time[0])},
    )


def draw(fits: dict[str, Fit], validation: str) -> None:
    """Draw the measured and the predicted loop of each seal at the pressure that was not fitted."""
    rows = -(-len(fits) // 2)
    with styled_figure(rows, 2, width=8.4, height=2.6 * rows + 1.0, above=HEAD_ROOM + 0.25) as (made, axes):
        for ax in axes[len(fits) :]:
            ax.set_visible(False)
        for ax, (seal, found) in zip(axes, fits.items(), strict=False):
            x = 1e3 * found.model.motions[-1]  # type: ignore[attr-defined]
            measured, predicted = found.model.outputs[-1].measured, found.simulated[found.model.slices[-1]]
            ax.plot(x, measured, color="#8a8a8a", linewidth=0.7, label="measured")
            ax.plot(x, predicted, **{**SERIES_STYLES[1], "linestyle": "-", "linewidth": 0.9}, label="predicted")
            low, high = np.percentile(measured, [0.1, 99.9])
            ax.set_ylim(low - 0.12 * (high - low), high + 0.35 * (high - low))
            error = curve_errors(found.model, found.simulated)[-1]  # type: ignore[arg-type]
            ax.text(0.5, 0.9, f"{seal}: rms error {error.raw:.1%} of the height", transform=ax.transAxes, ha="center")
            ax.set_ylabel("Force (N)")
        for ax in axes[-2:]:
            ax.set_xlabel("Position (mm)")
        handles, labels = axes[0].get_legend_handles_labels()
        made.legend(
            handles, labels, loc="upper center", ncols=2, title=f"Force at {validation}, fitted at the other pressures"
        )
    save_figure(made, OUT / "zillen.png")


def main() -> None:
    """Fit, validate and draw."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--validate", default="5bar", help="the pressure that is not fitted, as in the names")
    given = parser.parse_args()
    logs: dict[str, dict[str, Path]] = {}
    for path in sorted(given.folder.glob("*_*bar.csv")):
        seal, _, pressure = path.stem.rpartition("_")
        logs.setdefault(seal, {})[pressure] = path
    logs = {seal: paths for seal, paths in logs.items() if given.validate in paths and len(paths) > 1}
    if not logs:
        right = "give a folder with logs of a seal at that pressure and at others"
        parser.exit(
            2, f"{InputError(f'no SEAL_{given.validate}.csv to judge', where=str(given.folder), right=right)}\n"
        )
    fits, figures = {}, {}
    for seal, paths in logs.items():
        validation = read(paths.pop(given.validate))
        model = RodModel(RIG, {pressure: read(path) for pressure, path in paths.items()}, {given.validate: validation})
        fits[seal] = found = fit(model, starts=0)  # linear least squares begin near enough
        figures[seal] = {
            "errors": [vars(error) for error in curve_errors(model, found.simulated)],
            "rig": json.loads(model.describe(found.values).model_dump_json()),
            "trusted": found.trusted,
            "remarks": list(model.remarks),
        }
        error = curve_errors(model, found.simulated)[-1]
        print(
            f"{seal:12s} {given.validate}: rms error {error.raw:.1%} of the height {error.height:.1f} N; "
            f"{error.friction:.1%} without the mean error"
        )
    OUT.mkdir(parents=True, exist_ok=True)
    (OUT / "zillen.json").write_text(json.dumps(figures, indent=2) + "\n", encoding="utf-8")
    draw(fits, given.validate)


if __name__ == "__main__":
    main()
