"""Links in coordinates in which torques are linear: mass, mass times centre, and inertia about the joint.

The motion of an arm identifies only sums of these (an1985). Directions that it does not identify are straight lines in
these coordinates, but curves in masses, centres and inertias about centres, where a search takes small steps. Feasible
bodies have second moments of mass that are nowhere negative, along any of three perpendicular directions.

| symbol | meaning |
|---|---|
| m, c | mass, and centre of mass in the link's frame, whose origin is on the joint's axis |
| I | inertia, xx, yy, zz, xy, xz, yz, (..., 6): about the centre, or the origin |
| S | second moments of mass about the centre, (..., 3, 3): tr(I) / 2 - I |
"""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.identify.model import SLOPE_STEP, Flags, Scaling, Unknown
from layflat.machine import Machine
from layflat.physics.arms.chain.description import LinkPart, six_moments

MIN_THICKNESS, MIN_THIN_THICKNESS = 1e-3, 1e-7  # least eigenvalue of S over the greatest: usual, and of a thin body
MIN_SIZE_RATIO = 1e-2  # greatest eigenvalue of a body's S over the described one, at least
MAX_PROJECTIONS = 30  # iterations that look for a feasible inertia which keeps the sought items


def moments_from_inertia(inertia: Array) -> Array:
    """Return the second moments of mass S = tr(I)/2 E - I, (..., 3, 3), kg m2, of inertias I (..., 6)."""
    xx, yy, zz, xy, xz, yz = np.moveaxis(inertia, -1, 0)
    tensor = np.stack([xx, xy, xz, xy, yy, yz, xz, yz, zz], axis=-1).reshape(*xx.shape, 3, 3)
    return np.asarray(0.5 * np.trace(tensor, axis1=-2, axis2=-1)[..., None, None] * np.eye(3) - tensor)


def inertia_from_moments(moments: Array) -> Array:
    """Return the inertias I, (..., 6), kg m2, of second moments of mass S (..., 3, 3): I = tr(S) E - S."""
    tensor = np.trace(moments, axis1=-2, axis2=-1)[..., None, None] * np.eye(3) - moments
    return np.stack([tensor[..., i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))], axis=-1)


def is_thin(inertia: Array) -> bool:
    """Return whether a described body is so thin along a direction that its estimates may be as well."""
    moments = np.linalg.eigvalsh(moments_from_inertia(inertia))
    return bool(moments[0] < MIN_THICKNESS * moments[-1])


def feasible_columns(machine: Machine, columns: Mapping[str, Array]) -> dict[str, Array]:
    """Return values of candidates by path, with feasible inertias in place of infeasible ones.

    A second moment of a body's mass along a principal direction that is negative or too small is raised to a small
    positive one. Items of an inertia that are no unknowns change first, and are then among the values. An arm without
    `own_links` stays.

    Args:
        machine: machine as described.
        columns: values of the unknowns by path, (candidates,) each.
    """
    feasible = dict(columns)
    for name in machine.arm.joints if machine.arm.own_links else ():
        described = machine.arm.link[name].inertia
        paths = [f"arm.link.{name}.inertia.{i}" for i in range(len(described))]
        sought = np.array([path in columns for path in paths] + [False] * (6 - len(paths)))
        if sought.any():
            items = [columns.get(path, value) for path, value in zip(paths, described, strict=True)]
            inertia = np.stack(np.broadcast_arrays(*six_moments(tuple(items))), axis=-1)
            nearest = _nearest_feasible(inertia, sought, np.array(six_moments(described)))
            changed = np.any(nearest != inertia, axis=0)
            feasible |= {path: nearest[:, i] for i, path in enumerate(paths) if sought[i] or changed[i]}
    return feasible


