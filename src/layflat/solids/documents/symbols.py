"""Symbols of ISO 1219-1 on a diagram. Valves have their inlets below and outlets above; turn them with `moved`.

The standard has no symbol for a layflat hose: a lens stands for it.
"""

from layflat.solids.documents.diagram import Diagram, Point

BOX_SIDE = 10.0  # side of the box of a valve with two or three ports, mm
WIDE_BOX = 12.0  # of a valve with four or five ports, mm
ACTUATOR_LENGTH = 7.0  # length of a solenoid or a spring beside its valve, mm


def draw_blocked_port(sheet: Diagram, port: Point, inwards: float) -> None:
    """Draw the T of a closed port.

    Args:
        sheet: the diagram.
        port: the port, on the edge of its box.
        inwards: length of the stem, mm, positive downwards.
    """
    x, y = port
    sheet.line((x, y), (x, y + inwards))
    sheet.line((x - 1.2, y + inwards), (x + 1.2, y + inwards))


def draw_spring(sheet: Diagram, start: Point, length: float) -> None:
    """Draw a horizontal spring.

    Args:
        sheet: the diagram.
        start: one of its ends.
        length: mm; negative to the left.
    """
    x, y = start
    step = length / 5
    sheet.line(*[(x + i * step, y + (0.0 if i in {0, 5} else (1.5, -1.5)[i % 2])) for i in range(6)])


def draw_solenoid(sheet: Diagram, corner: Point, *, proportional: bool = False) -> None:
    """Draw a solenoid of 7 mm by 6 mm.

    Args:
        sheet: the diagram.
        corner: its upper left corner.
        proportional: whether an arrow runs through it.
    """
    x, y = corner
    sheet.box(corner, ACTUATOR_LENGTH, 6.0)
    sheet.line((x + 2.0, y + 6.0), (x + 5.0, y))
    if proportional:
        sheet.arrow((x + 0.8, y + 5.2), (x + 6.4, y + 0.8), style="thin")


def draw_exhaust(sheet: Diagram, point: Point) -> None:
    """Draw the open triangle of air that leaves downwards from a point."""
    x, y = point
    sheet.polygon((x - 1.4, y), (x + 1.4, y), (x, y + 2.2))


def draw_silencer(sheet: Diagram, point: Point) -> None:
    """Draw a silencer below a point."""
    x, y = point
    sheet.box((x - 1.7, y), 3.4, 3.8)
    for depth in (1.0, 1.9, 2.8):
        sheet.line((x - 1.0, y + depth), (x + 1.0, y + depth), style="thin")
    draw_exhaust(sheet, (x, y + 3.8))


def draw_five_port_valve(sheet: Diagram, centre: Point, number: str) -> None:
    """Draw a 5/3 proportional valve, closed and centred by springs, around the centre of its middle box.

    Ports: 4 and 2 above at -3 and 3 mm, 5, 1 and 3 below at -4, 0 and 4 mm from the centre.

    Args:
        sheet: the diagram.
        centre: of the box of the middle position.
        number: the joint's number, for its tag.
    """
    x, y = centre
    half, top, bottom = WIDE_BOX / 2, y - WIDE_BOX / 2, y + WIDE_BOX / 2
    for shift in (-WIDE_BOX, 0.0, WIDE_BOX):
        sheet.box((x + shift - half, top), WIDE_BOX, WIDE_BOX)
    for offset in (-1.4, WIDE_BOX + 1.4):  # positions between the boxes: a proportional valve
        sheet.line((x - 3 * half, top + offset), (x + 3 * half, top + offset))
    for port in (-4.0, 0.0, 4.0):
        draw_blocked_port(sheet, (x + port, bottom), -3.0)
    for port in (-3.0, 3.0):
        draw_blocked_port(sheet, (x + port, top), 3.0)
    _draw_five_port_paths(sheet, x - WIDE_BOX, y, 1.0)
    _draw_five_port_paths(sheet, x + WIDE_BOX, y, -1.0)
    for side in (-1.0, 1.0):
        edge = x + side * 3 * half
        draw_solenoid(sheet, (edge if side > 0.0 else edge - ACTUATOR_LENGTH, top), proportional=True)
        draw_spring(sheet, (edge, bottom - 3.0), side * ACTUATOR_LENGTH)
    _write_ports(sheet, x, top, bottom)
    sheet.text((x - 3 * half - ACTUATOR_LENGTH, top - 3.0), f"{number}V1", bold=True)
    sheet.text((x - 3 * half - ACTUATOR_LENGTH, bottom + 4.5), "14", height=1.8)
    sheet.text((x + 3 * half + ACTUATOR_LENGTH, bottom + 4.5), "12", height=1.8, anchor="end")


