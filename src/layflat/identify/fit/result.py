"""Result of a fit: estimates, their confidence, and the quality of its predictions."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from layflat.arrays import Array
from layflat.identify.model import Flags, Model, ModelOutput, Unknown

MAX_INTERVAL_RATIO = 0.2
"""Width of an interval up to which a parameter is identified: half of it over the value, where the search is
logarithmic; all of it over the range between the bounds, where it is not."""

INSEPARABLE_CORRELATION = 0.95  # correlation above which two parameters are identified only together
MAX_PREDICTION_ERROR = 0.25  # rms over range; a prediction with more means that the search ended in a wrong minimum
MAX_TRACKING_ERROR = 0.05  # the same of a simulation run with feedback of its log
MAX_LAGS = 25  # samples, up to which errors are correlated with themselves and with the input
EQUIVALENT_ERROR_RATIO = 1.1  # a simpler model is taken up to so many times the error of the best
EQUIVALENT_ERROR_MARGIN = 1e-3  # or up to so much more, as a fraction of the range
EXPECTED_QUANTILE = 0.9  # fraction of new logs that are predicted better than the upper end of the expected error
WHITE_NOISE_BAND = 1.959964  # correlations of white noise over the root of its number of samples, at 95 of 100 lags


@dataclass(frozen=True)
class FittedParameter:
    """Value of an unknown with its 95 % interval, SI."""

    unknown: Unknown
    value: float  # with the least cost
    low: float  # lower end of the interval
    high: float  # upper end
    at_bound: bool  # whether the value lies at a bound of the search
    partner: str | None = None  # path of the parameter that it can't be separated from, if any

    @property
    def identified(self) -> bool:
        """Return whether the interval is narrower than `MAX_INTERVAL_RATIO` allows, and the value at no bound."""
        if self.at_bound:
            return False
        if self.unknown.log:
            return self.low > 0.0 and bool(0.5 * np.log(self.high / self.low) < np.log1p(MAX_INTERVAL_RATIO))
        return self.high - self.low < MAX_INTERVAL_RATIO * (self.unknown.high - self.unknown.low)


@dataclass(frozen=True)
class Quality:
    """Quality of the prediction of an output."""

    output: str  # its name
    unit: str  # SI
    log: str  # name of the log
    validation: bool  # over samples that were not fitted
    samples: int  # their number
    rms: float  # of the error, in `unit`
    bias: float  # mean error, in `unit`
    relative_rms: float  # rms over the measured range
    fit: float  # 1 - rms / standard deviation of the measured samples
    white: float  # fraction of lags at which errors correlate with themselves no more than chance; 0.95 if all is noise
    driven: float | None  # greatest correlation of the error with the input, at any lag; None where no input is known

    @property
    def diverged(self) -> bool:
        """Return whether the simulation diverged: nothing is predicted then."""
        return not np.isfinite(self.rms)


@dataclass(frozen=True)
class Expected:
    """Expected error of a signal in a new log, from logs that were left out in turn."""

    output: str
    unit: str  # SI
    rms: float  # mean of the left-out logs' rms errors
    low: float  # one new log in ten is predicted better
    high: float  # one in ten is predicted worse
    relative_rms: float  # rms over the range of the signal in all fitted logs
    held_out_rms: tuple[float, ...]  # rms of each left-out log


@dataclass(frozen=True)
class Fit:
    """Fitted model."""

    model: Model
    estimates: tuple[FittedParameter, ...]  # of the model's unknowns, in order
    simulated: Array  # all outputs with the fitted values, one after the other
    converged: bool  # whether the search converged
    simulations: int  # number of simulation runs
    partial: bool = False  # whether the user stopped it
    tracking: Model | None = (
        None  # model with feedback of the logs that simulated the outputs, where a free one diverged
    )
    expected: tuple[Expected, ...] = ()  # errors to expect of a new log, where that was estimated

    @property
    def remarks(self) -> tuple[str, ...]:
        """Return remarks on the model, in sentences."""
        return (*self.model.remarks, *(() if self.tracking is None else self.tracking.remarks))

    @cached_property
    def values(self) -> Array:
        """Return the fitted values, (unknowns,) in SI."""
        return np.array([estimate.value for estimate in self.estimates])

    @property
    def trusted(self) -> bool:
        """Return whether the search converged, no value is at a bound, and no output is mispredicted."""
        return self.converged and not any(one.at_bound for one in self.estimates) and self.mispredicted is None

    @cached_property
    def predictions(self) -> list[Quality]:
        """Return the qualities over validation samples of those outputs that are fitted in other samples."""
        qualities = self.qualities()
        fitted = {one.output for one in qualities if not one.validation}
        return [one for one in qualities if one.validation and one.output in fitted]

    @property
    def mispredicted(self) -> Quality | None:
        """Return the worst prediction beyond `MAX_PREDICTION_ERROR` (with feedback `MAX_TRACKING_ERROR`), or None."""
        worst = max(self.predictions, key=lambda one: one.relative_rms, default=None)
        limit = MAX_PREDICTION_ERROR if self.tracking is None else MAX_TRACKING_ERROR
        return worst if worst is not None and worst.relative_rms > limit else None

    def estimate(self, path: str) -> FittedParameter:
        """Return the estimate of the unknown at a path, which must exist."""
        return next(estimate for estimate in self.estimates if estimate.unknown.path == path)

    def qualities(self) -> list[Quality]:
        """Return the quality of every output, over the fitted samples and over those for validation."""
        qualities = []
        for rows, output in zip(self.model.slices, self.model.outputs, strict=True):
            for validation in (False, True):
                chosen = (output.fitted != validation) & np.isfinite(output.measured)
                if chosen.any():
                    qualities.append(compute_quality(output, chosen, self.simulated[rows], validation=validation))
        return qualities


def relative_error(qualities: Sequence[Quality]) -> float:
    """Return the root mean square of the `relative_rms` of several outputs; infinite where one diverged."""
    shares = [one.relative_rms for one in qualities]
    return float(np.sqrt(np.mean(np.square(shares)))) if np.isfinite(shares).all() else np.inf


def choose_simplest(errors: Sequence[float]) -> int:
    """Return the index of the first, simplest model whose error is at most 1.1 times the least, or 0.001 above it.

    Args:
        errors: over the range, the simplest model first.
    """
    limit = max(EQUIVALENT_ERROR_RATIO * min(errors), min(errors) + EQUIVALENT_ERROR_MARGIN)
    return next(i for i, error in enumerate(errors) if error <= limit)


def expected_errors(left_out: Mapping[str, Array], model: Model) -> tuple[Expected, ...]:
    """Return the error to expect of each signal in a new log.

    Args:
        left_out: rms error (SI) of each left-out part, by signal.
        model: model whose logs these are.
    """
    expected = []
    for name, errors in left_out.items():
        outputs = [one for one in model.outputs if one.name == name and one.fitted.any()]
        measured = np.concatenate([one.measured[one.fitted & np.isfinite(one.measured)] for one in outputs])
        low, high = _new_log_range(errors)
        rms = float(errors.mean())
        share = rms / float(np.ptp(measured)) if np.ptp(measured) > 0.0 else np.inf
        expected.append(Expected(name, outputs[0].unit, rms, low, high, share, tuple(map(float, errors))))
    return tuple(expected)


def _new_log_range(errors: Array) -> tuple[float, float]:
    """Return the rms errors between which eight of ten new logs lie, if logarithms of errors are normal.

    They are 0 and infinite for fewer than two errors, or if one is zero or infinite.
    """
    from scipy.stats import t  # noqa: PLC0415  # scipy.stats takes long to import

    n = len(errors)
    if n < 2 or not (np.isfinite(errors).all() and (errors > 0.0).all()):  # a standard deviation needs two
        return 0.0, np.inf
    logs = np.log(errors)
    half = float(t.ppf(EXPECTED_QUANTILE, n - 1) * logs.std(ddof=1) * np.sqrt(1.0 + 1.0 / n))
    return float(np.exp(logs.mean() - half)), float(np.exp(logs.mean() + half))


def compute_quality(output: ModelOutput, chosen: Flags, simulated: Array, *, validation: bool) -> Quality:
    """Return the quality of the prediction of an output's chosen samples; its errors are infinite if one is not finite.

    Where the measured samples are constant, `relative_rms` is infinite and `fit` minus infinite.

    Args:
        output: output with its measured samples.
        chosen: samples to compare, (samples,).
        simulated: the same signal, (samples,).
        validation: whether the chosen samples were not fitted.
    """
    measured, error = output.measured[chosen], simulated[chosen] - output.measured[chosen]
    if not np.isfinite(error).all():
        labels = (output.name, output.unit, output.log, validation, len(error))
        return Quality(*labels, rms=np.inf, bias=np.inf, relative_rms=np.inf, fit=-np.inf, white=0.0, driven=None)
    rms, deviation, span = float(np.sqrt(np.mean(error**2))), float(np.std(measured)), float(np.ptp(measured))
    lags = range(1, min(MAX_LAGS, len(error) - 2) + 1)
    autocorrelation = [abs(_correlation(error[lag:], error[:-lag])) for lag in lags]
    below = np.array(autocorrelation) < WHITE_NOISE_BAND / np.sqrt(len(error))
    return Quality(
        output.name, output.unit, output.log, validation, len(error), rms, float(error.mean()),
        relative_rms=rms / span if span > 0.0 else np.inf,
        fit=1.0 - rms / deviation if deviation > 0.0 else -np.inf,
        white=float(np.mean(below)) if autocorrelation else 1.0,
        driven=None if output.driven_by is None else _max_input_correlation(error, output.driven_by[chosen]),
    )  # fmt: skip


def _max_input_correlation(error: Array, driving: Array) -> float:
    """Return the greatest correlation, by size, of an error with an input up to `MAX_LAGS` samples before."""
    lags = range(min(MAX_LAGS, len(error) - 2))
    return max((abs(_correlation(error[lag:], driving[: len(driving) - lag])) for lag in lags), default=0.0)


def _correlation(a: Array, b: Array) -> float:
    """Return the correlation of two signals, -1 to 1; 0 if one is constant."""
    a, b = a - a.mean(), b - b.mean()
    power = float(np.sqrt((a @ a) * (b @ b)))
    return float(a @ b) / power if power > 0.0 else 0.0
