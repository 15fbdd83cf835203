"""Drawings of a designed joint: the cam to be cut, and the layout of cam, strap and cylinder."""

import re
from contextlib import ExitStack
from io import StringIO
from math import degrees, radians
from pathlib import Path

import numpy as np

from layflat import extras
from layflat.arrays import Array
from layflat.design.cam import Cam, Outline
from layflat.design.sheet import Circle, Diameter, Distance, Layer, Note, Sheet, dxf_text, svg_text
from layflat.design.sheet import Polyline as Line
from layflat.design.straplines import (
    CLAMP_ANGLE,
    RollerLine,
    ShellLine,
    direction_vector,
    joint_strap_line,
    rotate_quarter,
)
from layflat.design.summary import JointDesign
from layflat.errors import DesignError
from layflat.files import whole_file

MM = 1e3
LARGEST_TEXT = 3.5
TEXTS_ACROSS = 18.0  # text height of a drawing: the part's size over this, at most LARGEST_TEXT mm
BORE_DIRECTION = 245.0  # direction of the bore's dimension, deg: the side without profile
CYLINDER_DIRECTION = -35.0  # direction of the cylinder's dimension, deg: the side without shell


def write_drawings(design: JointDesign, folder: Path) -> list[Path]:
    """Write a joint's cam as DXF, SVG and CSV, and its layout as SVG, all of them or none, and return the files.

    Without ezdxf, which the extra `drawing` brings, there is no DXF. Raise DesignError if the joint has no cam that can
    be made, OutputError if the folder, which need not be there, can't be written.
    """
    cam, stem = cam_sheet(design), re.sub(r"[^\w.]+", "-", f"{design.machine.name}-{design.name}")
    columns, table = design.columns(), StringIO()
    np.savetxt(table, np.stack(list(columns.values()), axis=-1), "%.9g", ",", header=",".join(columns), comments="")
    contents = {
        "cam.dxf": dxf_text(cam) if extras.available("drawing") else "",
        "cam.svg": svg_text(cam),
        "cam.csv": table.getvalue(),
        "layout.svg": svg_text(layout_sheet(design)),
    }
    texts = {folder / f"{stem}-{name}": text for name, text in contents.items() if text}
    with ExitStack() as files:
        for path, text in texts.items():
            files.enter_context(whole_file(path)).write_text(text, encoding="utf-8", newline="\n")
    return list(texts)


def cam_sheet(design: JointDesign) -> Sheet:
    """Draw the cam in its own frame: outline, bore, strap at both ends, dimensions, notes; DesignError without one."""
    outline = _outline(design)
    points = outline.points * MM
    low, high = points.min(axis=0), points.max(axis=0)
    t = min(LARGEST_TEXT, float((high - low).max()) / TEXTS_ACROSS)
    sheet = Sheet(f"Cam of joint {design.name}, {design.machine.name}", t)
    sheet.paths.append(Line(points, "OUTLINE", closed=True))
    sheet.circles.append(Circle((0.0, 0.0), outline.bore / 2 * MM, "OUTLINE"))
    sheet.cross((0.0, 0.0), outline.hub / 2 * MM + t)
    _levers(sheet, outline.cam)
    ends = np.vstack([distance.ends for distance in sheet.distances])
    _overall(sheet, low, high, np.vstack((points, ends)))
    bore, lead = outline.bore * MM, float((points @ direction_vector(radians(BORE_DIRECTION))).max()) + 2 * t
    sheet.diameters.append(Diameter((0.0, 0.0), bore / 2, BORE_DIRECTION, f"⌀{bore:.4g}", lead))
    top = min(low[1], ends[:, 1].min()) - 11 * t
    for row, text in enumerate(_drawing_notes(design, outline)):
        sheet.notes.append(Note((float(low[0]) - 6 * t, float(top) - 1.6 * t * row), text, 1.25 if row == 0 else 1.0))
    return sheet


