"""Links as torques see them: mass, mass times centre, and inertia about the joint, of which torques are linear.

Motion tells of an arm's links no more than sums of these (an1985). What it does not tell lies along straight lines
there, which are bent in masses, centres and inertias about centres; a search that follows bends takes small steps.

| symbol | meaning |
|---|---|
| m, c | mass, and centre of mass in the link's frame, whose origin is on the joint's axis |
| I | inertia, xx, yy, zz, xy, xz, yz: about the centre, or the origin |
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.identify.benches.moving.spread import THICK, inertia_of, is_thin, spread_of
from layflat.identify.model import Flags
from layflat.identify.unknown import NEAR, Shares, Unknown
from layflat.machine import Machine
from layflat.physics.arms.chain.description import LinkPart, six_moments

NAMES = ("mass", *(f"centre.{i}" for i in range(3)), *(f"inertia.{i}" for i in range(6)))
CENTRE, INERTIA, MOMENTS = slice(1, 4), slice(4, 10), slice(4, 7)
ROOT = (0, 1, 2, 1, 2, 2), (0, 1, 2, 0, 0, 1)  # where in a lower triangle, in the order of an inertia
STRENGTHS = (
    "valve.conductance", "valve.leakage", "hose.torque_factor", "hose.dead_volume", "hose.compliance",
    "hose.wall_conductance", "brake.torque", "brake.viscous",
)  # fmt: skip
"""What grows with how strong and heavy an arm is as a whole, and changes nothing as long as all of it does.

Links are searched linearly: where these were by logarithms, that way would be bent, and bends pass for knowledge.
"""

ROUNDING, MARGIN = 1e-12, 1e-6  # what is positive in spite of rounding; by how much a body is thicker than it must be
LONG = 1000  # steps in which the nearest bodies are looked for
WIDE = 1e6  # factor by which moments may then differ from what is described
HEAVIER = 2.0  # how far beyond the described mass, as a share of it, what goes with mass is searched


class Body(NamedTuple):
    """A link of which something is sought."""

    places: NDArray[np.int64]  # of `NAMES` that are sought, among the unknowns
    sought: Flags  # which of `NAMES` these are
    described: Array  # all of them as described
    spreads: bool  # whether all of the inertia is sought that the description has
    thick: float  # least spread along a direction over the greatest

    @classmethod
    def of(cls, path: str, link: LinkPart, places: dict[str, int]) -> "Body":
        """Return what is sought of a link, from where each path stands among the unknowns."""
        found = [places.get(f"{path}.{name}", -1) for name in NAMES]
        described = np.array([link.mass, *link.centre, *six_moments(link.inertia)], dtype=np.float64)
        sought, given = np.array(found) >= 0, len(link.inertia)
        thick = 0.0 if is_thin(described[INERTIA]) else THICK * (1.0 + MARGIN)
        return cls(np.array(found)[sought], sought, described, bool(sought[INERTIA][:given].all()), thick)

    def filled(self, values: Array) -> Array:
        """All of a body, (..., 10), from values of the unknowns and, of what is not sought, as described."""
        found = np.broadcast_to(self.described, (*values.shape[:-1], len(NAMES))).copy()
        found[..., self.sought] = values[..., self.places]
        return found

    def about_joint(self, values: Array) -> Array:
        """m, m c and I about the joint, as far as they are sought, from values of the unknowns."""
        body = self.filled(values)
        m, c = body[..., 0], body[..., CENTRE].copy()
        body[..., CENTRE] = m[..., None] * c
        body[..., INERTIA] += _farther(m, c)
        return np.asarray(body[..., self.sought])

    def about_centre(self, values: Array) -> Array:
        """The other way."""
        body = self.filled(values)
        m, moved = body[..., 0], self.sought[CENTRE]
        body[..., CENTRE] = np.where(moved, body[..., CENTRE] / m[..., None], body[..., CENTRE])
        body[..., INERTIA] -= _farther(m, body[..., CENTRE])
        return np.asarray(body[..., self.sought])

    def roots(self, values: Array) -> Array:
        """Numbers that make a body whatever they are, as far as it is sought: log m, c, and a root of its spread.

        Where not all of I is sought, what is not gives way: then it is enough that moments are positive.
        """
        body = self.filled(values)
        body[0] = np.log(body[0])
        if not self.spreads:
            body[MOMENTS] = np.log(body[MOMENTS])
        else:
            sizes, ways = np.linalg.eigh(spread_of(body[INERTIA]))
            above = np.maximum(sizes - self.thick * sizes[-1], ROUNDING * sizes[-1])
            body[INERTIA] = np.linalg.cholesky((ways * above) @ ways.T)[ROOT]
        return np.asarray(body[self.sought])

    def rooted(self, roots: Array) -> Array:
        """The other way."""
        body, root = self.described.copy(), np.zeros((3, 3))
        body[self.sought] = roots
        body[0] = np.exp(body[0])
        if not self.spreads:
            body[MOMENTS] = np.exp(body[MOMENTS])
        else:
            root[ROOT] = body[INERTIA]
            above = root @ root.T
            least = self.thick / (1.0 - self.thick) * np.linalg.eigvalsh(above)[-1]
            body[INERTIA] = inertia_of(above + least * np.eye(3))
        return np.asarray(body[self.sought])

    def ends(self, low: Array, high: Array) -> Array:
        """Between which roots are looked for, (2, sought), from the ends of the unknowns' values."""
        found = np.repeat([[-np.inf], [np.inf]], len(NAMES), axis=1)
        found[:, 0] = [np.log(self.filled(end)[0]) for end in (low, high)]
        if not self.spreads:
            found[:, MOMENTS] = np.log(self.described[MOMENTS]) + np.log(WIDE) * np.array([[-1.0], [1.0]])
        return found[:, self.sought]

    def reach(self, high: Array) -> Array:
        """Return how far what is sought of m c and of I about the joint is searched, both ways; none of m."""
        m, c = self.described[0], self.described[CENTRE]
        size = np.max(self.filled(high)[CENTRE] - c)
        most = np.max((self.described[INERTIA] + _farther(m, c))[:3])
        return np.repeat([0.0, HEAVIER * m * size, HEAVIER * most + m * size**2], [1, 3, 6])[self.sought]


