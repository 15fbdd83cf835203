"""Fit of logs of vessels that fill or empty: `python -m research.measured_logs.vessel FOLDER`.

Fits every NAME.csv with NAME.rig.yml beside it (the files of HydDown) in FOLDER; without one, a simulated blow-down of
the built-in vessel with some noise. Each is fitted whole, and then its first two thirds, which have to predict the
rest. Writes build/measured-logs/vessel-NAME.png and vessel.json.
"""

import json
import sys
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray

from layflat.identify import Fit, fit
from layflat.identify.benches.loader import load_bench
from layflat.identify.benches.vessel import VesselBench, VesselModel
from layflat.physics.flow import effective_area
from layflat.plot.style import GUIDE_STYLE, SERIES_STYLES, save_figure, styled_figure

OUT = Path("build/measured-logs")


def read(path: Path) -> xarray.Dataset:
    """Return points read off curves, from the start of the blow-down on; the mean of the hottest and coldest gas."""
    points = pd.read_csv(path)
    points["value"] *= points["unit"].map({"bar_abs": 1e5, "K": 1.0})
    curves = {str(name): of.sort_values("time_s") for name, of in points.groupby("signal", sort=False)}
    series = {}
    for signal, begin in (("pressure", "gas_pressure"), ("temperature", "T_gas"), ("wall_temperature", "T_wall")):
        alike = [curve for name, curve in curves.items() if name.startswith(begin)]
        if alike:
            since, until = (max(c["time_s"].min() for c in alike), min(c["time_s"].max() for c in alike))
            time = np.unique(alike[0]["time_s"])
            time = time[(time >= since) & (time <= until)]
            mean = np.mean([np.interp(time, c["time_s"], c["value"]) for c in alike], axis=0)
            series[signal] = pd.Series(mean, index=time)
    table = pd.DataFrame(series)
    table = table.reindex(table.index.union([0.0]))
    return xarray.Dataset({name: ("time", table[name]) for name in table}, {"time": table.index})


def simulated(rig: VesselBench) -> xarray.Dataset:
    """Return a simulated log of a vessel, with 1 kPa of noise."""
    time = np.linspace(0.0, 60.0, 61)
    blank = xarray.Dataset({name: ("time", np.full(61, 3e5)) for name in ("pressure", "temperature")}, {"time": time})
    model = VesselModel(rig, {"log": blank})
    truth = [rig.start.pressure if one.path.startswith("start.") else one.guess for one in model.unknowns]
    pressure, temperature, _ = model.run(model.logs[0], np.array([truth]))[0].T
    noise = 1e3 * np.random.default_rng(1).standard_normal(61)
    return blank.assign(pressure=("time", pressure + noise), temperature=("time", temperature))


def draw(whole: Fit, early: Fit, path: Path) -> None:
    """Draw pressure, its error and the temperatures: measured, fitted to all, and fitted left of the grey line."""
    with styled_figure(3, 1, width=6.4, height=7.2, beside=0.1) as (made, (pressures, errors, temperatures)):
        for place, one in zip(early.model.slices, early.model.outputs, strict=True):
            axes, unit = (pressures, 1e5) if one.name == "pressure" else (temperatures, 1.0)
            wall = one.name == "wall_temperature"
            look: dict[str, Any] = {"marker": "s", "mfc": "none"} if wall else {"marker": "o"}
            axes.plot(one.time, one.measured / unit, "k", ls="", ms=3, label="wall" if wall else "measured", **look)
            for order, (found, label) in enumerate(((whole, "fitted to all"), (early, "fitted to two thirds"))):
                axes.plot(
                    one.time, found.simulated[place] / unit, label=None if wall else label, **SERIES_STYLES[order]
                )
                if one.name == "pressure":
                    error = (found.simulated[place] - one.measured) / 1e3
                    errors.plot(one.time, error, marker="o", ms=3, **SERIES_STYLES[order])
                    errors.axvline(early.model.outputs[0].time[early.model.outputs[0].fitted][-1], **GUIDE_STYLE)
        pressures.set_ylabel("Pressure (bar)")
        errors.set_ylabel("Error of pressure (kPa)")
        temperatures.set_ylabel("Temperature (K)")
        temperatures.set_xlabel("Time (s)")
        pressures.legend()
        if len(early.model.outputs) > 2:
            temperatures.legend(ncols=2, fontsize=8)
    save_figure(made, path)


def figures(found: Fit, rig: VesselBench) -> dict[str, Any]:
    """Values with their intervals, and rms errors."""
    values = {
        one.unknown.path: {
            "value": one.value,
            "low": one.low,
            "high": one.high,
            "unit": one.unknown.unit,
            "identified": bool(one.identified),
        }
        for one in found.estimates
    }
    if rig.path.hole is not None:
        C = found.estimate("path.conductance")
        of_hole = pi / 4 * rig.path.hole**2
        low, value, high = (float(effective_area(one) / of_hole) for one in (C.low, C.value, C.high))
        values["discharge coefficient"] = {
            "value": value,
            "low": low,
            "high": high,
            "unit": "1",
            "identified": bool(C.identified),
        }
    quality = {
        f"{one.output} {'validation' if one.validation else 'fitted'}": {
            "rms": one.rms,
            "unit": one.unit,
            "samples": one.samples,
        }
        for one in found.qualities()
    }
    return {"values": values, "errors": quality}


def main(folder: Path | None) -> None:
    """Fit, draw and print."""
    if folder is None:
        rig = load_bench("blow-down-vessel")
        cases = {rig.name: (rig, simulated(rig))}
    else:
        pairs = [(path, path.with_name(f"{path.stem}.rig.yml")) for path in sorted(folder.glob("*.csv"))]
        cases = {p.stem: (load_bench(rig), read(p)) for p, rig in pairs if rig.exists()}
    told = {}
    for name, (rig, log) in cases.items():
        whole = fit(VesselModel(rig, {name: log}, fitted_share=1.0))
        early = fit(VesselModel(rig, {name: log}))
        told[name] = {"all": figures(whole, rig), "first two thirds": figures(early, rig)}
        draw(whole, early, OUT / f"vessel-{name}.png")
        start = whole.estimate(f"start.pressure.{name}").value
        print(f"{name}: {rig.title}, from {start / 1e5:.2f} bar")
        for found, text in ((whole, "fitted to all"), (early, "fitted to the first two thirds")):
            print(f"  {text}: {', '.join(rms_errors(found))} (rms)")
        for path, one in told[name]["all"]["values"].items():
            known = "" if one["identified"] else "  not identifiable from this log"
            print(f"    {path:32s} {one['value']:10.4g} ({one['low']:.4g} to {one['high']:.4g}) {one['unit']}{known}")
    OUT.mkdir(parents=True, exist_ok=True)
    (OUT / "vessel.json").write_text(json.dumps(told, indent=2))


def rms_errors(found: Fit) -> list[str]:
    """Return the rms error of every signal as text."""
    return [
        f"{one.output} {'predicted' if one.validation else 'fitted'} "
        + (f"{one.rms / 1e3:.2f} kPa" if one.unit == "Pa" else f"{one.rms:.1f} {one.unit}")
        for one in found.qualities()
    ]


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else None)
