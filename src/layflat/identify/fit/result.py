"""What a fit found, how sure it is, and how well it predicts."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from layflat.arrays import Array
from layflat.identify.model import Flags, Model, Output
from layflat.identify.unknown import Unknown

SURE = 0.2  # a parameter is identified if its interval reaches less than this beyond it: of it, or of half its range
ALIKE = 0.95  # correlation from which on two parameters are identified only together
MISPREDICTED = 0.25  # a prediction that misses by more (rms over range) is none: the search ended in a wrong minimum
LED_ASTRAY = 0.05  # the same of a run that is drawn to its log
LAGS = 25  # lags at which errors are compared with themselves, and with the input
ALIKE_ERRORS = 1.1  # a simpler model is taken if it misses by no more than so many times what the best does
FINE = 1e-3  # or by so little more, share of the range
IN_TEN = 0.9  # share of new logs that are predicted better than the upper end of what is expected
BAND = 1.959964  # what stays within so many over the root of the number of samples is chance, in 95 of 100 lags


@dataclass(frozen=True)
class Estimate:
    """A value with its 95 % interval, SI."""

    unknown: Unknown  # what was looked for
    value: float  # best found
    low: float  # lower end of the interval
    high: float  # upper end
    at_bound: bool  # whether it hit its bound
    partner: str | None = None  # the parameter that it can't be separated from, if any

    @property
    def identified(self) -> bool:
        """Whether the log identifies it."""
        if self.at_bound:
            return False
        if self.unknown.log:
            return self.low > 0.0 and bool(0.5 * np.log(self.high / self.low) < np.log1p(SURE))
        return self.high - self.low < SURE * (self.unknown.high - self.unknown.low)


@dataclass(frozen=True)
class Quality:
    """How well an output is predicted."""

    output: str  # its name
    unit: str  # SI
    log: str  # which log
    validation: bool  # over samples that were not fitted
    samples: int  # how many
    rms: float  # of the error, in `unit`
    bias: float  # mean error, in `unit`
    share: float  # rms over the range of what was measured
    fit: float  # 1 - rms / standard deviation of what was measured
    white: float  # share of the lags at which errors resemble themselves no more than chance; 0.95 for a perfect model
    driven: float | None  # greatest correlation of the error with the input, at any lag; None where no input is known

    @property
    def diverged(self) -> bool:
        """Whether the simulation came to no end: nothing is predicted then."""
        return not np.isfinite(self.rms)


@dataclass(frozen=True)
class Expected:
    """Error to expect of a signal in a new log: from logs that were left out in turn."""

    output: str
    unit: str  # SI
    rms: float  # mean of the left-out logs' rms errors
    low: float  # one new log in ten is predicted better
    high: float  # one in ten is predicted worse
    share: float  # rms over the range of the signal in all fitted logs
    left_out: tuple[float, ...]  # rms of each left-out log


@dataclass(frozen=True)
class Fit:
    """A fitted model."""

    model: Model  # what was fitted
    estimates: tuple[Estimate, ...]  # of its unknowns, in order
    simulated: Array  # all outputs with the best values, one after the other
    converged: bool  # whether the search converged
    simulations: int  # runs that it took
    partial: bool = False  # whether the user stopped it
    led: Model | None = None  # what simulated the outputs in place of the model, drawn to the logs
    expected: tuple[Expected, ...] = ()  # errors to expect of a new log, where that was estimated

    @property
    def remarks(self) -> tuple[str, ...]:
        """What is to be said of the model, in sentences."""
        return (*self.model.remarks, *(() if self.led is None else self.led.remarks))

    @cached_property
    def values(self) -> Array:
        """Best values, (unknowns,) in SI."""
        return np.array([estimate.value for estimate in self.estimates])

    @property
    def trusted(self) -> bool:
        """Whether it converged with no value at a bound, and predicts."""
        return self.converged and not any(one.at_bound for one in self.estimates) and self.mispredicted is None

    @cached_property
    def predictions(self) -> list[Quality]:
        """How well what is fitted elsewhere is predicted."""
        found = self.qualities()
        fitted = {one.output for one in found if not one.validation}
        return [one for one in found if one.validation and one.output in fitted]

    @property
    def mispredicted(self) -> Quality | None:
        """The worst prediction, if it misses by too much."""
        worst = max(self.predictions, key=lambda one: one.share, default=None)
        most = MISPREDICTED if self.led is None else LED_ASTRAY
        return worst if worst is not None and worst.share > most else None

    def of(self, path: str) -> Estimate:
        """The estimate of an unknown."""
        return next(estimate for estimate in self.estimates if estimate.unknown.path == path)

    def qualities(self) -> list[Quality]:
        """Of every output, over the fitted samples and over those for validation."""
        found = []
        for place, output in zip(self.model.slices, self.model.outputs, strict=True):
            for validation in (False, True):
                chosen = (output.fitted != validation) & np.isfinite(output.measured)
                if chosen.any():
                    found.append(quality(output, chosen, self.simulated[place], validation=validation))
        return found


def choose(errors: Sequence[float]) -> int:
    """Return which of several models is taken: the first, the simplest, that misses by no more than the best does.

    Args:
        errors: shares of the range, the simplest model first.
    """
    most = max(ALIKE_ERRORS * min(errors), min(errors) + FINE)
    return next(i for i, error in enumerate(errors) if error <= most)


def expected_errors(left_out: Mapping[str, Array], model: Model) -> tuple[Expected, ...]:
    """Return the error to expect of each signal in a new log.

    Args:
        left_out: rms error (SI) of each left-out part, by signal.
        model: whose logs these are.
    """
    found = []
    for name, errors in left_out.items():
        mine = [one for one in model.outputs if one.name == name and one.fitted.any()]
        reach = np.concatenate([one.measured[one.fitted & np.isfinite(one.measured)] for one in mine])
        low, high = _new_one(errors)
        rms = float(errors.mean())
        share = rms / float(np.ptp(reach)) if np.ptp(reach) > 0.0 else np.inf
        found.append(Expected(name, mine[0].unit, rms, low, high, share, tuple(map(float, errors))))
    return tuple(found)


def _new_one(errors: Array) -> tuple[float, float]:
    """Return between which rms errors eight of ten new logs lie: logarithms of errors are taken for normal."""
    from scipy.stats import t  # noqa: PLC0415  # scipy.stats takes long to import

    n = len(errors)
    if n < 2 or not (np.isfinite(errors).all() and (errors > 0.0).all()):  # a spread needs two
        return 0.0, np.inf
    logs = np.log(errors)
    half = float(t.ppf(IN_TEN, n - 1) * logs.std(ddof=1) * np.sqrt(1.0 + 1.0 / n))
    return float(np.exp(logs.mean() - half)), float(np.exp(logs.mean() + half))


def quality(output: Output, chosen: Flags, simulated: Array, *, validation: bool) -> Quality:
    """Of the chosen samples of an output."""
    measured, error = output.measured[chosen], simulated[chosen] - output.measured[chosen]
    if not np.isfinite(error).all():
        whole = (output.name, output.unit, output.log, validation, len(error))
        return Quality(*whole, rms=np.inf, bias=np.inf, share=np.inf, fit=-np.inf, white=0.0, driven=None)
    rms, spread, reach = float(np.sqrt(np.mean(error**2))), float(np.std(measured)), float(np.ptp(measured))
    alike = [abs(_correlation(error[lag:], error[:-lag])) for lag in range(1, min(LAGS, len(error) - 2) + 1)]
    return Quality(
        output.name, output.unit, output.log, validation, len(error), rms, float(error.mean()),
        share=rms / reach if reach > 0.0 else np.inf,
        fit=1.0 - rms / spread if spread > 0.0 else -np.inf,
        white=float(np.mean(np.array(alike) < BAND / np.sqrt(len(error)))) if alike else 1.0,
        driven=None if output.driven_by is None else _driven(error, output.driven_by[chosen]),
    )  # fmt: skip


def _driven(error: Array, given: Array) -> float:
    lags = range(min(LAGS, len(error) - 2))
    return max((abs(_correlation(error[lag:], given[: len(given) - lag])) for lag in lags), default=0.0)


def _correlation(a: Array, b: Array) -> float:
    a, b = a - a.mean(), b - b.mean()
    power = float(np.sqrt((a @ a) * (b @ b)))
    return float(a @ b) / power if power > 0.0 else 0.0
