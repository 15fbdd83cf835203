"""Search for the values that predict best: several starts, each refined a little, the best of them to the end."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.identify.fit.certainty import (
    Residuals,
    are_distinguishable,
    assign_blocks,
    bootstrap_moves,
    confidence_interval,
    covariance,
)
from layflat.identify.fit.result import INSEPARABLE_CORRELATION, Fit, FittedParameter
from layflat.identify.model import Model

Progress = Callable[[float, str], None]  # called with the fraction of the work that is done at most, and the task
RANDOM_STARTS, REFINED_STARTS = 32, 3  # starts that are drawn, and the number of them that are refined

START_RADIUS = 0.25  # every other start is at most so far from the guess, scaled; the others lie anywhere
START_STEPS, REFINEMENT_STEPS = 6, 60  # steps of a start's refinement, and of a model's
NEARBY_STEPS = 8  # steps from values of all logs to those of all but one
SCALING_ROUNDS = 2  # refinements of the last model; the outputs are scaled by their errors after each

EXPLAINED_MEAN_SQUARE = 3.0  # mean square of the scaled residuals below which a continuation explains the logs
OUTLIER_RESIDUAL = 2.0  # scaled residuals beyond this count less at first in every model of a continuation

MAX_MIRROR_COST_RATIO = 25.0  # mirrored values are refined where their cost over that of the best is below this
MAX_BASIN_HOPS = 4  # attempts to leave a small local minimum
HOP_SIZES = (1.0, 3.0, 10.0, 30.0)  # lengths of hops, in standard deviations
MIN_COST_DECREASE = 1e-4  # relative decrease of the cost below which basin hopping ends
JACOBIAN_PASSES = 6  # Jacobians one after the other at the end: each aligns the axes better
BOUND_MARGIN = 2e-3  # a scaled value within this of 0 or 1 is at its bound
FINAL_TOLERANCE = 1e-6  # relative decrease of the cost in a step below which the search ends
CONTINUATION_TOLERANCE = 1e-4  # the same of the models before the last


def fit(model: Model, *, starts: int = RANDOM_STARTS, seed: int = 0, progress: Progress | None = None) -> Fit:
    """Estimate the unknowns of a model from its fitted samples.

    Args:
        model: model to be fitted; its guess is the first start.
        starts: number of starts that are drawn around the guess, besides those of the model.
        seed: seed of starts and bootstrap.
        progress: called with the fraction of the work done and the present task.

    Returns:
        Values with 95 % intervals, and their predictions. Ctrl-C ends the search: the best values so far are returned
        as a `partial` fit; a second one is not caught.

    Raises:
        InputError: the bounds of an unknown are no range, or its guess lies outside them.
    """
    search = _Search(model, progress)
    try:
        scaled, converged = search.run(starts, seed)
    except KeyboardInterrupt:
        search.report_progress(0.95, "stopped: intervals of the best values so far")
        return search.build_result(search.best, False, seed, partial=True)
    search.report_progress(0.95, "intervals")
    return search.build_result(scaled, converged, seed)


def fit_near(model: Model, values: Array, *, seed: int = 0) -> Fit:
    """Estimate the unknowns of a model from its fitted samples, starting near the best values.

    Args:
        model: model to be fitted.
        values: values of its unknowns (SI), where the search begins.
        seed: seed of the bootstrap.
    """
    search = _Search(model, None)
    scaled, converged = search.fit_model(model, search.scale(values), robust=True, rounds=1)
    return search.build_result(scaled, converged, seed)


def search_near(model: Model, values: Array) -> Array:
    """Return the values (SI), (unknowns,), after up to `NEARBY_STEPS` steps of a search that begins at `values`."""
    search = _Search(model, None)
    start = search.scale(values)
    search.update_scales(start)
    scaled, _ = search.refine(start, NEARBY_STEPS, "fitting")
    return search.residuals.scaling.unscale(scaled)


class _Search:
    """Search of scaled values: the present model with its residuals, the best point so far, and the progress."""

    def __init__(self, model: Model, progress: Progress | None) -> None:
        self.free = model
        self.progress, self.done, self.simulations = progress, 0.0, 0
        self.tolerance = CONTINUATION_TOLERANCE
        # Unknowns whose other values predict as well within chance, and those values (SI).
        self.rivals = list[tuple[NDArray[np.intp], Array]]()
        self.set_model(model)

    def run(self, starts: int, seed: int) -> tuple[Array, bool]:
        """Search by continuation, then by basin hopping: return scaled values, and whether the search converged."""
        tried, continuations = list[tuple[float, Array]](), self.free.continuations()
        for number, models in enumerate(continuations):
            # The first continuation mostly leads from the description to the logs: random starts are for the others.
            drawn = starts if number or len(models) == 1 else 0
            tried.append(self.follow_continuation(models, drawn, seed + number))
            if tried[-1][0] < EXPLAINED_MEAN_SQUARE:
                break
        self.tolerance = FINAL_TOLERANCE
        start = min(tried, key=lambda one: one[0])[1]
        scaled, converged = self.fit_model(continuations[0][-1], start, robust=len(continuations[0]) > 1)
        scaled, converged = self.compare_mirrored(scaled, converged)
        return self.basin_hop(scaled, converged, seed)

    def set_model(self, model: Model) -> None:
        """Continue with a model of the same unknowns: its residuals, and its guess as the best point so far."""
        self.model, self.residuals = model, Residuals(model)
        self.best, self.min_cost = self.residuals.guess, np.inf

    def scale(self, values: Array) -> Array:
        """Return values (SI) scaled, and clipped to the bounds."""
        return np.asarray(np.clip(self.residuals.scaling.scale(values), 0.0, 1.0))

    def report_progress(self, fraction: float, text: str) -> None:
        """Call `progress` with a fraction that never decreases."""
        self.done = max(self.done, fraction)
        if self.progress is not None:
            self.progress(self.done, text)

    def follow_continuation(self, models: Sequence[Model], starts: int, seed: int) -> tuple[float, Array]:
        """Fit all models of a continuation but the last.

        Args:
            models: models from the easiest to the last.
            starts: number of random starts of the first model.
            seed: seed of these starts.

        Returns:
            Mean square of the last model's residuals at the end, and the scaled values there.
        """
        self.set_model(models[0])
        scaled = self.choose_start(starts, seed)
        for model in models[:-1]:
            scaled, _ = self.fit_model(model, scaled, robust=True, rounds=1)
            scaled = model.project(scaled, self.residuals.triangle)
        last = Residuals(models[-1])
        return float(np.mean(last.compute_data(scaled[None]) ** 2)), scaled

    def fit_model(
        self, model: Model, scaled: Array, *, robust: bool, rounds: int = SCALING_ROUNDS
    ) -> tuple[Array, bool]:
        """Refine the values of a model, and scale its outputs by their errors.

        Args:
            model: model to be fitted.
            scaled: start, (unknowns,).
            robust: whether a refinement in which outliers count less comes first.
            rounds: number of refinements.

        Returns:
            Scaled values, and whether the last refinement converged.
        """
        self.set_model(model)
        self.best = scaled
        converged = False
        if robust:
            # A stick or slip at another instant must not dominate all values.
            scaled, _ = self.refine(scaled, REFINEMENT_STEPS, "continuation", loss="soft_l1")
        for _ in range(rounds):
            scaled, converged = self.refine(scaled, REFINEMENT_STEPS, "fitting")
            # An output counts by how well it can be predicted at all.
            self.update_scales(scaled)
        return scaled, converged

    def choose_start(self, starts: int, seed: int) -> Array:
        """Return the best refined start: guess, best of the model's and `starts` random ones; a lone guess stays."""
        guess, of_model = self.residuals.guess, self.residuals.scaling.scale(self.model.starts())
        tried = np.vstack([guess, np.clip(of_model, 0.0, 1.0), self._draw_starts(starts, seed)])
        self.simulations += len(tried)
        self.report_progress(0.02, f"{len(tried)} starts")
        best = np.argsort(self.residuals.compute_costs(tried), kind="stable")[:REFINED_STARTS]
        if 0 not in best:
            best = np.concatenate([[0], best[: REFINED_STARTS - 1]])
        if len(tried) == 1:
            return np.asarray(guess)
        refined = [self.refine(tried[i], START_STEPS, f"start {k + 1} of {len(best)}")[0] for k, i in enumerate(best)]
        return refined[int(np.argmin(self.residuals.compute_costs(np.array(refined))))]

    def _draw_starts(self, starts: int, seed: int) -> Array:
        """Return starting points in the unit cube, (starts, unknowns): Sobol points, every second near the guess."""
        from scipy.stats import qmc  # noqa: PLC0415  # scipy.stats takes long to import

        n = len(self.model.unknowns)
        if starts == 0:
            return np.empty((0, n))
        drawn = qmc.Sobol(n, rng=np.random.default_rng(seed)).random(1 << (starts - 1).bit_length())[:starts]
        drawn[::2] = np.clip(self.residuals.guess + START_RADIUS * (2.0 * drawn[::2] - 1.0), 0.0, 1.0)
        return np.asarray(drawn)

    def compare_mirrored(self, scaled: Array, converged: bool) -> tuple[Array, bool]:
        """Replace values by those that mirror them, one pair after the other, where these predict better.

        Return the values and whether their search converged. The worse of two that logs can't tell apart is a rival.
        """
        for number in range(len(self.free.mirrored_values(self.free.guess))):
            cost = float(self.residuals.compute_costs(scaled[None])[0])
            values = self.residuals.scaling.unscale(scaled)
            mirrored = self.free.mirrored_values(values)[number]
            start = self.scale(mirrored)
            self.simulations += 1
            if not self.residuals.compute_costs(start[None])[0] < MAX_MIRROR_COST_RATIO * cost:
                continue
            other, other_converged = self.refine(start, REFINEMENT_STEPS, "mirrored values")
            r, others = self.residuals.compute_data(np.array([scaled, other]))
            worse = other
            if self.residuals.compute_costs(other[None])[0] < cost:
                scaled, converged, worse = other, other_converged, scaled
            if not are_distinguishable(r, others, assign_blocks(self.model, r)):
                self.rivals.append((np.flatnonzero(mirrored != values), self.residuals.scaling.unscale(worse)))
            self.update_scales(scaled)
        return scaled, converged

    def basin_hop(self, scaled: Array, converged: bool, seed: int) -> tuple[Array, bool]:
        """Leave small local minima: refine the best of random points along the principal axes, while the cost falls.

        Args:
            scaled: scaled unknowns where the search ended, (unknowns,).
            converged: whether it converged there.
            seed: seed of the random points.

        Returns:
            Scaled values, and whether the search converged there.
        """
        random, best = np.random.default_rng(seed), float(self.residuals.compute_costs(scaled[None])[0])
        for _ in range(MAX_BASIN_HOPS):
            strengths = np.maximum(self.residuals.strengths, 1.0)
            sizes = np.repeat(HOP_SIZES, RANDOM_STARTS // len(HOP_SIZES))[:, None] / strengths
            moves = sizes * random.standard_normal(sizes.shape) @ self.residuals.axes
            tried = np.clip(scaled + moves, 0.0, 1.0)
            self.simulations += len(tried)
            start = tried[int(np.argmin(self.residuals.compute_costs(tried)))]
            refined, refined_converged = self.refine(start, REFINEMENT_STEPS, "basin hopping")
            cost = float(self.residuals.compute_costs(refined[None])[0])
            if cost > best - max(1.0, MIN_COST_DECREASE * best):
                break
            scaled, converged, best = refined, refined_converged, cost
            self.update_scales(scaled)
            best = float(self.residuals.compute_costs(scaled[None])[0])
        return scaled, converged

    def refine(
        self, start: Array, steps: int, text: str, loss: Literal["linear", "soft_l1"] = "linear"
    ) -> tuple[Array, bool]:
        """Minimise the residuals by least squares from a start, and keep the point of least cost in `best`.

        Args:
            start: scaled values, (unknowns,).
            steps: greatest number of evaluations.
            text: task, for the progress.
            loss: loss function of SciPy's `least_squares`.

        Returns:
            Scaled values, and whether the search converged within the steps.
        """
        from scipy.optimize import least_squares  # noqa: PLC0415  # scipy.optimize takes long to import

        def residuals(scaled: Array) -> Array:
            self.simulations += 1
            self.report_progress(self.done + 0.03 * (0.95 - self.done), text)
            r = self.residuals(scaled)
            cost = float(r @ r)
            if cost < self.min_cost:
                self.best, self.min_cost = scaled.copy(), cost
            return r

        def jacobian(scaled: Array) -> Array:
            self.simulations += 2 * len(scaled)
            return self.residuals.compute_jacobian(scaled)

        limits: dict[str, Any] = {"ftol": self.tolerance, "xtol": 1e-8, "gtol": 1e-8, "max_nfev": steps}
        limits |= {"loss": loss, "f_scale": OUTLIER_RESIDUAL}
        inside = np.clip(start, 1e-6, 1.0 - 1e-6)
        result = least_squares(residuals, inside, jacobian, bounds=(0.0, 1.0), **limits)
        return np.asarray(result.x), bool(result.status > 0)

    def update_scales(self, scaled: Array) -> None:
        """Scale each fitted output by its rms error, but not below its own scale; `scaled` becomes the best point."""
        simulated = self.model.simulate(self.residuals.scaling.unscale(scaled[None]))[0]
        for i, (rows, output) in enumerate(zip(self.model.slices, self.model.outputs, strict=True)):
            chosen = self.model.used[rows]
            if chosen.any():
                rms = float(np.sqrt(np.mean((simulated[rows][chosen] - output.measured[chosen]) ** 2)))
                self.residuals.scales[i] = max(output.scale, rms) if np.isfinite(rms) else output.scale
        self.best, self.min_cost = scaled, np.inf

    def build_result(self, scaled: Array, converged: bool, seed: int, *, partial: bool = False) -> Fit:
        """Return estimates with their intervals, and their predictions by the free model, or by one with feedback.

        Args:
            scaled: scaled unknowns where the search ended, (unknowns,).
            converged: whether it converged there.
            seed: seed of the bootstrap.
            partial: whether the user stopped the search; the intervals are then coarse.
        """
        scaling, model, passes = self.residuals.scaling, self.model, 1 if partial else JACOBIAN_PASSES
        optimum = np.clip(scaling.scale(scaling.unscale(scaled)), 0.0, 1.0)
        for number in range(passes):
            J = self.residuals.compute_data_jacobian(optimum)
            if number == passes // 2:  # by a Jacobian whose axes are aligned
                optimum = model.project(optimum, self.residuals.triangle)
        r = self.residuals.compute_data(optimum[None])[0]
        self.simulations += 2 * passes * len(optimum) + 2
        # Information and priors are those of the search's coordinates: only then are they mapped to the unknowns.
        values, (plain, slopes) = scaling.unscale(optimum), scaling.to_plain(optimum)
        variances = slopes @ covariance(J, r, self.residuals.widths) @ slopes.T
        moves = bootstrap_moves(J, r, self.residuals.widths, assign_blocks(model, r), seed) @ slopes.T
        low, high = confidence_interval(plain, variances, moves)
        for which, others in self.rivals:
            distance = (scaling.plain.scale(others) - plain)[which]
            low[which] += np.minimum(distance, 0.0)
            high[which] += np.maximum(distance, 0.0)
        at_bounds = [
            (x < BOUND_MARGIN and not unknown.floor) or (x > 1.0 - BOUND_MARGIN and not unknown.ceiling)
            for x, unknown in zip(optimum.tolist(), model.unknowns, strict=True)
        ]
        lower_ends, upper_ends = scaling.plain.unscale(low), scaling.plain.unscale(high)
        columns = values, lower_ends, upper_ends, at_bounds, _partners(model, variances)
        estimates = tuple(
            FittedParameter(unknown, float(value), float(lower), float(upper), at_bound, partner)
            for unknown, value, lower, upper, at_bound, partner in zip(model.unknowns, *columns, strict=True)
        )
        simulated = self.free.simulate(values[None])[0]
        result = Fit(self.free, estimates, simulated, converged, self.simulations, partial)
        tracking = self.free.tracking_model() if result.mispredicted is not None else None
        if tracking is None:
            return result
        return replace(result, tracking=tracking, simulated=tracking.simulate(values[None])[0])


def _partners(model: Model, variances: Array) -> list[str | None]:
    """Return by unknown the path of the most correlated one, if above `INSEPARABLE_CORRELATION`, else None."""
    deviations = np.sqrt(np.diag(variances))
    correlations = np.abs(variances / np.outer(deviations, deviations)) - 2.0 * np.eye(len(deviations))
    best = [int(np.argmax(row)) for row in correlations]
    return [
        model.unknowns[partner].path if correlations[i, partner] > INSEPARABLE_CORRELATION else None
        for i, partner in enumerate(best)
    ]