def draw_four_port_valve(sheet: Diagram, centre: Point, tag: str, *, fills_left: bool) -> None:
    """Draw a 4/2 on/off valve, closed by its spring, around the centre of its box at rest.

    Ports: 4 and 2 above at -3 and 3 mm, 1 and 3 below at the same.

    Args:
        sheet: the diagram.
        centre: of the box at rest, on the right.
        tag: tag of the valve.
        fills_left: whether the solenoid connects 1 with 4 and 2 with 3, rather than 1 with 2 and 4 with 3.
    """
    x, y = centre
    half, top, bottom = WIDE_BOX / 2, y - WIDE_BOX / 2, y + WIDE_BOX / 2
    active = x - WIDE_BOX
    for middle in (active, x):
        sheet.box((middle - half, top), WIDE_BOX, WIDE_BOX)
    for port in (-3.0, 3.0):
        draw_blocked_port(sheet, (x + port, top), 3.0)
        draw_blocked_port(sheet, (x + port, bottom), -3.0)
    left, right = (-3.0, 3.0) if fills_left else (3.0, -3.0)
    sheet.arrow((active - 3.0, bottom), (active + left, top))
    sheet.arrow((active + right, top), (active + 3.0, bottom))
    draw_solenoid(sheet, (active - half - ACTUATOR_LENGTH, y - 3.0))
    draw_spring(sheet, (x + half, y), ACTUATOR_LENGTH)
    for name, shift, baseline in (("4", -3.0, top - 0.7), ("2", 3.0, top - 0.7), ("1", -3.0, bottom + 2.4)):
        sheet.text((x + shift + 0.5, baseline), name, height=1.6)
    sheet.text((x + 3.5, bottom + 2.4), "3", height=1.6)
    sheet.text((active - half - ACTUATOR_LENGTH, top - 2.0), tag, bold=True)


def draw_three_port_valve(sheet: Diagram, port: Point, *, by_hand: bool = False) -> None:
    """Draw a 3/2 valve that is closed at rest, from its port 1; 3 is 4 mm to the right, 2 is 10 mm above 1.

    Args:
        sheet: the diagram.
        port: port 1 of the box at rest.
        by_hand: whether a lever with a detent moves it, rather than a solenoid against a spring.
    """
    x, y = port
    left, top = x - 3.0, y - BOX_SIDE
    for shift in (0.0, -BOX_SIDE):
        sheet.box((left + shift, top), BOX_SIDE, BOX_SIDE)
    draw_blocked_port(sheet, (x, y), -3.0)
    sheet.arrow((x, top), (x + 4.0, y))
    sheet.arrow((x - BOX_SIDE, y), (x - BOX_SIDE, top))
    draw_blocked_port(sheet, (x + 4.0 - BOX_SIDE, y), -3.0)
    edge, middle = left - BOX_SIDE, y - BOX_SIDE / 2
    if by_hand:
        sheet.line((edge, middle), (edge - 5.0, middle), (edge - 5.0, middle + 3.0))
        sheet.line((edge - 5.0, middle), (edge - 5.0, middle - 3.0))
        sheet.line((edge - 1.2, middle), (edge - 1.8, middle + 1.2), (edge - 2.4, middle))
    else:
        draw_solenoid(sheet, (edge - ACTUATOR_LENGTH, middle - 3.0))
        draw_spring(sheet, (left + BOX_SIDE, middle), ACTUATOR_LENGTH)


