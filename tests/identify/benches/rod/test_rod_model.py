from pathlib import Path
from typing import cast

import numpy as np
import pytest
import xarray

from layflat.errors import InputError
from layflat.identify import fit
from layflat.identify.benches.hysteresis import (
    curve_errors,
    noise_level,
    round_weights,
    split_from_weights,
    weights_from_split,
)
from layflat.identify.benches.loader import load_bench
from layflat.identify.benches.rod import RodModel
from layflat.identify.benches.rod.description import RodBench
from layflat.identify.fit.search import search_near

RIG = cast(RodBench, load_bench("friction-rig"))
DATA = Path(__file__).parents[4].parent / "shared" / "data" / "zillen"

REAL = RIG.model_copy(
    update={
        "piston": RIG.piston.model_copy(update={"area": 1.2e-3, "area_slope": -2e-3, "spring": 90.0, "offset": -8.0}),
        "friction": RIG.friction.model_copy(
            update={"base": 11.0, "slope": 4e-5, "deflections": (1e-4, 1e-3, 4e-3), "weights": (0.5, 0.2, 0.3)}
        ),
    }
)
"""Four times the area, and several times the friction, of what the search begins with."""


def pushed(
    rig: RodBench, gauge: float, noisy: float = 0.0, spikes: int = 0, seed: int = 0, cycles: int = 5, rate: int = 100
) -> xarray.Dataset:
    rng = np.random.default_rng(seed)
    time = np.linspace(0.0, 8.0 * cycles, 8 * rate * cycles)
    position = 0.02 - 0.02 * np.cos(2 * np.pi * time / 8.0) * np.where(time < 8.0 * (cycles - 1), 1.0, 0.5)
    pressure = gauge + 3e3 * np.sign(np.sin(2 * np.pi * time / 8.0)) + 101325.0
    log = xarray.Dataset(
        {"position": ("time", position), "pressure": ("time", pressure), "force": ("time", np.cos(time))},
        {"time": time},
    )
    force = RodModel(rig, {"": log}, blocks=()).simulate(np.empty((1, 0)))[0] + rng.normal(0.0, noisy, len(time))
    position[rng.choice(np.arange(10, 3990, 4), spikes, replace=False)] += 5e-4
    return log.assign(force=("time", force), position=("time", position))


def test_what_a_rig_shows_is_found_again() -> None:
    logs = {f"{bar} bar": pushed(REAL, bar * 1e5, noisy=0.2, seed=bar, cycles=3, rate=50) for bar in (1, 3, 6)}
    model = RodModel(RIG, logs, {"5 bar": pushed(REAL, 5e5, cycles=3, rate=50)})
    found = fit(model, starts=0)
    described = model.describe(found.values)
    assert described.piston.area == pytest.approx(1.2e-3, rel=1e-3)
    assert described.piston.area_slope == pytest.approx(-2e-3, rel=0.05)
    assert described.friction.base == pytest.approx(11.0, rel=0.02)
    assert described.friction.slope == pytest.approx(4e-5, rel=0.02)
    found_elements = sorted(zip(described.friction.deflections, described.friction.weights, strict=True))
    deflections, weights = zip(*found_elements, strict=True)
    assert deflections == pytest.approx(REAL.friction.deflections, rel=0.15)
    assert weights == pytest.approx(REAL.friction.weights, abs=0.03)
    assert model.described_values(found.values)["friction.weights.2"] == described.friction.weights[2]
    assert described.friction.film_fraction == pytest.approx(REAL.friction.film_fraction, abs=0.02)
    assert described.friction.film_speed == pytest.approx(REAL.friction.film_speed, rel=0.05)
    assert np.abs(described.friction.profile).max() < 0.01
    assert "do not show" in model.remarks[0]
    assert found.trusted
    assert curve_errors(model, found.simulated)[-1].raw < 0.005


SHAPED = REAL.model_copy(
    update={"piston": REAL.piston.model_copy(update={"area_growth": 6e-11, "area_slope_growth": -2.5e-9})}
)
"""A seal that pressure gives another shape."""


def of_their_own(rig: RodBench, bars: tuple[int, ...], seed: int = 0) -> dict[str, xarray.Dataset]:
    """Logs that differ by more than pressure: by some tenths of a newton, and some per cent of the friction."""
    rng, logs = np.random.default_rng(seed), {}
    for bar in bars:
        friction = 1.0 + 0.03 * rng.standard_normal()
        levels = {"base": rig.friction.base * friction, "slope": rig.friction.slope * friction}
        mine = rig.model_copy(update={"friction": rig.friction.model_copy(update=levels)})
        log = pushed(mine, bar * 1e5, noisy=0.2, seed=bar).isel(time=slice(None, None, 4))
        logs[f"{bar} bar"] = log.assign(force=log["force"] + 0.4 * rng.standard_normal())
    return logs


