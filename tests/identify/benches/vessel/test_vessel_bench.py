"""What logs of a vessel tell, from simulated ones whose truth is known; and from measured ones."""

from collections.abc import Mapping
from pathlib import Path
from typing import cast

import numpy as np
import pytest
import xarray
from numpy.typing import NDArray

from layflat.errors import InputError
from layflat.identify import Fit, fit
from layflat.identify.benches.loader import build_bench, load_bench
from layflat.identify.benches.vessel import Gas, GasConditions, VesselBench, VesselModel
from layflat.identify.logs import read_log

pytestmark = pytest.mark.compiled

Array = NDArray[np.float64]

TRUTH = {"path.conductance": 4e-9, "path.critical_ratio": 0.28, "space.volume": 3.3e-4, "wall.conductance": 0.25}
"""Of a hose's chamber with its joint locked."""

NOISE = 150.0
"""Of the pressure sensor, Pa."""

ADDED = 5e-4
"""Volume that is joined to the chamber for a second log, m3."""


ROOM = {"pressure": "101325 Pa", "temperature": "293.15 K"}


def chamber(values: Mapping[str, float]) -> VesselBench:
    tables = {
        "kind": "vessel",
        "name": "chamber",
        "title": "a hose's chamber",
        "gas": {"name": "air", "law": "ideal"},
        "space": {"volume": f"{values['space.volume']} m^3", "area": "0.05 m^2", "diameter": "50 mm"},
        "wall": {"natural": 0.0, "forced": 0.0, "conductance": f"{values['wall.conductance']} W/K"},
        "path": {
            "conductance": f"{values['path.conductance']} m^3/s/Pa",
            "critical_ratio": values["path.critical_ratio"],
        },
    }
    return cast(VesselBench, build_bench(tables | dict.fromkeys(("outside", "ambient", "start"), ROOM), "chamber"))


def simulated(seed: int, added: float = 0.0) -> xarray.Dataset:
    """Filled from 5 bar, then vented."""
    time = np.arange(0.0, 3.0, 0.01)
    supply = np.where(time < 1.5, 5e5, 101325.0)
    log = xarray.Dataset({"supply": ("time", supply), "pressure": ("time", np.full(300, 1e5))}, {"time": time})
    model = VesselModel(chamber(TRUTH), {"log": log}, added_volumes={"log": added})
    truth = np.array([TRUTH.get(unknown.path, 101325.0) for unknown in model.unknowns])
    noise = NOISE * np.random.default_rng(seed).standard_normal(300)
    return log.assign(pressure=("time", model.simulate(truth[None])[0] + noise))


def guessed() -> VesselBench:
    wrong = {"path.conductance": 1.6, "path.critical_ratio": 1.5, "space.volume": 0.6, "wall.conductance": 2.0}
    return chamber({path: value * wrong[path] for path, value in TRUTH.items()})


def test_two_volumes_tell_everything_within_the_intervals() -> None:
    logs = {"alone": simulated(1), "joined": simulated(2, ADDED)}
    found = fit(VesselModel(guessed(), logs, volume=True, added_volumes={"joined": ADDED}), starts=4)
    assert found.trusted
    for path, truth in TRUTH.items():
        estimate = found.estimate(path)
        assert estimate.low < truth < estimate.high, path
        assert estimate.identified, path
    for quality in found.qualities():
        assert quality.rms == pytest.approx(NOISE, rel=0.15)


def test_one_volume_does_not_tell_volume_and_conductance() -> None:
    found = fit(VesselModel(guessed(), {"alone": simulated(1)}, volume=True), starts=4)
    C, V = found.estimate("path.conductance"), found.estimate("space.volume")
    assert not C.identified
    assert not V.identified
    assert {C.partner, V.partner} <= {"path.conductance", "space.volume", "wall.conductance"}
    assert C.partner is not None
    assert C.value / V.value == pytest.approx(TRUTH["path.conductance"] / TRUTH["space.volume"], rel=0.01)
    held = fit(VesselModel(guessed(), {"alone": simulated(1)}), starts=4)
    assert held.estimate("path.conductance").identified
    ratio = held.estimate("path.conductance").value / guessed().space.volume
    assert ratio == pytest.approx(TRUTH["path.conductance"] / TRUTH["space.volume"], rel=0.01)


def blow_down(**parts: object) -> tuple[VesselBench, xarray.Dataset]:
    """The built-in vessel, its pressure and temperature read off now and then."""
    rig = cast(VesselBench, load_bench("blow-down-vessel")).model_copy(update=parts)
    time = np.linspace(0.0, 60.0, 25)
    empty = {name: ("time", np.full(25, 300.0)) for name in ("pressure", "temperature")}
    model = VesselModel(rig, {"log": xarray.Dataset(empty, {"time": time})})
    start = {unknown.path: unknown.guess for unknown in model.unknowns} | {"start.pressure.log": rig.start.pressure}
    found = model.run(model.logs[0], np.array([list(start.values())]))[0]
    noise = 300.0 * np.random.default_rng(3).standard_normal(25)
    return rig, xarray.Dataset(
        {"pressure": ("time", found[:, 0] + noise), "temperature": ("time", found[:, 1])}, {"time": time}
    )