def draw_regulator(sheet: Diagram, port: Point, *, proportional: bool = False) -> None:
    """Draw a pressure regulator with venting from its inlet; its outlet is 8 mm above.

    Args:
        sheet: the diagram.
        port: the inlet.
        proportional: whether a proportional solenoid sets it, rather than a screw with a spring.
    """
    x, y = port
    sheet.box((x - 4.0, y - 8.0), 8.0, 8.0)
    sheet.arrow((x, y), (x, y - 8.0))
    sheet.line((x, y - 9.5), (x - 6.0, y - 9.5), (x - 6.0, y - 4.0), (x - 4.0, y - 4.0), style="pilot")
    draw_spring(sheet, (x + 4.0, y - 5.5), 4.0)
    if proportional:
        draw_solenoid(sheet, (x + 8.0, y - 7.5), proportional=True)
    else:
        sheet.arrow((x + 4.6, y - 2.9), (x + 8.0, y - 8.0), style="thin")
    draw_exhaust(sheet, (x + 2.6, y))


def draw_relief_valve(sheet: Diagram, port: Point) -> None:
    """Draw a relief valve from its inlet, above; the air leaves 8 mm below."""
    x, y = port
    sheet.box((x - 4.0, y), 8.0, 8.0)
    sheet.arrow((x + 2.0, y), (x + 2.0, y + 8.0))
    sheet.line((x, y - 1.5), (x - 6.0, y - 1.5), (x - 6.0, y + 4.0), (x - 4.0, y + 4.0), style="pilot")
    sheet.line((x, y - 1.5), (x, y))
    draw_spring(sheet, (x + 4.0, y + 4.0), 5.0)
    sheet.arrow((x + 4.6, y + 7.0), (x + 8.6, y + 1.0), style="thin")
    draw_exhaust(sheet, (x + 2.0, y + 8.0))


def draw_filter(sheet: Diagram, port: Point) -> None:
    """Draw a filter with a drain by hand, from its left port; the right one is 10 mm away."""
    x, y = port
    sheet.polygon((x, y), (x + 5.0, y - 5.0), (x + 10.0, y), (x + 5.0, y + 5.0))
    sheet.line((x + 5.0, y - 5.0), (x + 5.0, y + 3.0), style="pilot")
    sheet.line((x + 3.0, y + 3.0), (x + 7.0, y + 3.0))
    sheet.line((x + 5.0, y + 5.0), (x + 5.0, y + 7.0))


def draw_gauge(sheet: Diagram, foot: Point) -> None:
    """Draw a pressure gauge on a stem of 4 mm above a point of a line."""
    x, y = foot
    sheet.dot(foot)
    sheet.line(foot, (x, y - 4.0))
    sheet.circle((x, y - 7.0), 3.0)
    sheet.arrow((x - 1.6, y - 5.4), (x + 1.7, y - 8.7), style="thin")


def draw_transducer(sheet: Diagram, corner: Point, letters: str, *, output_below: bool = False) -> None:
    """Draw a transducer of pressure, 10 mm by 8 mm, from its upper left corner, with its electric output.

    Args:
        sheet: the diagram.
        corner: its upper left corner.
        letters: measured quantity, such as "p".
        output_below: whether the output is below, rather than above.
    """
    x, y = corner
    sheet.box(corner, 10.0, 8.0)
    sheet.line((x, y + 8.0), (x + 10.0, y))
    sheet.text((x + 0.8, y + 3.2), letters, height=1.8)
    sheet.text((x + 6.6, y + 7.0), "U", height=1.8)
    start, end = (y + 8.0, y + 11.0) if output_below else (y, y - 3.0)
    sheet.line((x + 5.0, start), (x + 5.0, end), style="thin")


def draw_plug(sheet: Diagram, port: Point) -> None:
    """Draw the plug of a port, above it."""
    x, y = port
    sheet.line((x, y), (x, y - 6.0))
    sheet.line((x - 1.0, y - 7.0), (x + 1.0, y - 5.0))
    sheet.line((x - 1.0, y - 5.0), (x + 1.0, y - 7.0))