def _nearest_feasible(inertia: Array, sought: Flags, described: Array) -> Array:
    """Return feasible inertias near infeasible ones, (candidates, 6): xx, yy, zz, xy, xz, yz, kg m2.

    The `sought` items keep their values, and the others change; if that gives no feasible body within
    `MAX_PROJECTIONS` projections, or all are sought, all change. Feasible candidates stay as they are.

    The limit of the least second moment of mass is `MIN_THICKNESS` of the greatest, or the least one of the described
    body if that is thinner; one below is raised to twice the limit.

    Args:
        inertia: present values, (candidates, 6).
        sought: mask of the items that are unknowns, (6,).
        described: inertia of the description, (6,).
    """
    described_moments = np.linalg.eigvalsh(moments_from_inertia(described))
    result, iterations = inertia, 1 if sought.all() else MAX_PROJECTIONS
    for iteration in range(iterations):
        values, vectors = np.linalg.eigh(moments_from_inertia(result))
        upper = np.maximum(values[:, -1], MIN_SIZE_RATIO * described_moments[-1])
        lower = np.minimum(MIN_THICKNESS * upper, np.maximum(described_moments[0], MIN_THIN_THICKNESS * upper))
        infeasible = values[:, :1] < lower[:, None]
        if not infeasible.any():
            break
        moments = (vectors * np.maximum(values, 2.0 * lower[:, None])[:, None, :]) @ vectors.swapaxes(1, 2)
        nearest = inertia_from_moments(moments)
        restored = inertia if iteration < iterations - 1 else nearest
        result = np.where(infeasible, np.where(sought, restored, nearest), result)
    return result


LINK_PARAMETERS = ("mass", *(f"centre.{i}" for i in range(3)), *(f"inertia.{i}" for i in range(6)))
CENTRE_SLICE, INERTIA_SLICE, DIAGONAL_SLICE = slice(1, 4), slice(4, 10), slice(4, 7)
TRIANGLE_INDICES = (0, 1, 2, 1, 2, 2), (0, 1, 2, 0, 0, 1)  # of a lower triangle, in the order of an inertia
STRENGTH_PATHS = (
    "valve.conductance", "valve.leakage", "hose.torque_factor", "hose.dead_volume", "hose.compliance",
    "hose.wall_conductance", "brake.torque", "brake.viscous",
)  # fmt: skip
"""Parameters that grow with the strength and mass of an arm as a whole, and change nothing if all of them do.

Links are searched linearly: with these on a logarithmic scale this direction would be curved, and curvature looks like
information.
"""

ROUNDING_RATIO = 1e-12  # second moments over the greatest one that are positive in spite of rounding
THICKNESS_MARGIN = 1e-6  # relative, by which a body is thicker than it must be
MAX_SEARCH_STEPS = 1000  # of the search for the nearest feasible bodies
MAX_MOMENT_RATIO = 1e6  # of moments in that search over the described ones, either way
MAX_ADDED_MASS_RATIO = 2.0  # over the described mass: how far moments that are proportional to mass are searched