def layout_sheet(design: JointDesign) -> Sheet:
    """Draw cylinder, shell, strap and cam of the left hose at three angles of the output; DesignError without a cam."""
    outline, joint = _outline(design), design.joint
    cam = outline.cam
    R = joint.cylinder.diameter / 2 * MM
    t = min(LARGEST_TEXT, 2 * R / TEXTS_ACROSS)
    sheet = Sheet(f"Layout of joint {design.name}, {design.machine.name}", t)
    sheet.circles.append(Circle((0.0, 0.0), R, "HOSE"))
    sheet.cross((0.0, 0.0), 2 * t)
    axis = np.array(cam.axis) * MM
    sheet.circles.append(Circle(axis, outline.bore / 2 * MM, "OUTLINE"))
    sheet.cross(axis, outline.bore / 2 * MM + t)
    line = joint_strap_line(joint)
    if isinstance(line, RollerLine):
        centre = np.array(line.centre) * MM
        sheet.circles.append(Circle(centre, max(line.radius * MM, 0.5), "OUTLINE"))
    last = len(cam.angle) - 1
    for k in (0, last // 2, last):
        placed = _rotated(outline.points * MM, float(cam.angle[k])) + axis
        sheet.paths.append(Line(placed, "OUTLINE" if k == 0 else "CENTRE", closed=True))
        foot = _rotated(cam.profile[k : k + 1] * MM, float(cam.angle[k]))[0] + axis
        start = cam.strap_point[k] * MM
        sheet.line(start, foot, "STRAP")
        corner = placed[int(np.argmax(np.hypot(*(placed - axis).T)))] - axis
        beside = axis + corner * (1 + 1.5 * t / np.hypot(*corner)) - np.array([t, 0.0])
        if isinstance(line, ShellLine):
            arc = R * direction_vector(CLAMP_ANGLE - np.linspace(0.0, joint.hose.wrap, 61))
            shell = _rotated(arc - arc[0], float(cam.travel[k] / line.chord)) + arc[0]
            sheet.paths.append(Line(shell, "HOSE"))
            beside = start + 2.5 * t * rotate_quarter(direction_vector(cam.line_normal[k])) - np.array([t, 0.0])
        sheet.notes.append(Note(beside, f"{degrees(cam.angle[k]):.0f}°", 0.8))
    sheet.diameters.append(Diameter((0.0, 0.0), R, CYLINDER_DIRECTION, f"⌀{2 * R:.4g}", R + 3 * t))
    if joint.output.shaft_offset:
        base = (R + 4 * t, 0.0)
        sheet.distances.append(Distance((0.0, 0.0), axis, base, 90.0, f"{joint.output.shaft_offset * MM:.4g}"))
    _legend(sheet, design, (-R, min(-R, *(float(path.points[:, 1].min()) for path in sheet.paths)) - 6 * t))
    return sheet


def _legend(sheet: Sheet, design: JointDesign, at: tuple[float, float]) -> None:
    """Add title, legend of the line styles, and the sizes that no dimension shows."""
    t, (x, y), hose, line = sheet.text_height, at, design.joint.hose, joint_strap_line(design.joint)
    angle = design.with_cam().angle
    middle, end = (f"{degrees(angle[k]):.0f}°" for k in (len(angle) // 2, -1))
    lines: dict[Layer, str] = {
        "OUTLINE": "cam with the hose collapsed (0°)",
        "CENTRE": f"cam turned by {middle} and {end}",
        "STRAP": "strap at the same angles",
        "HOSE": "cylinder, and the shell at the same angles" if isinstance(line, ShellLine) else "cylinder",
    }
    sheet.notes.append(Note((x, y), sheet.title, 1.25))
    for row, (layer, text) in enumerate(lines.items(), start=1):
        sheet.line((x, y + (0.35 - 1.8 * row) * t), (x + 5 * t, y + (0.35 - 1.8 * row) * t), layer)
        sheet.notes.append(Note((x + 6 * t, y - 1.8 * row * t), text))
    width, wrap = f"{hose.width * MM:.4g}", f"{degrees(hose.wrap):.4g}°"
    text = f"hose {width} wide, wrapped {wrap}; dimensions in mm; the right hose is the mirror image of this one"
    sheet.notes.append(Note((x, y - 1.8 * (len(lines) + 1) * t), text))


def _outline(design: JointDesign) -> Outline:
    """Return the cam as a part; raise DesignError if the joint has none that can be made."""
    design.with_cam()
    if design.outline is None:
        raise DesignError("the cam can't be made", where=design.label, right="see its findings")
    return design.outline


def _levers(sheet: Sheet, cam: Cam) -> None:
    """Add the strap's line at both ends of the stroke, and dimensions of its lever arm (mm), to a sheet."""
    t = sheet.text_height
    for k, beyond in ((0, 1.0), (-1, -1.0)):
        eta, lever = float(cam.normal[k]), float(cam.lever[k]) * MM
        normal, tangent = direction_vector(eta), rotate_quarter(direction_vector(eta))
        touch = cam.profile[k] * MM
        end = touch + 8 * t * tangent
        sheet.line(touch, end, "STRAP")
        base = lever * normal + beyond * (abs(float((touch - lever * normal) @ tangent)) + 6 * t) * tangent
        sheet.distances.append(Distance((0.0, 0.0), lever * normal, base, degrees(eta), f"{lever:.3f}"))


def _overall(sheet: Sheet, low: Array, high: Array, taken: Array) -> None:
    """Add dimensions of width and height, from `low` to `high` (mm), outside the points `taken`."""
    t = sheet.text_height
    (x0, y0), (x1, y1) = (float(v) for v in low), (float(v) for v in high)
    below, beside = float(taken[:, 1].min()) - 4 * t, float(taken[:, 0].max()) + 5 * t
    sheet.distances.append(Distance((x0, y0), (x1, y0), (x0, below), 0.0, f"{x1 - x0:.2f}"))
    sheet.distances.append(Distance((x1, y0), (x1, y1), (beside, y0), 90.0, f"{y1 - y0:.2f}"))


def _drawing_notes(design: JointDesign, outline: Outline) -> list[str]:
    """Return the lines of text on the drawing of a cam: torque, lever arm, strap, dimensions."""
    strap, cam = design.joint.strap, outline.cam
    torque = cam.torque_constant * design.pressure
    return [
        f"Cam of joint {design.name}, {design.machine.name}",
        f"{torque:.4g} N m at {design.pressure / 1e5:.4g} bar over {degrees(cam.stroke):.4g}°; "
        "mirrored for the other hose",
        f"lever arm {cam.lever.min() * MM:.3f} to {cam.lever.max() * MM:.3f} mm, "
        f"radius of curvature from {cam.smallest_radius * MM:.3f} mm",
        f"strap {strap.material} {strap.width * MM:.4g} × {strap.thickness * MM:.4g} mm, layers: {strap.layers}; "
        "clamped on the flat",
        f"profile: {len(outline.profile)} points; dimensions in mm",
    ]


def _rotated(points: Array, angle: float) -> Array:
    """Return points (n, 2) rotated anticlockwise about the origin by an angle, rad."""
    along = direction_vector(angle)
    rotated: Array = points @ np.stack((along, rotate_quarter(along)))
    return rotated