def test_a_blow_down_tells_natural_convection_and_predicts_the_temperature() -> None:
    rig, log = blow_down()
    off = rig.model_copy(update={"wall": rig.wall.model_copy(update={"natural": 0.3})})
    found = fit(VesselModel(off, {"log": log}), starts=4)
    natural, C = found.estimate("wall.natural"), found.estimate("path.conductance")
    assert natural.low < rig.wall.natural < natural.high
    assert C.low < rig.path.conductance < C.high
    temperature = next(quality for quality in found.qualities() if quality.output == "temperature")
    assert temperature.validation
    assert temperature.rms < 2.0


def test_a_fill_from_vacuum_is_fitted_with_its_jet() -> None:
    beyond = GasConditions.model_construct(pressure=1e5, temperature=295.0)
    empty = GasConditions.model_construct(pressure=4e3, temperature=295.0)
    rig, log = blow_down(outside=beyond, start=empty)
    model = VesselModel(rig, {"log": log})
    assert {"wall.forced", "outside.pressure"} <= {unknown.path for unknown in model.unknowns}
    found = fit(model, starts=2)
    assert found.qualities()[0].rms < 450.0


def test_what_is_judged_does_not_act_on_the_fit() -> None:
    rig, log = blow_down()
    spoilt = log.assign(pressure=log["pressure"].where(log["time"] < 41.0, 9e5))
    values = [fit(VesselModel(rig, {"log": one}, fitted_share=2 / 3), starts=0).values for one in (log, spoilt)]
    np.testing.assert_array_equal(values[0], values[1])
    other = VesselModel(rig, {"a": log}, {"b": log})
    assert [output.fitted.all() for output in other.outputs if output.name == "pressure"] == [True, False]
    assert not any(output.fitted.any() for output in other.outputs if output.log == "b")


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"blocks": ["flows"]}, "blocks: unknown block 'flows'; choose from flow, gas"),
        ({"added_volumes": {"other": 1e-3}}, "added_volumes: unknown log 'other'; choose from log"),
        ({"fitted_share": 1.5}, "fitted_share: 1.5 is out of range"),
        ({"fitted_signals": ["force"]}, "fitted_signals: unknown signal 'force'"),
    ],
)
def test_a_wrong_option_is_one_line(options: dict[str, object], said: str) -> None:
    rig, log = blow_down()
    with pytest.raises(InputError) as caught:
        VesselModel(rig, {"log": log}, **options)  # type: ignore[arg-type]
    assert str(caught.value).startswith(said)


def test_a_log_without_pressure_or_with_gaps_in_its_supply_is_one_line() -> None:
    rig, log = blow_down()
    with pytest.raises(InputError, match=r"^log: has fewer than 3 samples of pressure"):
        VesselModel(rig, {"log": log.drop_vars("pressure")})
    holed = log.assign(supply=("time", np.where(log["time"] < 5.0, np.nan, 1e5)))
    with pytest.raises(InputError, match=r"^log: supply: has gaps"):
        VesselModel(rig, {"log": holed})
    with pytest.raises(InputError, match="there is no log"):
        VesselModel(rig, {})


def test_a_gas_that_condenses_is_one_line() -> None:
    rig, log = blow_down()
    liquid = rig.model_copy(
        update={
            "gas": Gas(name="carbon dioxide"),
            "start": GasConditions.model_construct(pressure=80e5, temperature=280.0),
        }
    )
    with pytest.raises(InputError, match=r"start: carbon dioxide is not a gas at 80 bar and 280 K"):
        VesselModel(liquid, {"log": log})


MAPPING = Path(__file__).parents[4] / "research" / "measured_logs" / "vessel.toml"


def measured(folder: Path, name: str, share: float = 1.0) -> Fit:
    base = folder / "vessel" / name
    logs = {name: read_log(base.with_name(f"{name}.csv"), MAPPING, as_recorded=True)}
    return fit(VesselModel(load_bench(base.with_name(f"{name}.rig.yml")), logs, fitted_share=share))


def test_measured_blow_down_of_air(measured_data: Path) -> None:
    found = measured(measured_data, "Air_790kPa_21mm")
    assert found.trusted
    assert found.qualities()[0].rms < 1.6e3
    assert 0.02 < found.estimate("wall.natural").value < 0.4
    early = measured(measured_data, "Air_790kPa_21mm", 2 / 3)
    validation = next(quality for quality in early.qualities() if quality.validation)
    assert validation.output == "pressure"
    assert validation.rms < 1.5e3


def test_measured_blow_down_of_nitrogen(measured_data: Path) -> None:
    found = measured(measured_data, "N2_Exp_I1")
    assert found.qualities()[0].rms < 0.01 * 150e5
    assert 0.6 < found.estimate("path.conductance").value / 6.3e-8 < 0.95
    early = measured(measured_data, "N2_Exp_I1", 2 / 3)
    assert next(quality for quality in early.qualities() if quality.validation).rms < 0.01 * 150e5
