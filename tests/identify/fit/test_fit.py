"""Fitting: the truth within the intervals as often as they say, and what a log can't tell called so."""

from dataclasses import replace

import numpy as np
import pytest

from layflat.errors import InputError
from layflat.identify import fit
from layflat.identify.fit.certainty import NORMAL_QUANTILE, PRIOR_WIDTH
from layflat.identify.report_text import describe_prediction, distrust_reason
from tests.identify.fit.models import TIME, ByLifetime, Decay, Led, Level, Linearly, Product, Twins, TwoTones

TRUTH = np.array([1.7, 0.6, 0.2])


def test_a_clean_log_gives_the_truth() -> None:
    found = fit(Decay(TRUTH, 1e-6, 0), starts=0)
    assert found.values == pytest.approx(TRUTH, rel=1e-4)
    assert found.trusted
    assert all(estimate.identified for estimate in found.estimates)


def test_what_is_searched_in_other_values_comes_back_with_the_same_intervals() -> None:
    plain, other = (fit(kind(TRUTH, 0.05, 1), starts=0) for kind in (Decay, ByLifetime))
    for one, same in zip(plain.estimates, other.estimates, strict=True):
        width = one.high - one.low
        for name in ("value", "low", "high"):
            assert getattr(same, name) == pytest.approx(getattr(one, name), abs=0.05 * width)
    assert other.trusted


def test_what_logs_do_not_tell_is_as_unsure_as_it_was_searched() -> None:
    b = fit(Linearly(), starts=0).estimate("b")
    known = PRIOR_WIDTH * (b.unknown.high - b.unknown.low) / b.value  # standard deviation of log b
    assert b.value == pytest.approx(b.unknown.guess, rel=1e-6)
    assert np.log(b.high / b.low) == pytest.approx(2.0 * NORMAL_QUANTILE * known, rel=1e-3)


def test_intervals_hold_as_often_as_they_say() -> None:
    held = [
        [e.low <= t <= e.high for e, t in zip(fit(Decay(TRUTH, 0.05, seed), starts=0).estimates, TRUTH, strict=True)]
        for seed in range(60)
    ]
    assert 0.9 <= np.mean(held) <= 1.0


