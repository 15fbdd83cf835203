"""Choice of a model's unknowns by what is predicted of logs that are left out, and the error to expect of a new log.

Every model of a family (`Model.simpler`) is fitted to all logs, and to all but one in turn; the left-out log is then
predicted, or the left-out block of time where there is only one. A parameter that only fits noise makes these
predictions no better. The simplest model that predicts as well as any is taken (stone1974).
"""

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from layflat.arrays import Array
from layflat.identify.fit.result import Estimate, Fit, choose, expected_errors, quality
from layflat.identify.fit.search import STARTS, Progress, fit, fit_near, search_near
from layflat.identify.model import Flags, Model, Output

MAX_FOLDS = 3  # more logs are left out several at a time: a third, as new logs differ from all that are fitted
BLOCKS = 3  # into which the only fitted log is divided; the first is always fitted, as runs begin with it


@dataclass(frozen=True)
class Fold:
    """A model with some samples left out, and which these are."""

    name: str  # of the logs or the block
    model: Model  # the same unknowns and outputs; `fitted` without what is left out
    left_out: tuple[Flags, ...]  # of each output


def split_folds(model: Model) -> list[Fold]:
    """Leave out each fitted log of a model in turn; of a single one, each block of its time but the first."""
    logs = list(dict.fromkeys(output.log for output in model.outputs if output.fitted.any()))
    if len(logs) > 1:
        groups = [logs[i::MAX_FOLDS] for i in range(min(MAX_FOLDS, len(logs)))]
        return [_fold(model, ", ".join(group), partial(_of_logs, group)) for group in groups]
    return [
        _fold(model, f"{logs[0]}, part {block + 1} of {BLOCKS}", partial(_of_block, block))
        for block in range(1, BLOCKS)
    ]


def _fold(model: Model, name: str, chosen: Callable[[Output], Flags]) -> Fold:
    left_out = tuple(chosen(output) & output.fitted for output in model.outputs)
    outputs = tuple(
        replace(output, fitted=output.fitted & ~out) for output, out in zip(model.outputs, left_out, strict=True)
    )
    return Fold(name, with_outputs(model, outputs), left_out)


def with_outputs(model: Model, outputs: tuple[Output, ...]) -> Model:
    """Return a copy of a model that fits other samples of the same outputs."""
    other = copy(model)
    other.outputs = outputs
    for name in ("used", "measured"):
        other.__dict__.pop(name, None)
    return other


def _of_logs(logs: list[str], output: Output) -> Flags:
    return np.full(len(output.time), output.log in logs)


def _of_block(block: int, output: Output) -> Flags:
    time = output.time[output.fitted]
    edges = time[0] + (time[-1] - time[0]) * np.arange(BLOCKS + 1) / BLOCKS if len(time) else np.zeros(BLOCKS + 1)
    last = block == BLOCKS - 1
    return np.asarray((output.time >= edges[block]) & (last | (output.time < edges[block + 1])))


SEARCHED = 0.3  # share of the work that is the first search
MIN_PARTS = 3  # left out in turn, with fewer of which the rest is too little to choose unknowns by
MIDDLE = 0.5  # share of an interval's half in which the described value is as good as the one found


@dataclass(frozen=True)
class CrossValidation:
    """Errors of logs, or of blocks of time, that were left out."""

    errors: Mapping[str, Array]  # rms of each, in SI, by signal
    shares: Array  # of each, errors over their ranges, all signals together

    @property
    def error(self) -> float:
        """Rms of all left-out parts, a share of the range."""
        return float(np.sqrt(np.mean(self.shares**2)))

    @property
    def percent(self) -> str:
        """The same in per cent, as text."""
        return f"{100.0 * self.error:.2g}"