class LinkBody(NamedTuple):
    """Link of which some parameters are sought."""

    places: NDArray[np.int64]  # of the sought `LINK_PARAMETERS` among the unknowns
    sought: Flags  # flags of these among `LINK_PARAMETERS`
    described: Array  # all `LINK_PARAMETERS`, SI
    whole_inertia: bool  # whether all items of the inertia that the description has are sought
    thickness: float  # least eigenvalue of S over the greatest, at least

    @classmethod
    def from_link(cls, path: str, link: LinkPart, places: dict[str, int]) -> "LinkBody":
        """Return the sought parameters of a link.

        Args:
            path: path of the link in the description.
            link: link as described.
            places: positions among the unknowns, by path.
        """
        positions = [places.get(f"{path}.{name}", -1) for name in LINK_PARAMETERS]
        described = np.array([link.mass, *link.centre, *six_moments(link.inertia)], dtype=np.float64)
        sought, count = np.array(positions) >= 0, len(link.inertia)
        thickness = 0.0 if is_thin(described[INERTIA_SLICE]) else MIN_THICKNESS * (1.0 + THICKNESS_MARGIN)
        whole_inertia = bool(sought[INERTIA_SLICE][:count].all())
        return cls(np.array(positions)[sought], sought, described, whole_inertia, thickness)

    def all_parameters(self, values: Array) -> Array:
        """Return all parameters of the body, (..., 10), from the unknowns' values; those not sought as described."""
        body = np.broadcast_to(self.described, (*values.shape[:-1], len(LINK_PARAMETERS))).copy()
        body[..., self.sought] = values[..., self.places]
        return body

    def to_joint_axis(self, values: Array) -> Array:
        """Return the sought ones of m, m c and I about the joint, (..., sought), from the unknowns' values, SI."""
        body = self.all_parameters(values)
        m, c = body[..., 0], body[..., CENTRE_SLICE].copy()
        body[..., CENTRE_SLICE] = m[..., None] * c
        body[..., INERTIA_SLICE] += _parallel_axis_term(m, c)
        return np.asarray(body[..., self.sought])

    def to_centre(self, values: Array) -> Array:
        """Return the sought ones of m, c and I about the centre, (..., sought): inverse of `to_joint_axis`.

        Among the values, those of this body are m, m c and I about the joint.
        """
        body = self.all_parameters(values)
        m, moved = body[..., 0], self.sought[CENTRE_SLICE]
        body[..., CENTRE_SLICE] = np.where(moved, body[..., CENTRE_SLICE] / m[..., None], body[..., CENTRE_SLICE])
        body[..., INERTIA_SLICE] -= _parallel_axis_term(m, body[..., CENTRE_SLICE])
        return np.asarray(body[..., self.sought])

    def to_free(self, values: Array) -> Array:
        """Return coordinates all of whose values are feasible bodies: log m, c, and a Cholesky factor of S.

        Where not all of I is sought, the other items adapt: then positive moments of inertia suffice.
        """
        body = self.all_parameters(values)
        body[0] = np.log(body[0])
        if not self.whole_inertia:
            body[DIAGONAL_SLICE] = np.log(body[DIAGONAL_SLICE])
        else:
            sizes, vectors = np.linalg.eigh(moments_from_inertia(body[INERTIA_SLICE]))
            above = np.maximum(sizes - self.thickness * sizes[-1], ROUNDING_RATIO * sizes[-1])
            body[INERTIA_SLICE] = np.linalg.cholesky((vectors * above) @ vectors.T)[TRIANGLE_INDICES]
        return np.asarray(body[self.sought])

    def from_free(self, free: Array) -> Array:
        """Return the sought ones of m, c and I about the centre: inverse of `to_free`."""
        body, factor = self.described.copy(), np.zeros((3, 3))
        body[self.sought] = free
        body[0] = np.exp(body[0])
        if not self.whole_inertia:
            body[DIAGONAL_SLICE] = np.exp(body[DIAGONAL_SLICE])
        else:
            factor[TRIANGLE_INDICES] = body[INERTIA_SLICE]
            above = factor @ factor.T
            lower = self.thickness / (1.0 - self.thickness) * np.linalg.eigvalsh(above)[-1]
            body[INERTIA_SLICE] = inertia_from_moments(above + lower * np.eye(3))
        return np.asarray(body[self.sought])

    def free_bounds(self, low: Array, high: Array) -> Array:
        """Return the bounds of the free coordinates, (2, sought), infinite but for mass and single moments of inertia.

        The mass has the bounds of its unknown; moments, where not all of I is sought, the described ones times and over
        `MAX_MOMENT_RATIO`.

        Args:
            low: lower bounds of all unknowns, SI.
            high: upper ones.
        """
        bounds = np.repeat([[-np.inf], [np.inf]], len(LINK_PARAMETERS), axis=1)
        bounds[:, 0] = [np.log(self.all_parameters(bound)[0]) for bound in (low, high)]
        if not self.whole_inertia:
            logs = np.log(self.described[DIAGONAL_SLICE])
            bounds[:, DIAGONAL_SLICE] = logs + np.log(MAX_MOMENT_RATIO) * np.array([[-1.0], [1.0]])
        return bounds[:, self.sought]

    def half_ranges(self, high: Array) -> Array:
        """Return half the range in which m c and I about the joint are searched, (sought,); zero for m.

        Args:
            high: upper bounds of the unknowns.
        """
        m, c = self.described[0], self.described[CENTRE_SLICE]
        size = np.max(self.all_parameters(high)[CENTRE_SLICE] - c)
        inertia = np.max((self.described[INERTIA_SLICE] + _parallel_axis_term(m, c))[:3])
        halves = [0.0, MAX_ADDED_MASS_RATIO * m * size, MAX_ADDED_MASS_RATIO * inertia + m * size**2]
        return np.repeat(halves, [1, 3, 6])[self.sought]


def _parallel_axis_term(m: Array, c: Array) -> Array:
    """Return inertia about the origin less that about the centre, (..., 6), by the parallel axis theorem."""
    x, y, z = np.moveaxis(c, -1, 0)
    items = (y * y + z * z, x * x + z * z, x * x + y * y, -x * y, -x * z, -y * z)
    return np.stack([m * item for item in items], axis=-1)


