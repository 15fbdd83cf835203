"""Models for the tests of fitting, small enough to know the answer."""

from collections.abc import Sequence
from copy import copy
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from layflat.identify import Model, ModelOutput, Unknown
from layflat.identify.model import Scaling

Array = NDArray[np.float64]

TIME = np.linspace(0.0, 4.0, 401)


class Decay(Model):
    """y = height exp(-rate t) + level: all told, unless the log ends too early."""

    def __init__(self, truth: Array, noise: float, seed: int, until: float = 4.0, bounds: float = 4.0) -> None:
        self.unknowns = (
            Unknown("height", "V", 1.0, 1.0 / bounds, bounds, excitation="a start away from rest"),
            Unknown("rate", "1/s", 1.0, 1.0 / bounds, bounds, excitation="a log that lasts until rest"),
            Unknown("level", "V", 0.0, -1.0, 1.0, log=False, excitation="a log that lasts until rest"),
        )
        self.time = TIME[until >= TIME]
        exact = self.simulate(truth[None])[0]
        measured = exact + noise * np.random.default_rng(seed).standard_normal(len(self.time))
        fitted = self.time <= 0.75 * until
        self.outputs = (ModelOutput("y", "V", "log", self.time, measured, fitted, noise),)

    def simulate(self, values: Array) -> Array:
        height, rate, level = values.T[:, :, None]
        return np.asarray(height * np.exp(-rate * self.time) + level)


class ByLifetime(Decay):
    """The same, searched by 1 / rate and by height + level, that is the beginning."""

    @cached_property
    def scaling(self) -> Scaling:
        return _Lifetimes(self.unknowns)


class _Lifetimes(Scaling):
    def __init__(self, unknowns: Sequence[Unknown]) -> None:
        super().__init__(unknowns)
        self.plain = Scaling(unknowns)
        height, _, level = unknowns
        self.low[0], self.high[0], self.log[:2] = height.low + level.low, height.high + level.high, False

    def scale(self, values: Array) -> Array:
        height, rate, level = values.T
        return super().scale(np.stack([height + level, 1.0 / rate, level]).T)

    def unscale(self, shares: Array) -> Array:
        beginning, lifetime, level = super().unscale(shares).T
        return np.stack([beginning - level, 1.0 / lifetime, level]).T


class Product(Model):
    """y = a b t: only the product of a and b is told."""

    unknowns = (Unknown("a", "1", 1.0, 0.2, 5.0), Unknown("b", "1", 1.0, 0.2, 5.0))

    def __init__(self) -> None:
        measured = 2.0 * TIME + 0.01 * np.random.default_rng(0).standard_normal(len(TIME))
        self.outputs = (ModelOutput("y", "1", "log", TIME, measured, np.ones(len(TIME), bool), 0.01),)

    def simulate(self, values: Array) -> Array:
        return np.asarray(values[:, 0, None] * values[:, 1, None] * TIME)


class Linearly(Product):
    """y = a t: nothing is told of b, which is searched linearly, though its range is one of factors."""

    def simulate(self, values: Array) -> Array:
        return np.asarray(values[:, 0, None] * TIME)

    @cached_property
    def scaling(self) -> Scaling:
        found = Scaling(self.unknowns)
        found.plain, found.log = Scaling(self.unknowns), np.array([True, False])
        return found


class Level(Model):
    """y = level + shift, where little but nothing sure is known of the shift before."""

    def __init__(self, shifted: tuple[float, float], most: float = 10.0) -> None:
        self.unknowns = (
            Unknown("level", "V", 0.0, -10.0, most, log=False, ceiling=True),
            Unknown("shift", "V", 0.0, -10.0, 10.0, log=False, prior=shifted),
        )
        measured = 3.0 + 0.5 * np.random.default_rng(0).standard_normal(len(TIME))
        self.outputs = (ModelOutput("y", "V", "log", TIME, measured, np.ones(len(TIME), bool), 0.5),)

    def simulate(self, values: Array) -> Array:
        return np.asarray(values.sum(axis=1)[:, None] * np.ones(len(TIME)))