@pytest.mark.parametrize("bars", [(1, 3, 7), (1, 5, 7)])
def test_a_change_of_shape_is_fitted_where_logs_show_it_and_not_where_they_differ_by_chance(
    bars: tuple[int, ...],
) -> None:
    grown = {"piston.area_growth", "piston.area_slope_growth"}
    for seed in range(4):
        shaped, steady = (RodModel(RIG, of_their_own(rig, bars, seed)) for rig in (SHAPED, REAL))
        assert grown <= {one.path for one in shaped.unknowns}
        assert shaped.remarks[0].startswith("The logs show")
        assert not grown & {one.path for one in steady.unknowns}
        assert steady.remarks[0].startswith("The logs do not show")


def test_a_change_of_shape_is_found_and_predicts_another_pressure() -> None:
    logs = of_their_own(SHAPED, (1, 3, 5, 7))
    validation = {"5 bar": logs.pop("5 bar")}
    errors = []
    for blocks in (("piston", "friction"), ("piston", "friction", "shape")):
        model = RodModel(REAL, logs, validation, blocks=blocks)
        start = model.starts()[0]
        errors.append(curve_errors(model, model.simulate(start[None])[0])[-1].raw)
    assert errors[1] < 0.03
    assert errors[0] > 1.5 * errors[1]


BENT = REAL.model_copy(
    update={"friction": REAL.friction.model_copy(update={"base": 5.0, "slope": 3e-5, "exponent": 2.0})}
)
"""Friction that hardly grows at low pressures and fast at high ones: no line through it has a base above zero."""


def test_friction_that_bends_with_pressure_is_told_from_one_that_differs_by_chance() -> None:
    errors = np.empty((3, 2))
    for seed in range(3):
        logs = of_their_own(BENT, (1, 3, 5, 7), seed)
        validation = {"5 bar": logs.pop("5 bar")}
        model = RodModel(RIG, logs, validation)
        assert "friction.exponent" in [one.path for one in model.unknowns]
        assert any(said.startswith("The logs show that friction grows otherwise") for said in model.remarks)
        straight = model.hold(["friction.exponent"])
        for i, one in enumerate((model, straight)):
            values = search_near(one, one.starts()[0])
            errors[seed, i] = curve_errors(one, one.simulate(values[None])[0])[-1].friction
        steady = RodModel(RIG, of_their_own(REAL, (1, 3, 7), seed))
        assert "friction.exponent" not in [one.path for one in steady.unknowns]
    bent, straight_errors = errors.mean(axis=0)
    assert bent < 0.04
    assert straight_errors > 1.5 * bent


def test_two_pressures_can_not_show_a_change_of_shape() -> None:
    model = RodModel(RIG, of_their_own(SHAPED, (1, 7)))
    assert "fewer than three pressures" in model.remarks[0]
    assert "piston.area_growth" not in [one.path for one in model.unknowns]


def test_a_flat_profile_is_spread_over_the_logs_and_one_that_is_not_stays() -> None:
    log = {"log": pushed(REAL, 3e5)}
    spread = RodModel(RIG, log)
    assert spread.origin.friction.profile_to == pytest.approx(0.04, abs=1e-4)
    assert spread.described_values(spread.guess)["friction.profile_to"] == spread.origin.friction.profile_to
    uneven = {"profile": (0.1, 0.0, -0.1), "profile_from": 0.005, "profile_to": 0.03}
    known = RIG.model_copy(update={"friction": RIG.friction.model_copy(update=uneven)})
    kept = RodModel(known, log)
    assert kept.origin.friction.profile_to == 0.03
    assert "friction.profile_to" not in kept.described_values(kept.guess)


def test_what_one_log_has_of_its_own_is_not_taken_for_a_law_of_pressure() -> None:
    logs = of_their_own(REAL, (1, 3, 7))
    logs["3 bar"]["force"] = logs["3 bar"]["force"] + 1.0
    model = RodModel(REAL, logs, blocks=("piston", "friction"))
    found = dict(zip((one.path for one in model.unknowns), model.starts()[0], strict=True))
    assert found["log.offset.3 bar"] > 0.3
    assert found["piston.area"] == pytest.approx(1.2e-3, rel=0.02)


