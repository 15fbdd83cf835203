"""Search for the values that predict best: several starts, each refined a little, the best of them to the end."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.identify.fit.certainty import Residuals, blocks_of, bootstrap, covariance, interval, is_told
from layflat.identify.fit.result import ALIKE, Estimate, Fit
from layflat.identify.model import Model

Progress = Callable[[float, str], None]  # called with the share of the work that is done at most, and the present task
STARTS, REFINED = 32, 3  # starts that are drawn, and how many of them are refined

SPREAD = 0.25  # every other start is this near to the guess, as a share of the way between the bounds; others anywhere
SHORT, LONG = 6, 60  # steps of a start's refinement, and of the last one
NEAR = 8  # steps from values of all logs to those of all but one
ROUNDS = 2  # refinements of the last model; the outputs are weighed after each

EXPLAINED = 3.0  # a continuation is good enough where the mean square of the residuals, in their scale, is below this
OUTLYING = 2.0  # residuals beyond this, in units of their scale, count less at first in every model of a continuation

ALIKE_COST = 25.0  # values that mirror the best are refined where their cost is below so many times its own
BASIN_HOPS = 4  # how often to try to leave a small local minimum
HOP_SIZES = (1.0, 3.0, 10.0, 30.0)  # how far to hop, in standard deviations
WORTH = 1e-4  # basin hopping goes on as long as the cost falls by more than this share
PASSES = 6  # jacobians one after the other at the end: each finds the axes better
EDGE = 2e-3  # a share within this of 0 or 1 is at its bound
TOLERANCE = 1e-6  # the search ends where the cost falls by less than this in a step, relative
ROUGH = 1e-4  # the same of the models before the last


def fit(model: Model, *, starts: int = STARTS, seed: int = 0, progress: Progress | None = None) -> Fit:
    """Find the unknowns of a model from its fitted samples.

    Args:
        model: what is fitted; its guess is the first start. Raise InputError if bounds leave no room.
        starts: how many more are drawn around it, besides those that the model gives.
        seed: of starts and bootstrap.
        progress: called with the share of the work done and the present task.

    Returns:
        Best values with 95 % intervals, and what they predict. Ctrl-C ends the search: the best values so far are
        returned as a `partial` fit; a second one is not caught.
    """
    search = _Search(model, progress)
    try:
        shares, converged = search.run(starts, seed)
    except KeyboardInterrupt:
        search.tell(0.95, "stopped: intervals of the best values so far")
        return search.result(search.best, False, seed, partial=True)
    search.tell(0.95, "intervals")
    return search.result(shares, converged, seed)


def fit_near(model: Model, values: Array, *, seed: int = 0) -> Fit:
    """Find the unknowns of a model from its fitted samples, begun near the best values.

    Args:
        model: what is fitted.
        values: of its unknowns, where the search begins.
        seed: of the bootstrap.
    """
    search = _Search(model, None)
    shares, converged = search.converge(model, search.shares_of(values), robust=True, rounds=1)
    return search.result(shares, converged, seed)


def search_near(model: Model, values: Array) -> Array:
    """Return values that a few steps from others lead to, (unknowns,): near the best, without their intervals."""
    search = _Search(model, None)
    begun = search.shares_of(values)
    search.weigh(begun)
    shares, _ = search.refine(begun, NEAR, "fitting")
    return search.residuals.scaled.values(shares)


class _Search:
    def __init__(self, model: Model, progress: Progress | None) -> None:
        self.free = model
        self.progress, self.done, self.simulations = progress, 0.0, 0
        self.tolerance = ROUGH
        self.rivals = list[tuple[NDArray[np.intp], Array]]()  # which values may be others as well, and these, in SI
        self.take(model)

    def run(self, starts: int, seed: int) -> tuple[Array, bool]:
        """Search by continuation, then by basin hopping: shares, and whether the search converged."""
        tried, continuations = list[tuple[float, Array]](), self.free.continuations()
        for number, models in enumerate(continuations):
            # Most ways lead from the description to the logs: others are looked for where this one does not.
            drawn = starts if number or len(models) == 1 else 0
            tried.append(self.follow(models, drawn, seed + number))
            if tried[-1][0] < EXPLAINED:
                break
        self.tolerance = TOLERANCE
        start = min(tried, key=lambda one: one[0])[1]
        shares, converged = self.converge(continuations[0][-1], start, robust=len(continuations[0]) > 1)
        shares, converged = self.leave_mirrored(shares, converged)
        return self.basin_hop(shares, converged, seed)

    def take(self, model: Model) -> None:
        """Go on with a model of the same unknowns."""
        self.model, self.residuals = model, Residuals(model)
        self.best, self.least = self.residuals.begun, np.inf

    def shares_of(self, values: Array) -> Array:
        """Return values as shares that lie within the bounds."""
        return np.asarray(np.clip(self.residuals.scaled.of(values), 0.0, 1.0))

    def tell(self, share: float, text: str) -> None:
        self.done = max(self.done, share)
        if self.progress is not None:
            self.progress(self.done, text)

    def follow(self, models: Sequence[Model], starts: int, seed: int) -> tuple[float, Array]:
        """Through all models of a continuation but the last: mean square of the residuals there, and shares."""
        self.take(models[0])
        shares = self.begin(starts, seed)
        for model in models[:-1]:
            shares, _ = self.converge(model, shares, robust=True, rounds=1)
            shares = model.settled(shares, self.residuals.triangle)
        last = Residuals(models[-1])
        return float(np.mean(last.data(shares[None]) ** 2)), shares

    def converge(self, model: Model, shares: Array, *, robust: bool, rounds: int = ROUNDS) -> tuple[Array, bool]:
        """The best values for a model, from those of the one before; and whether the search converged."""
        self.take(model)
        self.best = shares
        converged = False
        if robust:
            # A stick or slip that comes at another instant is not to draw all values its way.
            shares, _ = self.refine(shares, LONG, "continuation", loss="soft_l1")
        for _ in range(rounds):
            shares, converged = self.refine(shares, LONG, "fitting")
            # Outputs count by how well they can be predicted at all.
            self.weigh(shares)
        return shares, converged

    def begin(self, starts: int, seed: int) -> Array:
        """The best of several starts after a few steps."""
        guess, given = self.residuals.begun, self.residuals.scaled.of(self.model.starts())
        tried = np.vstack([guess, np.clip(given, 0.0, 1.0), self._drawn(starts, seed)])
        self.simulations += len(tried)
        self.tell(0.02, f"{len(tried)} starts")
        best = np.argsort(self.residuals.costs(tried), kind="stable")[:REFINED]
        if 0 not in best:
            best = np.concatenate([[0], best[: REFINED - 1]])
        if len(tried) == 1:
            return np.asarray(guess)
        refined = [self.refine(tried[i], SHORT, f"start {k + 1} of {len(best)}")[0] for k, i in enumerate(best)]
        return refined[int(np.argmin(self.residuals.costs(np.array(refined))))]

    def _drawn(self, starts: int, seed: int) -> Array:
        from scipy.stats import qmc  # noqa: PLC0415  # scipy.stats takes long to import

        n = len(self.model.unknowns)
        if starts == 0:
            return np.empty((0, n))
        drawn = qmc.Sobol(n, rng=np.random.default_rng(seed)).random(1 << (starts - 1).bit_length())[:starts]
        drawn[::2] = np.clip(self.residuals.begun + SPREAD * (2.0 * drawn[::2] - 1.0), 0.0, 1.0)
        return np.asarray(drawn)

    def leave_mirrored(self, shares: Array, converged: bool) -> tuple[Array, bool]:
        """Leave values for those that mirror them, one pair after the other, where these predict better.

        Those of the worse ones that logs can't tell from the better are kept as rivals.
        """
        for number in range(len(self.free.mirrored(self.free.guess))):
            cost, values = float(self.residuals.costs(shares[None])[0]), self.residuals.scaled.values(shares)
            mirrored = self.free.mirrored(values)[number]
            begun = self.shares_of(mirrored)
            self.simulations += 1
            if not self.residuals.costs(begun[None])[0] < ALIKE_COST * cost:
                continue
            other, ended = self.refine(begun, LONG, "mirrored values")
            r, others = self.residuals.data(np.array([shares, other]))
            worse = other
            if self.residuals.costs(other[None])[0] < cost:
                shares, converged, worse = other, ended, shares
            if not is_told(r, others, blocks_of(self.model, r)):
                self.rivals.append((np.flatnonzero(mirrored != values), self.residuals.scaled.values(worse)))
            self.weigh(shares)
        return shares, converged

    def basin_hop(self, shares: Array, converged: bool, seed: int) -> tuple[Array, bool]:
        """Leave small local minima: candidates along the principal axes, the best of them refined, while that helps."""
        random, best = np.random.default_rng(seed), float(self.residuals.costs(shares[None])[0])
        for _ in range(BASIN_HOPS):
            sizes = np.repeat(HOP_SIZES, STARTS // len(HOP_SIZES))[:, None] / np.maximum(self.residuals.strengths, 1.0)
            moves = sizes * random.standard_normal(sizes.shape) @ self.residuals.axes
            tried = np.clip(shares + moves, 0.0, 1.0)
            self.simulations += len(tried)
            refined, ended = self.refine(tried[int(np.argmin(self.residuals.costs(tried)))], LONG, "basin hopping")
            cost = float(self.residuals.costs(refined[None])[0])
            if cost > best - max(1.0, WORTH * best):
                break
            shares, converged, best = refined, ended, cost
            self.weigh(shares)
            best = float(self.residuals.costs(shares[None])[0])
        return shares, converged

    def refine(
        self, shares: Array, steps: int, text: str, loss: Literal["linear", "soft_l1"] = "linear"
    ) -> tuple[Array, bool]:
        """Least squares from a start, and whether it converged within so many steps."""
        from scipy.optimize import least_squares  # noqa: PLC0415  # scipy.optimize takes long to import

        def residuals(at: Array) -> Array:
            self.simulations += 1
            self.tell(self.done + 0.03 * (0.95 - self.done), text)
            found = self.residuals(at)
            cost = float(found @ found)
            if cost < self.least:
                self.best, self.least = at.copy(), cost
            return found

        def jacobian(at: Array) -> Array:
            self.simulations += 2 * len(at)
            return self.residuals.jacobian(at)

        ends: dict[str, Any] = {"ftol": self.tolerance, "xtol": 1e-8, "gtol": 1e-8, "max_nfev": steps}
        inside = np.clip(shares, 1e-6, 1.0 - 1e-6)
        found = least_squares(residuals, inside, jacobian, bounds=(0.0, 1.0), loss=loss, f_scale=OUTLYING, **ends)
        return np.asarray(found.x), bool(found.status > 0)

    def weigh(self, shares: Array) -> None:
        """Scale every output by its error, where that is larger than what its scale says."""
        found = self.model.simulate(self.residuals.scaled.values(shares[None]))[0]
        for i, (place, output) in enumerate(zip(self.model.slices, self.model.outputs, strict=True)):
            chosen = self.model.used[place]
            if chosen.any():
                rms = float(np.sqrt(np.mean((found[place][chosen] - output.measured[chosen]) ** 2)))
                self.residuals.scales[i] = max(output.scale, rms) if np.isfinite(rms) else output.scale
        self.best, self.least = shares, np.inf

    def result(self, shares: Array, converged: bool, seed: int, *, partial: bool = False) -> Fit:
        """Estimates with their intervals, and what they predict by the model that runs freely, if that can be."""
        scaled, model, passes = self.residuals.scaled, self.model, 1 if partial else PASSES
        found = np.clip(scaled.of(scaled.values(shares)), 0.0, 1.0)
        for number in range(passes):
            J = self.residuals.data_jacobian(found)
            if number == passes // 2:  # by a Jacobian whose axes have been found
                found = model.settled(found, self.residuals.triangle)
        r = self.residuals.data(found[None])[0]
        self.simulations += 2 * passes * len(found) + 2
        # Knowledge and priors are those of what was searched: only then is it brought to the unknowns themselves.
        values, (shares, slopes) = scaled.values(found), scaled.as_own(found)
        spread = slopes @ covariance(J, r, self.residuals.widths) @ slopes.T
        moves = bootstrap(J, r, self.residuals.widths, blocks_of(model, r), seed) @ slopes.T
        low, high = interval(shares, spread, moves)
        for which, others in self.rivals:
            away = (scaled.own.of(others) - shares)[which]
            low[which] += np.minimum(away, 0.0)
            high[which] += np.maximum(away, 0.0)
        lows, highs = scaled.own.values(low), scaled.own.values(high)
        sizes = np.sqrt(np.diag(spread))
        alike = np.abs(spread / np.outer(sizes, sizes)) - 2.0 * np.eye(len(shares))
        estimates = []
        for i, unknown in enumerate(model.unknowns):
            partner = int(np.argmax(alike[i]))
            together = model.unknowns[partner].path if alike[i, partner] > ALIKE else None
            low_end, high_end = found[i] < EDGE and not unknown.floor, found[i] > 1.0 - EDGE and not unknown.ceiling
            estimates.append(
                Estimate(
                    unknown, float(values[i]), float(lows[i]), float(highs[i]), bool(low_end or high_end), together
                )
            )
        simulated = self.free.simulate(values[None])[0]
        told = Fit(self.free, tuple(estimates), simulated, converged, self.simulations, partial)
        led = self.free.led() if told.mispredicted is not None else None
        return told if led is None else replace(told, led=led, simulated=led.simulate(values[None])[0])
