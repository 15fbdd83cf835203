"""Where to look at an arm from."""

from collections.abc import Sequence
from math import atan, pi, tan
from typing import NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.bridge.pieces import Piece

FIELD = 30.0  # of view, vertical, deg
ASIDE, ABOVE = 0.5, 0.35  # rad: where one stands, from the side of the arm towards its tip, and over it
MARGIN = 1.12  # of a picture around the arm
UNKNOWN = 0.5  # size of a mesh, of which only the place counts, m


class Viewpoint(NamedTuple):
    """Where one stands, and what is seen from there."""

    place: Array  # m, (3,)
    right: Array  # directions in the picture, of length 1, (3,)
    up: Array
    centre: Array  # of what is seen, m, (3,)
    radius: float  # of a ball around it, m


def viewpoint(pieces: Sequence[Piece], floor: float, aspect: float) -> Viewpoint:
    """Return from where all pieces are seen, from aside and from above.

    Args:
        pieces: in the room, from base to tip.
        floor: height below which nothing is of interest, m.
        aspect: width of the picture over its height.
    """
    centre, radius = _ball(pieces, floor)
    spread = np.array([piece.place[:2] for piece in pieces])
    _, _, ways = np.linalg.svd(spread - spread.mean(axis=0), full_matrices=True)
    lead = ways[0] if ways[0] @ (spread[-1] - spread[0]) >= 0.0 else -ways[0]
    heading = float(np.arctan2(lead[1], lead[0])) - 0.5 * pi + ASIDE
    back = np.array([np.cos(heading) * np.cos(ABOVE), np.sin(heading) * np.cos(ABOVE), np.sin(ABOVE)])
    right = np.array([-np.sin(heading), np.cos(heading), 0.0])
    half = np.radians(FIELD) / 2
    distance = MARGIN * radius / np.sin(min(half, atan(tan(half) * aspect)))
    return Viewpoint(centre + distance * back, right, np.cross(back, right), centre, radius)


def _ball(pieces: Sequence[Piece], floor: float) -> tuple[Array, float]:
    """Return middle and radius of a ball around all pieces, as far as they are above the floor."""
    reaches = np.array([0.5 * float(np.linalg.norm(piece.size or (UNKNOWN,))) for piece in pieces])
    places = np.array([piece.place for piece in pieces])
    low, high = (places - reaches[:, None]).min(axis=0), (places + reaches[:, None]).max(axis=0)
    low[2] = max(low[2], floor)
    centre = 0.5 * (low + high)
    return centre, float(np.max(np.linalg.norm(places - centre, axis=1) + reaches))