def test_spikes_of_the_position_do_not_make_the_friction_forget() -> None:
    plain, spiked = pushed(REAL, 3e5), pushed(REAL, 3e5, spikes=80)
    assert np.abs(plain["position"] - spiked["position"]).max() > 4e-4
    error = RodModel(REAL, {"": spiked}, blocks=()).simulate(np.empty((1, 0)))[0] - plain["force"].to_numpy()
    assert np.sqrt(np.mean(error**2)) < 0.02 * 23.0


def test_the_last_third_is_judged_where_there_is_no_other_log() -> None:
    model = RodModel(RIG, {"log": pushed(REAL, 3e5)})
    assert model.outputs[0].fitted.mean() == pytest.approx(2 / 3, abs=0.01)


def test_gaps_of_the_force_are_not_fitted_and_do_not_hinder() -> None:
    log = pushed(REAL, 3e5)
    log["force"][:50] = np.nan
    model = RodModel(RIG, {"log": log})
    assert not model.used[:50].any()
    assert np.isfinite(model.simulate(model.guess[None])).all()


def test_viscous_friction_is_found_where_it_is_asked_for() -> None:
    real = REAL.model_copy(update={"friction": REAL.friction.model_copy(update={"viscous": 150.0})})
    logs = {"slow": pushed(real, 2e5), "fast": _hurried(real, 2e5)}
    model = RodModel(REAL, logs, blocks=("viscous",))
    assert fit(model, starts=0).estimate("friction.viscous").value == pytest.approx(150.0, rel=0.05)


def _hurried(rig: RodBench, gauge: float) -> xarray.Dataset:
    log = pushed(rig, gauge).assign_coords(time=np.linspace(0.0, 8.0, 4000))
    return log.assign(force=("time", RodModel(rig, {"": log}, blocks=()).simulate(np.empty((1, 0)))[0]))


def test_a_log_that_is_at_rest_is_refused() -> None:
    log = pushed(REAL, 3e5)
    log["position"][:] = 0.01
    with pytest.raises(InputError, match="tuesday: the position never changes"):
        RodModel(RIG, {"tuesday": log})


def test_weights_and_how_they_are_split() -> None:
    rng = np.random.default_rng(0)
    for count in (1, 2, 5):
        weights = rng.dirichlet(np.ones(count))
        assert weights_from_split(split_from_weights(weights)) == pytest.approx(weights)
    assert weights_from_split(split_from_weights(np.array([1.0, 0.0, 0.0]))) == pytest.approx([1.0, 0.0, 0.0])


def test_rounded_weights_add_up_to_one() -> None:
    rng = np.random.default_rng(0)
    for count in (1, 2, 3, 7):
        for _ in range(50):
            weights = round_weights(rng.dirichlet(np.ones(count)))
            assert abs(sum(weights) - 1.0) < 1e-12
            assert [float(f"{weight:.7g}") for weight in weights] == list(weights)


def test_noise_of_a_smooth_motion() -> None:
    rng = np.random.default_rng(0)
    assert noise_level(np.sin(np.linspace(0, 9, 3000)) + rng.normal(0.0, 0.01, 3000)) == pytest.approx(0.01, rel=0.1)


@pytest.mark.skipif(not DATA.exists(), reason="measured loops are not here: ../shared/data/zillen")
@pytest.mark.parametrize(("seal", "left", "most"), [("O-ring", 5, 0.05), ("PK", 5, 0.057), ("Kidney_lc", 3, 0.06)])
def test_measured_loops_are_predicted_at_a_pressure_that_was_not_fitted(seal: str, left: int, most: float) -> None:
    def read(bar: int) -> xarray.Dataset:
        samples = np.loadtxt(DATA / f"{seal}_{bar}bar.csv", usecols=(0, 4, 5, 6))[::5]
        time, position, pressure, force = samples.T.copy()
        return xarray.Dataset(
            {
                "position": ("time", 1e-3 * position),
                "pressure": ("time", 1e5 * pressure + 101325.0),
                "force": ("time", force),
            },
            {"time": 1e-3 * time},
        )

    fitted = {f"{bar} bar": read(bar) for bar in (1, 3, 5, 7) if bar != left}
    model = RodModel(RIG, fitted, {f"{left} bar": read(left)})
    error = curve_errors(model, fit(model, starts=0).simulated)[-1]
    assert error.validation
    assert error.raw <= most
    assert error.friction <= error.raw