def fit_selected(model: Model, *, starts: int = STARTS, seed: int = 0, progress: Progress | None = None) -> Fit:
    """Fit a model, or a simpler one that predicts left-out logs as well, and estimate the error on a new log.

    Args:
        model: the one with the most unknowns.
        starts: see `fit`.
        seed: see `fit`.
        progress: see `fit`.

    Returns:
        The fit that is taken, with `expected` errors; remarks say what was compared. A search that the user stops is
        returned as it is.
    """

    def report(share: float, text: str) -> None:
        if progress is not None:
            progress(share, text)

    found = fit(model, starts=starts, seed=seed, progress=lambda share, text: report(SEARCHED * share, text))
    if found.partial:
        return found
    family: dict[str, Model] = {"all": model}
    if len(split_folds(model)) >= MIN_PARTS:
        family |= {**model.simpler(), **_without_noise(model, found)}
    part = (1.0 - SEARCHED) / len(family)
    fits, scores = dict[str, Fit](), dict[str, CrossValidation]()
    for number, (name, one) in enumerate(family.items()):
        begun = SEARCHED + part * number

        def tell(share: float, text: str, begun: float = begun, name: str = name) -> None:
            report(begun + part * share, f"{name}: {text}" if len(family) > 1 else text)

        try:
            tell(0.0, "fitting")
            fits[name] = found if one is model else fit_near(one, _values_in(one, found), seed=seed)
            missed = _own_error(fits[name])
            if scores and choose([missed, scores["all"].error]) != 0:
                # Left-out logs are predicted no better than fitted ones: it is worse already.
                scores[name] = CrossValidation({}, np.array([missed]))
            else:
                scores[name] = cross_validate(one, fits[name].values, tell)
        except KeyboardInterrupt:
            return replace(found, partial=True)
    order = sorted(family, key=lambda name: len(family[name].unknowns))
    taken = order[choose([scores[name].error for name in order])]
    if len(family) > 1:
        fits[taken].model.remarks = (*fits[taken].model.remarks, _comparison(order, scores, taken))
    return replace(fits[taken], expected=expected_errors(scores[taken].errors, fits[taken].model))


def cross_validate(model: Model, values: Array, progress: Callable[[float, str], None]) -> CrossValidation:
    """Predict every part of the fitted logs from fits to the rest, begun with the values of a fit to all."""
    parts = split_folds(model)
    errors: dict[str, list[float]] = {}
    shares: list[float] = []
    for number, fold in enumerate(parts):
        progress(number / len(parts), f"without {fold.name}")
        simulated = model.simulate(search_near(fold.model, values)[None])[0]
        missed: dict[str, list[float]] = {}
        for place, output, out in zip(model.slices, model.outputs, fold.left_out, strict=True):
            chosen = out & np.isfinite(output.measured)
            if chosen.any():
                one = quality(output, chosen, simulated[place], validation=True)
                errors.setdefault(output.name, []).append(one.rms if np.isfinite(one.rms) else np.inf)
                missed.setdefault(output.log, []).append(one.share)
        shares += [float(np.sqrt(np.mean(np.square(each)))) for each in missed.values()]
    return CrossValidation({name: np.array(each) for name, each in errors.items()}, np.array(shares))


def _without_noise(model: Model, found: Fit) -> dict[str, Model]:
    """A model without the unknowns of which the logs say no more than the description does."""
    vague = [
        one.unknown for one in found.estimates if not (one.identified or one.unknown.nuisance) and _says_nothing(one)
    ]
    if not vague or len(vague) == len(model.unknowns):
        return {}
    return {f"all but {', '.join(one.path for one in vague)}": model.held([one.path for one in vague])}


def _says_nothing(estimate: Estimate) -> bool:
    """Return whether the described value lies in the middle half of an interval."""
    unknown, (low, value, high) = estimate.unknown, (estimate.low, estimate.value, estimate.high)
    described = unknown.guess
    if unknown.log:
        if low <= 0.0:
            return False
        low, value, high, described = (float(np.log(one)) for one in (low, value, high, described))
    return value - MIDDLE * (value - low) <= described <= value + MIDDLE * (high - value)


def _own_error(found: Fit) -> float:
    """Rms error of what is fitted, over its range, as of left-out parts."""
    shares = [one.share for one in found.qualities() if not one.validation]
    return float(np.sqrt(np.mean(np.square(shares)))) if np.isfinite(shares).all() else np.inf


def _values_in(model: Model, found: Fit) -> Array:
    """Values of a fit for the unknowns of a simpler model; guesses for those that it does not have."""
    known = {one.unknown.path: one.value for one in found.estimates}
    return np.array([known.get(one.path, one.guess) for one in model.unknowns])


def _comparison(order: Sequence[str], scores: Mapping[str, CrossValidation], taken: str) -> str:
    """Return the remark that says which model is taken, and by how much each misses left-out logs."""
    each = "; ".join(f"{name}, {'' if scores[name].errors else 'at least '}{scores[name].percent} %" for name in order)
    return f"Left-out logs are missed by, of their range: {each}. Taken: {taken}."