class BodyScaling(Scaling):
    """Scaling of the unknowns, of links by parameters in which torques are linear."""

    def __init__(self, machine: Machine, unknowns: Sequence[Unknown]) -> None:
        super().__init__(unknowns)
        self.plain = Scaling(unknowns)
        self.log &= [not unknown.path.endswith(STRENGTH_PATHS) for unknown in unknowns]
        places = {unknown.path: number for number, unknown in enumerate(unknowns)}
        links = machine.arm.link.items() if machine.arm.own_links else ()
        bodies = [LinkBody.from_link(f"arm.link.{name}", link, places) for name, link in links]
        self.bodies = [body for body in bodies if body.sought.any()]
        middle = self._convert(np.array([unknown.guess for unknown in unknowns]), LinkBody.to_joint_axis)
        for body in self.bodies:
            half, centre = body.half_ranges(self.plain.high), middle[body.places]
            self.low[body.places] = np.where(half > 0.0, centre - half, self.plain.low[body.places])
            self.high[body.places] = np.where(half > 0.0, centre + half, self.plain.high[body.places])

    def scale(self, values: Array) -> Array:
        """Return values scaled to 0..1, (..., unknowns)."""
        return super().scale(self._convert(values, LinkBody.to_joint_axis))

    def unscale(self, scaled: Array) -> Array:
        """Return the values (SI) of scaled ones, (..., unknowns)."""
        return self._convert(super().unscale(scaled), LinkBody.to_centre)

    def project(self, scaled: Array, start: Array, triangle: Array) -> Array:
        """Return the nearest scaled values whose links are feasible; all others move within their bounds.

        Args:
            scaled: scaled unknowns to be projected, (unknowns,).
            start: near them, with feasible links; the search starts there, and ends after `MAX_SEARCH_STEPS` at most.
            triangle: weights of the distance: its norm is that of `triangle` times the change.

        Returns:
            Scaled values (unknowns,); feasible also where the search has ended early.
        """
        from scipy.optimize import least_squares  # noqa: PLC0415  # scipy.optimize takes long to import

        links = np.concatenate([body.places for body in self.bodies])
        others = np.setdiff1d(np.arange(len(scaled)), links)
        ends = np.cumsum([len(others), *(len(body.places) for body in self.bodies)])[:-1]

        def to_scaled(free: Array) -> Array:
            """Return all scaled unknowns from free coordinates: those of the others, then body by body."""
            first, *parts = np.split(free, ends)
            point = np.empty(len(scaled))
            point[others] = first
            for body, part in zip(self.bodies, parts, strict=True):
                point[body.places] = self._scale_free(body, part)
            return point

        def residuals(free: Array) -> Array:
            return np.asarray(triangle @ (to_scaled(free) - scaled))

        def jacobian(free: Array) -> Array:
            """Return the derivatives of the residuals by the free coordinates, of bodies by central differences."""
            first, *parts = np.split(free, ends)
            slopes = np.zeros((len(scaled), len(free)))
            slopes[others, : len(first)] = np.eye(len(first))
            for body, part, column in zip(self.bodies, parts, ends, strict=True):
                steps = np.diag(SLOPE_STEP * np.maximum(np.abs(part), SLOPE_STEP))
                for i, step in enumerate(steps):
                    change = self._scale_free(body, part + step) - self._scale_free(body, part - step)
                    slopes[body.places, column + i] = change / (2.0 * step[i])
            return np.asarray(triangle @ slopes)

        free = np.concatenate([start[others], *(body.to_free(self.unscale(start)) for body in self.bodies)])
        unit = np.repeat([[0.0], [1.0]], len(others), axis=1)
        low, high = np.hstack([unit, *(body.free_bounds(self.plain.low, self.plain.high) for body in self.bodies)])
        clipped, limits = np.clip(free, low, high), (low, high)
        result = least_squares(residuals, clipped, jacobian, bounds=limits, x_scale="jac", max_nfev=MAX_SEARCH_STEPS)
        return to_scaled(np.asarray(result.x))

    def _scale_free(self, body: LinkBody, free: Array) -> Array:
        """Return the scaled values of a body from its free coordinates."""
        values, low, high = np.zeros(len(self.low)), self.low[body.places], self.high[body.places]
        values[body.places] = body.from_free(free)
        return np.asarray((body.to_joint_axis(values) - low) / (high - low))

    def _convert(self, values: Array, conversion: Callable[[LinkBody, Array], Array]) -> Array:
        """Return a copy of the values in which each body's are replaced by the result of a conversion."""
        converted = np.array(values)
        for body in self.bodies:
            converted[..., body.places] = conversion(body, values)
        return converted
