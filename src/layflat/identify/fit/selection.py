"""Choice of a model's unknowns by predictions of left-out logs, and the error to expect of a new log.

Every model of a family (`Model.simpler_models`) is fitted to all logs, and to all but one in turn; the left-out log is
then predicted, or the left-out block of time where there is only one. A parameter that only fits noise makes these
predictions no better. The simplest model that predicts as well as any is taken (stone1974).
"""

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from layflat.arrays import Array
from layflat.identify.fit.result import (
    Fit,
    FittedParameter,
    choose_simplest,
    compute_quality,
    expected_errors,
    relative_error,
)
from layflat.identify.fit.search import RANDOM_STARTS, Progress, fit, fit_near, search_near
from layflat.identify.model import Flags, Model, ModelOutput

MAX_FOLDS = 3  # more logs are left out several at a time: a third, as new logs differ from all that are fitted
TIME_BLOCKS = 3  # of the only fitted log; the first is always fitted, as simulation runs begin with it


@dataclass(frozen=True)
class Fold:
    """Model with some samples left out, and flags of these."""

    name: str  # of the logs or the block
    model: Model  # the same unknowns and outputs; `fitted` without the left-out samples
    held_out: tuple[Flags, ...]  # of each output


def split_folds(model: Model) -> list[Fold]:
    """Return folds that leave out the fitted logs in turn, in up to `MAX_FOLDS` groups.

    Of a single log they leave out each of `TIME_BLOCKS` blocks of its time but the first.
    """
    logs = list(dict.fromkeys(output.log for output in model.outputs if output.fitted.any()))
    if len(logs) > 1:
        groups = [logs[i::MAX_FOLDS] for i in range(min(MAX_FOLDS, len(logs)))]
        return [_leave_out(model, ", ".join(group), partial(_flag_logs, group)) for group in groups]
    return [
        _leave_out(model, f"{logs[0]}, part {block + 1} of {TIME_BLOCKS}", partial(_flag_block, block))
        for block in range(1, TIME_BLOCKS)
    ]


def _leave_out(model: Model, name: str, chosen: Callable[[ModelOutput], Flags]) -> Fold:
    """Return a fold in which the chosen samples of fitted outputs are left out of the fit."""
    left_out = tuple(chosen(output) & output.fitted for output in model.outputs)
    outputs = tuple(
        replace(output, fitted=output.fitted & ~out) for output, out in zip(model.outputs, left_out, strict=True)
    )
    return Fold(name, with_outputs(model, outputs), left_out)


def with_outputs(model: Model, outputs: tuple[ModelOutput, ...]) -> Model:
    """Return a copy of a model that fits other samples of the same outputs."""
    other = copy(model)
    other.outputs = outputs
    for name in ("used", "measured"):
        other.__dict__.pop(name, None)
    return other


def _flag_logs(logs: list[str], output: ModelOutput) -> Flags:
    return np.full(len(output.time), output.log in logs)


def _flag_block(block: int, output: ModelOutput) -> Flags:
    """Return flags of the output's samples in one of `TIME_BLOCKS` equal blocks of its fitted time."""
    time = output.time[output.fitted]
    edges = (
        time[0] + (time[-1] - time[0]) * np.arange(TIME_BLOCKS + 1) / TIME_BLOCKS
        if len(time)
        else np.zeros(TIME_BLOCKS + 1)
    )
    last = block == TIME_BLOCKS - 1
    return np.asarray((output.time >= edges[block]) & (last | (output.time < edges[block + 1])))


SEARCH_FRACTION = 0.3  # of the work: the first search
MIN_FOLDS = 3  # with fewer, too little is left to choose unknowns by
UNINFORMED_FRACTION = 0.5  # of an interval's half, within which the described value is as good as the estimate


@dataclass(frozen=True)
class CrossValidation:
    """Prediction errors of logs, or of blocks of time, that were left out."""

    errors: Mapping[str, Array]  # rms of each part, in SI, by signal
    relative_errors: Array  # of each part, over the range, all signals together

    @property
    def error(self) -> float:
        """Return the rms of all left-out parts, over the range."""
        return float(np.sqrt(np.mean(self.relative_errors**2)))

    @property
    def percent(self) -> str:
        """Return `error` in per cent with two significant digits, without the sign."""
        return f"{100.0 * self.error:.2g}"


