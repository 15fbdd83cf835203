"""The angle sensor above a joint: potentiometer, its plate on standoffs, and the coupling to the shaft."""

from __future__ import annotations

from math import cos, radians, sin
from typing import TYPE_CHECKING

from layflat.solids.component import Component, axes_towards
from layflat.solids.hardware import sleeve, socket_screw, stepped
from layflat.solids.loops import HullCircle, hull
from layflat.solids.shapes import UPSIDE_DOWN, Drilled, Hole, Prism, Turned, place, turn_about_z
from layflat.solids.sizes import MM
from layflat.solids.standard.fittings import ANGLE_SENSOR
from layflat.solids.standard.screws import screw_for
from layflat.solids.standard.threads import THREADS

if TYPE_CHECKING:
    from layflat.solids.sizes import JointSizes

STANDOFF_SCREW = THREADS["M3"]
STANDOFF_ANGLE = radians(150.0)  # from the arm at mid-stroke
STANDOFF_DIAMETER = 7.0  # diameter of a standoff, mm
PLATE_THICKNESS = 2.0  # thickness of the sensor's plate, mm
SHAFT_LENGTH = 8.0  # of the potentiometer, cut, mm
COUPLED_LENGTH = 6.0  # length of shaft in the coupling, mm
COUPLING_GAP = 1.0  # between coupling and end plate, mm
SHAFT_GAP = 0.5  # between both shafts in the coupling, mm
SET_SCREW = THREADS["M3"]


def _plate_height() -> float:
    """Return the height of the sensor's plate above the end plate, mm: its shaft reaches into the coupling."""
    return COUPLED_LENGTH + SHAFT_GAP + (SHAFT_LENGTH - PLATE_THICKNESS)


def standoff_places(sizes: JointSizes) -> list[tuple[float, float]]:
    """Return the places of the two standoffs beside the output's axis, mm."""
    widest = max(ANGLE_SENSOR.body_diameter * MM / 2, sizes.bush.flange * MM / 2, _coupling_radius(sizes))
    distance = widest + STANDOFF_DIAMETER
    return [(distance * sin(a), sizes.axis + distance * cos(a)) for a in (STANDOFF_ANGLE, -STANDOFF_ANGLE)]


def _coupling_radius(sizes: JointSizes) -> float:
    return max(sizes.shaft, ANGLE_SENSOR.shaft_diameter * MM) / 2 + 3.5


def standoff_components(sizes: JointSizes) -> list[Component]:
    """Return the standoffs of the sensor's plate, which are screwed on the upper end plate before the frame is shut."""
    height, places = _plate_height(), standoff_places(sizes)
    screw = screw_for(sizes.end_plate / MM, STANDOFF_SCREW.name, STANDOFF_SCREW.diameter)
    thread = Drilled((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), STANDOFF_SCREW.tapping_hole * MM, height, STANDOFF_SCREW.name)
    standoff = Turned(stepped((STANDOFF_DIAMETER / 2, 0.0, height)), (thread,))
    return [
        Component("standoff", "body", standoff, "aluminium", "turning",
                  tuple(place(x, y, sizes.top) for x, y in places), f"round bar {STANDOFF_DIAMETER:g}"),
        socket_screw("lower screw of a standoff", "body", screw,
                     tuple(place(x, y, sizes.half_length, UPSIDE_DOWN) for x, y in places)),
    ]  # fmt: skip


def sensor_components(sizes: JointSizes, angle: float) -> list[Component]:
    """Return the components of the angle sensor on its standoffs; angle of the output from mid-stroke, rad."""
    sensor, face, height = ANGLE_SENSOR, sizes.top, _plate_height()
    turned = turn_about_z(angle).then(place(0.0, sizes.axis))
    places = standoff_places(sizes)
    upper_screw = screw_for(PLATE_THICKNESS / MM, STANDOFF_SCREW.name, STANDOFF_SCREW.diameter)
    around = HullCircle(0.0, 0.0, sensor.body_diameter * MM / 2)
    lugs = [HullCircle(x, y - sizes.axis, STANDOFF_DIAMETER / 2 + 1.0) for x, y in places]
    plate = Prism(hull([around, *lugs]), PLATE_THICKNESS, (
        Hole((0.0, 0.0), sensor.pilot_diameter * MM),
        *(Hole((x, y - sizes.axis), STANDOFF_SCREW.clearance_hole * MM) for x, y in places)))  # fmt: skip
    body = stepped((sensor.shaft_diameter * MM / 2 - 0.01, -SHAFT_LENGTH, -sensor.pilot_height * MM),
                   (sensor.pilot_diameter * MM / 2 - 0.05, -sensor.pilot_height * MM, 0.0),
                   (sensor.body_diameter * MM / 2, 0.0, sensor.body_length * MM))  # fmt: skip
    return [
        Component("sensor plate", "body", plate, "aluminium", "laser cutting",
                  (place(0.0, sizes.axis, face + height),), f"plate {PLATE_THICKNESS:g}"),
        socket_screw("upper screw of a standoff", "body", upper_screw,
                     tuple(place(x, y, face + height + PLATE_THICKNESS) for x, y in places)),
        Component("angle sensor", "body", Turned(body), "brass", "bought",
                  (place(0.0, sizes.axis, face + height + PLATE_THICKNESS),), sensor.designation, sensor.mass,
                  size=f"shaft cut to {SHAFT_LENGTH:g} mm"),
        *(one.moved(turned) for one in _coupling(sizes)),
    ]  # fmt: skip


def _coupling(sizes: JointSizes) -> list[Component]:
    """Return the coupling of both shafts with its set screws, about the output's axis."""
    sensor, radius = ANGLE_SENSOR, _coupling_radius(sizes)
    low, reach = sizes.top + COUPLING_GAP, SHAFT_LENGTH - PLATE_THICKNESS - 1.0
    middle, high = sizes.top + COUPLED_LENGTH + SHAFT_GAP / 2, sizes.top + COUPLED_LENGTH + SHAFT_GAP + reach
    wide, narrow = sizes.shaft / 2 + 0.01, sensor.shaft_diameter * MM / 2 + 0.01
    bores = stepped((radius, 0.0, high - low), bore=min(wide, narrow))
    inner = max(wide, narrow)
    counter = (0.0, middle - low) if wide > narrow else (middle - low, high - low)
    start, way = (counter[0], 1.0) if wide > narrow else (counter[1], -1.0)
    pocket = Drilled((0.0, 0.0, start), (0.0, 0.0, way), 2 * inner, counter[1] - counter[0])
    threads = tuple(
        Drilled((radius, 0.0, z - low), (-1.0, 0.0, 0.0), SET_SCREW.tapping_hole * MM, radius, SET_SCREW.name)
        for z, r in ((low + 2.5, wide), (high - 2.5, narrow))
    )
    screws = tuple(
        (rod_length := radius - r - 0.2, place(r + 0.1, 0.0, z, axes_towards(1, 0, 0)))
        for z, r in ((low + 2.5, wide), (high - 2.5, narrow))
    )
    shortest = min(length for length, _ in screws)
    grub = sleeve(SET_SCREW.tapping_hole * MM - 0.02, 0.0, shortest)
    assert rod_length > 0
    return [
        Component("coupling", "output", Turned(bores, (pocket, *threads)), "aluminium", "turning", (place(z=low),),
                  f"round bar {2 * radius:g}", size=f"{high - low:.1f} mm long"),
        Component("set screw of the coupling", "output", grub, "screw-steel", "bought",
                  tuple(at for _, at in screws), f"ISO 4026 {SET_SCREW.name} x 3 - A2-21H"),
    ]  # fmt: skip