def test_intervals_hold_where_errors_last_long() -> None:
    # Errors that stay the same for 20 samples: the Jacobian alone would be sure by far too much.
    held = []
    for seed in range(40):
        model = Decay(TRUTH, 0.05, seed)
        (output,) = model.outputs
        exact = model.simulate(TRUTH[None])[0]
        lasting = np.repeat(np.random.default_rng(seed).standard_normal(len(TIME) // 20 + 1), 20)[: len(TIME)]
        model.outputs = (replace(output, measured=exact + 0.05 * lasting),)
        held.append([e.low <= t <= e.high for e, t in zip(fit(model, starts=0).estimates, TRUTH, strict=True)])
    assert np.mean(held) >= 0.85


def test_what_a_log_ends_too_early_for_is_not_told() -> None:
    found = fit(Decay(TRUTH, 0.02, 0, until=0.2), starts=0)
    assert not found.estimate("level").identified
    assert not found.estimate("rate").identified
    assert found.estimate("rate").partner is not None


def test_a_product_is_told_but_not_its_factors() -> None:
    found = fit(Product(), starts=4)
    a, b = found.estimates
    assert a.value * b.value == pytest.approx(2.0, rel=1e-3)
    assert not a.identified
    assert a.partner == "b"


@pytest.mark.parametrize("shifted", [(0.0, 0.1), (1.0, 0.2), (-0.5, 0.05)])
def test_a_prior_of_its_own_is_kept_where_logs_say_nothing_against_it(shifted: tuple[float, float]) -> None:
    found = fit(Level(shifted), starts=0)
    mean, spread = shifted
    # The level's own prior is wide but not without weight: it takes a little of the shift.
    assert found.estimate("shift").value == pytest.approx(mean, abs=0.05 * spread)
    assert found.estimate("level").value == pytest.approx(3.0 - mean, abs=0.1)
    assert found.estimate("shift").high - found.estimate("shift").low == pytest.approx(2 * 1.96 * spread, rel=0.2)


def test_a_physical_upper_bound_is_no_fault() -> None:
    found = fit(Level((0.0, 0.1), most=2.5), starts=0)
    assert found.estimate("level").value == pytest.approx(2.5, abs=0.05)
    assert not found.estimate("level").at_bound


def test_a_value_at_its_bound_is_said_to_be() -> None:
    found = fit(Decay(np.array([9.0, 0.6, 0.2]), 0.05, 0), starts=0)
    assert found.estimate("height").at_bound
    assert not found.estimate("height").identified
    assert not found.trusted


def test_more_starts_find_a_minimum_that_the_guess_misses() -> None:
    assert fit(TwoTones(given=False), starts=0).values[0] != pytest.approx(9.0, rel=0.05)
    assert fit(TwoTones(given=False), starts=64).values[0] == pytest.approx(9.0, rel=1e-2)
    assert fit(TwoTones(given=True), starts=0).values[0] == pytest.approx(9.0, rel=1e-2)


@pytest.mark.parametrize(("rate", "led"), [(4.0, True), (-1.0, False)])
def test_what_runs_away_even_with_the_best_values_is_judged_as_it_is_led(rate: float, led: bool) -> None:
    found = fit(Led(rate, 2.0, seed=2), starts=0)
    assert found.trusted
    assert (found.tracking is not None) == led
    assert found.remarks == (("It is led.",) if led else ())
    for path, value in (("rate", rate), ("push", 2.0)):
        estimate = found.estimate(path)
        assert estimate.identified
        assert estimate.low <= value <= estimate.high


def test_what_is_led_and_still_misses_by_a_tenth_is_not_to_be_trusted() -> None:
    right = Led(4.0, 2.0, seed=2)
    found = fit(right, starts=0)
    off = replace(found, simulated=found.simulated + 0.1 * np.ptp(right.measured))
    assert found.tracking is not None
    assert off.mispredicted is not None
    assert replace(off, tracking=None).mispredicted is None


def test_the_same_seed_gives_the_same_fit() -> None:
    first, second = (fit(Decay(TRUTH, 0.05, 3), seed=5) for _ in range(2))
    assert first.estimates == second.estimates


def test_quality_is_told_apart_for_what_was_fitted_and_what_was_not() -> None:
    found = fit(Decay(TRUTH, 0.05, 0), starts=0)
    fitted, validation = found.qualities()
    assert (fitted.validation, validation.validation) == (False, True)
    assert fitted.samples + validation.samples == len(TIME)
    assert fitted.rms == pytest.approx(0.05, rel=0.15)
    assert validation.rms == pytest.approx(0.05, rel=0.25)
    assert fitted.white > 0.8
    assert fitted.driven is None


def test_a_run_that_diverged_where_it_was_not_fitted_is_no_prediction() -> None:
    found = fit(Decay(TRUTH, 0.05, 0), starts=0)
    last = np.append(found.simulated[:-1], np.nan)
    lost = replace(found, simulated=last)
    assert found.trusted
    assert lost.mispredicted is not None
    assert lost.mispredicted.diverged
    assert not lost.trusted
    assert "not at all: the run diverged" in describe_prediction(lost)
    assert (distrust_reason(lost, []) or "").startswith("y is missed altogether, as the run diverged, where")


def test_samples_that_were_not_measured_do_not_count() -> None:
    model = Decay(TRUTH, 0.05, 0)
    (output,) = model.outputs
    measured = np.where((output.time > 1.0) & (output.time < 1.5), np.nan, output.measured)
    model.outputs = (replace(output, measured=measured),)
    assert fit(model, starts=0).values == pytest.approx(TRUTH, abs=0.1)


def test_progress_grows_and_stays_below_one() -> None:
    told: list[float] = []
    fit(Decay(TRUTH, 0.05, 0), progress=lambda share, _: told.append(share))
    assert told == sorted(told)
    assert 0.0 < told[0] <= told[-1] <= 1.0


def test_bounds_without_room_are_refused() -> None:
    model = Decay(TRUTH, 0.05, 0)
    model.unknowns = (replace(model.unknowns[0], guess=9.0), *model.unknowns[1:])
    with pytest.raises(InputError, match="height: 9 V: lies outside the searched range"):
        fit(model)


def test_ctrl_c_keeps_the_best_values_so_far() -> None:
    model, calls = Decay(TRUTH, 0.05, 0), 0

    def stop(_: float, text: str) -> None:
        nonlocal calls
        calls += text == "fitting"
        if text == "fitting" and calls == 5:
            raise KeyboardInterrupt

    found = fit(model, starts=0, progress=stop)
    assert found.partial
    assert not found.trusted
    start, end = (np.linalg.norm((values - TRUTH) / TRUTH) for values in (model.guess, found.values))
    assert end < 0.2 * start
    assert not fit(model, starts=0).partial


@pytest.mark.parametrize("rates", [(0.5, 3.0), (3.0, 0.5)])
def test_of_values_that_mirror_each_other_those_are_taken_that_predict_better(rates: tuple[float, float]) -> None:
    found = fit(Twins(0.4, rates, 1e-3), starts=0)
    for estimate, rate in zip(found.estimates, rates, strict=True):
        assert estimate.identified
        assert estimate.low <= rate <= estimate.high


def test_values_that_mirror_each_other_and_predict_alike_are_not_told() -> None:
    found = fit(Twins(0.5, (0.5, 3.0), 1e-3), starts=0)
    for estimate in found.estimates:
        assert not estimate.identified
        assert estimate.low <= 0.5
        assert estimate.high >= 3.0