def _farther(m: Array, c: Array) -> Array:
    """Return what inertia about the origin is more than that about the centre, (..., 6) (parallel axes)."""
    x, y, z = np.moveaxis(c, -1, 0)
    return np.stack([m * one for one in (y * y + z * z, x * x + z * z, x * x + y * y, -x * y, -x * z, -y * z)], axis=-1)


class BodyShares(Shares):
    """Shares of the unknowns, of links those of what torques are linear in."""

    def __init__(self, machine: Machine, unknowns: Sequence[Unknown]) -> None:
        super().__init__(unknowns)
        self.own = Shares(unknowns)
        self.log &= [not unknown.path.endswith(STRENGTHS) for unknown in unknowns]
        places = {unknown.path: number for number, unknown in enumerate(unknowns)}
        links = machine.arm.link.items() if machine.arm.own_links else ()
        bodies = [Body.of(f"arm.link.{name}", link, places) for name, link in links]
        self.bodies = [body for body in bodies if body.sought.any()]
        middle = self._turned(np.array([unknown.guess for unknown in unknowns]), Body.about_joint)
        for body in self.bodies:
            reach, of = body.reach(self.own.high), middle[body.places]
            self.low[body.places] = np.where(reach > 0.0, of - reach, self.own.low[body.places])
            self.high[body.places] = np.where(reach > 0.0, of + reach, self.own.high[body.places])

    def of(self, values: Array) -> Array:
        """Shares of values, (..., unknowns)."""
        return super().of(self._turned(values, Body.about_joint))

    def values(self, shares: Array) -> Array:
        """Values of shares, (..., unknowns)."""
        return self._turned(super().values(shares), Body.about_centre)

    def nearest(self, shares: Array, near: Array, triangle: Array) -> Array:
        """Shares whose links are bodies, as `triangle` times what differs is least, from `near` on, where links are.

        All else gives way as far as its bounds let it.
        """
        from scipy.optimize import least_squares  # noqa: PLC0415  # scipy.optimize takes long to import

        links = np.concatenate([body.places for body in self.bodies])
        others = np.setdiff1d(np.arange(len(shares)), links)
        ends = np.cumsum([len(others), *(len(body.places) for body in self.bodies)])[:-1]

        def back(free: Array) -> Array:
            first, *roots = np.split(free, ends)
            found = np.empty(len(shares))
            found[others] = first
            for body, root in zip(self.bodies, roots, strict=True):
                found[body.places] = self._rooted(body, root)
            return found

        def missed(free: Array) -> Array:
            return np.asarray(triangle @ (back(free) - shares))

        def slopes(free: Array) -> Array:
            first, *roots = np.split(free, ends)
            ways = np.zeros((len(shares), len(free)))
            ways[others, : len(first)] = np.eye(len(first))
            for body, root, begin in zip(self.bodies, roots, ends, strict=True):
                away = np.diag(NEAR * np.maximum(np.abs(root), NEAR))
                for i, step in enumerate(away):
                    moved = self._rooted(body, root + step) - self._rooted(body, root - step)
                    ways[body.places, begin + i] = moved / (2.0 * step[i])
            return np.asarray(triangle @ ways)

        begun = np.concatenate([near[others], *(body.roots(self.values(near)) for body in self.bodies)])
        shared = np.repeat([[0.0], [1.0]], len(others), axis=1)
        low, high = np.hstack([shared, *(body.ends(self.own.low, self.own.high) for body in self.bodies)])
        found = least_squares(
            missed, np.clip(begun, low, high), slopes, bounds=(low, high), x_scale="jac", max_nfev=LONG
        )
        return back(np.asarray(found.x))

    def _rooted(self, body: Body, roots: Array) -> Array:
        """Shares of a body from its roots."""
        values, low, high = np.zeros(len(self.low)), self.low[body.places], self.high[body.places]
        values[body.places] = body.rooted(roots)
        return np.asarray((body.about_joint(values) - low) / (high - low))

    def _turned(self, values: Array, way: Callable[[Body, Array], Array]) -> Array:
        found = np.array(values)
        for body in self.bodies:
            found[..., body.places] = way(body, values)
        return found