class TwoTones(Model):
    """y = sin(w t): many minima over w; the guess lies in a wrong one."""

    unknowns = (Unknown("w", "rad/s", 3.0, 1.0, 20.0),)

    def __init__(self, given: bool) -> None:
        measured = np.sin(9.0 * TIME) + 0.05 * np.random.default_rng(0).standard_normal(len(TIME))
        self.outputs = (ModelOutput("y", "1", "log", TIME, measured, np.ones(len(TIME), bool), 0.05),)
        self.given = given

    def simulate(self, values: Array) -> Array:
        found = np.sin(values[:, :1] * TIME)
        found[values[:, 0] > 15.0] = np.nan
        return np.asarray(found)

    def starts(self) -> Array:
        return np.linspace(1.5, 19.0, 60)[:, None] if self.given else super().starts()


class Led(Model):
    """dx/dt = rate x + push u, with something unknown that shakes it, and less and less of what draws x to its log."""

    unknowns = (Unknown("rate", "1/s", 1.0, -2.0, 8.0, log=False), Unknown("push", "1/s", 1.0, 0.2, 5.0))

    def __init__(self, rate: float, push: float, seed: int = 0) -> None:
        draw, x, step = np.random.default_rng(seed), 0.0, TIME[1]
        measured, self.pushes = np.empty(len(TIME)), np.empty(len(TIME))
        for k, time in enumerate(TIME):
            measured[k] = x
            self.pushes[k] = (2.0 * np.sign(np.sin(5.0 * time)) - (rate + 3.0) * x) / push
            x += step * (rate * x + push * self.pushes[k]) + 0.005 * draw.standard_normal()
        self.outputs = (ModelOutput("x", "1", "log", TIME, measured, TIME <= 3.0, 0.01),)
        self.lead = 0.0

    def at(self, lead: float) -> "Led":
        found = copy(self)
        found.lead = lead
        return found

    def continuations(self) -> list[list["Led"]]:
        return [[self.at(lead) for lead in (20.0, 8.0)]]

    def tracking_model(self) -> "Led":
        found = self.at(8.0)
        found.remarks = ("It is led.",)
        return found

    def simulate(self, values: Array) -> Array:
        rate, push = values.T
        found, (measured,) = np.zeros((len(values), len(TIME))), [output.measured for output in self.outputs]
        for k, x in enumerate(found.T[:-1]):
            drawn = self.lead * (measured[k] - x)
            found[:, k + 1] = x + TIME[1] * (rate * x + push * self.pushes[k] + drawn)
        return found


class Polynomial(Model):
    """y = a + b x + c x^2 + d x^3 in several logs with errors of their own; simpler ones leave out c, d."""

    cross_validated = True

    def __init__(self, truth: Sequence[float], logs: int, noise: float, seed: int = 0) -> None:
        self.unknowns = tuple(Unknown(name, "V", 0.0, -10.0, 10.0, log=False) for name in "abcd")
        random = np.random.default_rng(seed)
        self.places = [np.sort(random.uniform(-1.0, 1.0, 40)) for _ in range(logs)]
        outputs = []
        for number, x in enumerate(self.places):
            measured = np.polynomial.polynomial.polyval(x, truth) + noise * random.standard_normal(len(x))
            outputs.append(ModelOutput("y", "V", f"log {number}", np.arange(40.0), measured, np.ones(40, bool), noise))
        self.outputs = tuple(outputs)

    def simpler_models(self) -> dict[str, Model]:
        return {"line": self.hold("cd"), "parabola": self.hold("d")}

    def simulate(self, values: Array) -> Array:
        columns = self.columns(values)
        powers = [columns.get(name, np.zeros(len(values))) for name in "abcd"]
        return np.concatenate([sum(one[:, None] * x**i for i, one in enumerate(powers)) for x in self.places], axis=1)


class Twins(Model):
    """y = share exp(-fast t) + (1 - share) exp(-slow t): of halves nothing tells which is which."""

    def __init__(self, share: float, rates: tuple[float, float], noise: float) -> None:
        self.share = share
        self.unknowns = tuple(Unknown(name, "1/s", guess, 0.1, 10.0) for name, guess in (("fast", 1.5), ("slow", 1.4)))
        measured = self.simulate(np.array([rates]))[0]
        measured += noise * np.random.default_rng(3).standard_normal(len(TIME))
        self.outputs = (ModelOutput("y", "V", "log", TIME, measured, np.ones(len(TIME), dtype=bool), noise),)

    def simulate(self, values: Array) -> Array:
        first, second = np.exp(-values.T[:, :, None] * TIME)
        return np.asarray(self.share * first + (1.0 - self.share) * second)

    def mirrored_values(self, values: Array) -> Array:
        return values[None, ::-1]
