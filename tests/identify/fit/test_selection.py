"""Unknowns chosen by what is predicted of left-out logs, and errors to expect of new ones."""

from dataclasses import replace

import numpy as np
import pytest

from layflat.identify.fit import fit_selected
from layflat.identify.fit.result import choose_simplest
from layflat.identify.fit.selection import MAX_FOLDS, split_folds
from layflat.identify.report_text import describe_expected_errors
from tests.identify.fit.models import TIME, Decay, Polynomial

LINE, PARABOLA = (1.0, -2.0), (1.0, -2.0, 0.5)


@pytest.mark.parametrize(("truth", "name"), [(LINE, "line"), (PARABOLA, "parabola")])
def test_unknowns_that_only_fit_noise_go(truth: tuple[float, ...], name: str) -> None:
    model = Polynomial(truth, 4, 0.2)
    found = fit_selected(model, starts=0)
    assert [one.unknown.path for one in found.estimates] == list("abcd")[: len(truth)]
    assert found.remarks[-1].endswith(f"Taken: {name}.")
    assert found.values == pytest.approx(truth, abs=0.2)


@pytest.mark.parametrize("logs", [2, 5])
def test_the_expected_error_is_that_of_new_logs(logs: int) -> None:
    ratios, inside = [], []
    for seed in range(12):
        found = fit_selected(Polynomial(PARABOLA, logs, 0.3, seed), starts=0)
        (one,) = found.expected
        new = Polynomial(PARABOLA, 20, 0.3, seed + 100)
        columns = {e.unknown.path: e.value for e in found.estimates}
        values = np.array([[columns.get(name, 0.0) for name in "abcd"]])
        errors = [
            float(np.sqrt(np.mean((new.simulate(values)[0][place] - output.measured) ** 2)))
            for place, output in zip(new.slices, new.outputs, strict=True)
        ]
        ratios.append(one.rms / np.mean(errors))
        inside.append(np.mean([one.low <= error <= one.high for error in errors]))
        assert len(one.held_out_rms) == logs
    assert np.mean([1 / 1.5 <= ratio <= 1.5 for ratio in ratios]) >= 0.9
    assert np.mean(inside) >= 0.7
    assert "Expected of a new log of the same kind: y 0.3" in describe_expected_errors(found)


def test_folds_leave_out_each_log_once_and_touch_no_other_sample() -> None:
    model = Polynomial(LINE, MAX_FOLDS + 3, 0.1)
    model.outputs = (replace(model.outputs[0], fitted=np.zeros(40, bool)), *model.outputs[1:])
    folds = split_folds(model)
    assert len(folds) == MAX_FOLDS
    left = np.sum([np.concatenate(fold.held_out) for fold in folds], axis=0)
    assert left.tolist() == [0.0] * 40 + [1.0] * 40 * (MAX_FOLDS + 2)
    for fold in folds:
        assert not (fold.model.used & np.concatenate(fold.held_out)).any()
        assert (fold.model.used | np.concatenate(fold.held_out)).sum() == model.used.sum()
    assert model.used.sum() == 40 * (MAX_FOLDS + 2)


def test_a_single_log_is_left_out_by_blocks_of_what_is_fitted() -> None:
    model = Decay(np.array([1.7, 0.6, 0.2]), 0.01, 0)
    folds = split_folds(model)
    assert [fold.name for fold in folds] == ["log, part 2 of 3", "log, part 3 of 3"]
    assert all((TIME[fold.held_out[0]] <= 3.0).all() for fold in folds)
    assert sum(fold.held_out[0].sum() for fold in folds) == pytest.approx(2 / 3 * model.used.sum(), abs=2)


def test_the_simplest_is_taken_that_is_as_good() -> None:
    assert choose_simplest([0.05, 0.021, 0.02]) == 1
    assert choose_simplest([0.0209, 0.3, 0.02]) == 0
    assert choose_simplest([np.inf, np.inf, 0.5]) == 2
    assert choose_simplest([np.inf, np.inf]) == 0
