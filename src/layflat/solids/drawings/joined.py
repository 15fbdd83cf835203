"""Sheets of parts in one piece of several shapes, such as tubes with flattened ends: three views, sizes, holes; mm."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from layflat.lazy import numpy as np
from layflat.solids.drawings.contours import as_circle
from layflat.solids.drawings.plan import draw_origin
from layflat.solids.drawings.projection import FRONT_VIEW, LEFT_VIEW, TOP_VIEW, Projection, project
from layflat.solids.drawings.table import number_text
from layflat.solids.drawings.turned import FIRST_OFFSET, faces
from layflat.solids.shapes import Drilled, Prism, Turned, place

if TYPE_CHECKING:
    from layflat.solids.component import Component
    from layflat.solids.drawings.views import View
    from layflat.solids.shapes import Joined, PartPlace


VIEW_AXES = (("front", FRONT_VIEW), ("left", LEFT_VIEW), ("seen from above", TOP_VIEW))
"""Name and directions of each view."""


class JoinedViews(NamedTuple):
    """Views of a part from the front, the left and above, in the frame of its first piece, and its holes."""

    projections: tuple[Projection, ...]
    holes: tuple[Drilled, ...]


def joined_views(component: Component, shape: Joined) -> JoinedViews:
    """Return the views and holes of a part in one piece."""
    (_, frame), *_ = shape.placed()
    one = component.put_at((place(),))
    projections = tuple(project(title, [one], [""], view, frame) for title, view in VIEW_AXES)
    return JoinedViews(projections, tuple(_holes(shape, frame)))


def _holes(shape: Joined, frame: PartPlace) -> list[Drilled]:
    """Return the holes of all pieces in a frame, each from its face inwards."""
    found = []
    for piece, at in shape.placed():
        axes, origin = frame.axes.T @ at.axes, frame.axes.T @ (at.origin - frame.origin)
        own = list(piece.drilled)
        if isinstance(piece, Prism):
            own += [
                Drilled((*hole.centre, piece.height), (0.0, 0.0, -1.0), hole.diameter, piece.height, hole.thread)
                for hole in piece.holes
            ]
        for hole in own:
            start, along = origin + axes @ np.array(hole.start), axes @ np.array(hole.direction)
            found.append(hole._replace(start=_vector(start), direction=_vector(along)))
    return found


def _vector(values: np.ndarray) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in values)
    return x, y, z


def draw_joined(view: View, views: JoinedViews, number: int) -> None:
    """Draw a view of a part in one piece with numbers of the holes that are seen from there, and its sizes.

    Args:
        view: where.
        views: of the part.
        number: of the view, from 0 on.
    """
    projection = views.projections[number]
    for shadow in projection.shadows:
        lines = [view.paper_points(line) for line in shadow.lines]
        view.paper.area(lines, "outline", "white")
        for line in lines:
            view.labels.avoid(np.vstack((line, line[:1])))
    (x, y), (x_2, y_2) = projection.box
    if number < 2:  # the view from above has the width of that from the front
        view.distance((x, y), (x_2, y), -FIRST_OFFSET, number_text(float(x_2 - x), 1))
    else:
        left, low = view.paper_points((x, y))
        view.paper.text(float(left), float(low) - FIRST_OFFSET, projection.title)
    if number == 0:
        view.distance((x, y), (x, y_2), -FIRST_OFFSET, number_text(float(y_2 - y), 1), upright=True)
        draw_origin(view)
    for k, hole in enumerate(views.holes, 1):
        along = [abs(float(axes[2] @ np.array(hole.direction))) for _, axes in VIEW_AXES]
        if along.index(max(along)) == number:
            at = VIEW_AXES[number][1][:2] @ np.array(hole.start)
            view.cross(at, hole.diameter / 2)
            view.labels.place(view.paper_points(at), view.scale * hole.diameter / 2, str(k))


def piece_note(shape: Joined) -> str:
    """Return the sizes of the pieces of a part."""
    return f"Pieces: {'; '.join(_piece_size(piece) for piece, _ in shape.placed())}."


def _piece_size(piece: Prism | Turned) -> str:
    if isinstance(piece, Turned):
        length = max(face.high for face in faces(piece)) - min(face.low for face in faces(piece))
        sizes = " / ".join(f"Ø{number_text(2 * face.radius, 1)}" for face in faces(piece))
        return f"{sizes} x {number_text(length, 1)}"
    ring = as_circle(piece.outline)
    if ring is not None:
        return f"Ø{number_text(2 * ring.radius, 1)} x {number_text(piece.height, 1)}"
    width, height = (number_text(float(size), 1) for size in np.ptp(piece.outline.points(), axis=0))
    return f"{width} x {height} x {number_text(piece.height, 1)}"