def draw_soft_start(sheet: Diagram, port: Point) -> None:
    """Draw a soft-start valve from its inlet on the left; its outlet is 26 mm to the right.

    A 2/2 valve, opened by the pressure behind it, bridges a throttle.
    """
    x, y = port
    sheet.line(port, (x + 8.0, y))
    sheet.line((x + 18.0, y), (x + 26.0, y))
    sheet.line((x + 3.0, y), (x + 3.0, y + 13.0), (x + 23.0, y + 13.0), (x + 23.0, y))
    for point in ((x + 3.0, y), (x + 23.0, y)):
        sheet.dot(point)
    sheet.curve(f"M{x + 10:.2f},{y + 11:.2f} q3,1.4 6,0")
    sheet.curve(f"M{x + 10:.2f},{y + 15:.2f} q3,-1.4 6,0")
    sheet.arrow((x + 10.5, y + 16.0), (x + 15.5, y + 10.0), style="thin")
    with sheet.moved((x + 8.0, y), 90.0):  # a box at rest, and the active one above it
        for shift in (-3.0, -13.0):
            sheet.box((shift, -10.0), 10.0, 10.0)
        draw_blocked_port(sheet, (0.0, 0.0), -3.0)
        draw_blocked_port(sheet, (0.0, -10.0), 3.0)
        sheet.arrow((-10.0, 0.0), (-10.0, -10.0))
    sheet.line(*[(x + 13.0 + dx, y + 7.0 + 0.5 * i) for i, dx in enumerate((0.0, 1.5, -1.5, 1.5, -1.5, 0.0))])
    sheet.line((x + 13.0, y - 13.0), (x + 13.0, y - 15.0), (x + 23.0, y - 15.0), (x + 23.0, y), style="pilot")


def draw_hose(sheet: Diagram, centre: Point) -> None:
    """Draw a layflat hose as a lens of 16 mm by 7 mm around its centre, with its port 3.5 mm below."""
    x, y = centre
    sheet.curve(f"M{x - 8:.2f},{y:.2f} q8,-7 16,0 q-8,7 -16,0 Z", "bold")


def draw_calliper(sheet: Diagram, port: Point) -> None:
    """Draw a single-acting cylinder that a spring returns, from its port below, on the left, with the brake's pads."""
    x, y = port
    sheet.box((x - 2.0, y - 6.0), 14.0, 6.0)
    sheet.line((x + 2.0, y - 6.0), (x + 2.0, y))
    sheet.line((x + 3.0, y - 6.0), (x + 3.0, y))
    draw_spring(sheet, (x + 3.0, y - 1.8), 9.0)
    sheet.line((x + 3.0, y - 3.4), (x + 14.5, y - 3.4))
    sheet.line((x + 3.0, y - 2.6), (x + 14.5, y - 2.6))
    sheet.box((x + 14.5, y - 5.5), 1.2, 5.0)
    sheet.line((x + 16.4, y - 7.0), (x + 16.4, y + 1.0), style="bold")
    sheet.box((x + 17.1, y - 5.5), 1.2, 5.0)


def _draw_five_port_paths(sheet: Diagram, x: float, y: float, side: float) -> None:
    """Draw the paths of a position: 1 to the port above on one side (1: 4, -1: 2), the other one to its exhaust."""
    top, bottom = y - WIDE_BOX / 2, y + WIDE_BOX / 2
    sheet.arrow((x, bottom), (x - 3.0 * side, top))
    sheet.arrow((x + 3.0 * side, top), (x + 4.0 * side, bottom))
    draw_blocked_port(sheet, (x - 4.0 * side, bottom), -3.0)


def _write_ports(sheet: Diagram, x: float, top: float, bottom: float) -> None:
    """Write the numbers of the ports of a 5/3 valve (ISO 11727)."""
    for port, shift in (("4", -3.0), ("2", 3.0)):
        sheet.text((x + shift + 0.5, top - 1.9), port, height=1.6)
    for port, shift in (("5", -4.0), ("1", 0.0), ("3", 4.0)):
        sheet.text((x + shift + 0.5, bottom + 3.4), port, height=1.6)