def fit_selected(model: Model, *, starts: int = RANDOM_STARTS, seed: int = 0, progress: Progress | None = None) -> Fit:
    """Fit a model, or a simpler one that predicts left-out logs as well, and estimate the error on a new log.

    Args:
        model: the one with the most unknowns.
        starts: see `fit`.
        seed: see `fit`.
        progress: see `fit`.

    Returns:
        The fit that is taken, with `expected` errors; remarks name the compared models, if there are `MIN_FOLDS` folds
        to compare them by. A search that the user stops is returned as it is.
    """

    def report(fraction: float, text: str) -> None:
        if progress is not None:
            progress(fraction, text)

    full = fit(model, starts=starts, seed=seed, progress=lambda part, text: report(SEARCH_FRACTION * part, text))
    if full.partial:
        return full
    family: dict[str, Model] = {"all": model}
    if len(split_folds(model)) >= MIN_FOLDS:
        family |= {**model.simpler_models(), **_drop_uninformed(model, full)}
    part = (1.0 - SEARCH_FRACTION) / len(family)
    fits, scores = dict[str, Fit](), dict[str, CrossValidation]()
    for number, (name, candidate) in enumerate(family.items()):
        start = SEARCH_FRACTION + part * number

        def report_candidate(fraction: float, text: str, start: float = start, name: str = name) -> None:
            report(start + part * fraction, f"{name}: {text}" if len(family) > 1 else text)

        try:
            report_candidate(0.0, "fitting")
            fits[name] = full if candidate is model else fit_near(candidate, _carry_values(candidate, full), seed=seed)
            error = relative_error([one for one in fits[name].qualities() if not one.validation])
            if scores and choose_simplest([error, scores["all"].error]) != 0:
                # Left-out logs are predicted no better than fitted ones: it is worse already.
                scores[name] = CrossValidation({}, np.array([error]))
            else:
                scores[name] = cross_validate(candidate, fits[name].values, report_candidate)
        except KeyboardInterrupt:
            return replace(full, partial=True)
    order = sorted(family, key=lambda name: len(family[name].unknowns))
    selected = order[choose_simplest([scores[name].error for name in order])]
    if len(family) > 1:
        fits[selected].model.remarks = (*fits[selected].model.remarks, _comparison(order, scores, selected))
    return replace(fits[selected], expected=expected_errors(scores[selected].errors, fits[selected].model))


def cross_validate(model: Model, values: Array, progress: Callable[[float, str], None]) -> CrossValidation:
    """Predict every part of the fitted logs from fits to the rest.

    Args:
        model: model whose fitted logs are left out in turn.
        values: values of a fit to all logs (SI), (unknowns,), from which the fits start.
        progress: called with the fraction of the work done and the present task.
    """
    folds = split_folds(model)
    errors: dict[str, list[float]] = {}
    relative: list[float] = []
    for number, fold in enumerate(folds):
        progress(number / len(folds), f"without {fold.name}")
        simulated = model.simulate(search_near(fold.model, values)[None])[0]
        by_log: dict[str, list[float]] = {}
        for rows, output, left_out in zip(model.slices, model.outputs, fold.held_out, strict=True):
            chosen = left_out & np.isfinite(output.measured)
            if chosen.any():
                quality = compute_quality(output, chosen, simulated[rows], validation=True)
                errors.setdefault(output.name, []).append(quality.rms if np.isfinite(quality.rms) else np.inf)
                by_log.setdefault(output.log, []).append(quality.relative_rms)
        relative += [float(np.sqrt(np.mean(np.square(each)))) for each in by_log.values()]
    return CrossValidation({name: np.array(each) for name, each in errors.items()}, np.array(relative))


def _drop_uninformed(model: Model, full: Fit) -> dict[str, Model]:
    """Return the model with uninformed unknowns held at their described values, by its label.

    It is empty if no unknown, or every unknown, is uninformed.
    """
    uninformed = [
        one.unknown for one in full.estimates if not (one.identified or one.unknown.nuisance) and _is_uninformed(one)
    ]
    if not uninformed or len(uninformed) == len(model.unknowns):
        return {}
    return {f"all but {', '.join(one.path for one in uninformed)}": model.hold([one.path for one in uninformed])}


def _is_uninformed(estimate: FittedParameter) -> bool:
    """Return whether the described value lies within the middle half of the confidence interval.

    The logs then add nothing to it.
    """
    unknown, (low, value, high) = estimate.unknown, (estimate.low, estimate.value, estimate.high)
    described = unknown.guess
    if unknown.log:
        if low <= 0.0:
            return False
        low, value, high, described = (float(np.log(one)) for one in (low, value, high, described))
    return value - UNINFORMED_FRACTION * (value - low) <= described <= value + UNINFORMED_FRACTION * (high - value)


def _carry_values(model: Model, full: Fit) -> Array:
    """Return a fit's values for the unknowns of a simpler model; guesses for those that it does not have."""
    fitted = {one.unknown.path: one.value for one in full.estimates}
    return np.array([fitted.get(one.path, one.guess) for one in model.unknowns])


def _comparison(order: Sequence[str], scores: Mapping[str, CrossValidation], selected: str) -> str:
    """Return the remark that names the selected model, and the errors of all models on left-out logs."""
    each = "; ".join(f"{name}, {'' if scores[name].errors else 'at least '}{scores[name].percent} %" for name in order)
    return f"Left-out logs are missed by, of their range: {each}. Taken: {selected}."
