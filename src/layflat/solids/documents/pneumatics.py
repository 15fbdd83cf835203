"""Pneumatic diagram of a machine, with the symbols of ISO 1219-1 and the numbers of the list of tubes.

The supply runs from the left; each joint is a column above its line. All valves are shown without current.
"""

from textwrap import wrap
from typing import NamedTuple

from layflat.machine import Joint, Machine
from layflat.machine.parameters import valve_and_sensors
from layflat.solids.documents import symbols
from layflat.solids.documents.components import AirComponent, list_components
from layflat.solids.documents.diagram import PAPER_SIZES, SHEET_MARGIN, Diagram, shorten_text, title_height
from layflat.solids.documents.tubes import TubeRow, list_tubes

HOSE_Y, SENSOR_Y, VALVE_Y, REGULATOR_Y, RAIL_Y, SUPPLY_Y = 25.0, 44.0, 74.0, 104.0, 112.0, 133.0  # heights, mm
COLUMN_WIDTH, PAIR_WIDTH, CALLIPER_WIDTH = 57.0, 88.0, 30.0  # of a joint, with a pair of valves, and added, mm
SUPPLY_WIDTH = 196.0  # of the supply's components, mm
LEGEND_Y, LEGEND_WIDTH, LEGEND_STEP = 158.0, 92.0, 3.3  # top, width of a column and step of a line, mm
LEGEND_LETTERS = 66  # of a line
HEAD_LETTERS = 26  # above a column


class JointColumn(NamedTuple):
    """Column of a joint on the sheet."""

    number: int
    name: str
    joint: Joint
    kind: str  # of its valve
    x: float  # of its middle, without the calliper


def draw_pneumatics(machine: Machine) -> str:
    """Return the pneumatic diagram of a machine as SVG.

    Raises:
        MachineError: no valve or sensors, or a valve of a kind that has no symbol.
    """
    components, kind = list_components(machine), valve_and_sensors(machine)[0].kind
    own = PAIR_WIDTH if kind == "switching" else COLUMN_WIDTH
    columns, right = list[JointColumn](), SHEET_MARGIN
    for number, (name, joint) in enumerate(machine.joints.items(), start=1):
        columns.append(JointColumn(number, name, joint, kind, right + own / 2))
        right += own + (CALLIPER_WIDTH if joint.brake.calliper is not None else 0.0)
    notes = [
        "Symbols of ISO 1219-1; a lens stands for a layflat hose. Tags as in ISO 1219-2, ports as in ISO 11727.",
        f"Drawn without current and air. T1 d4: tube T1 of {machine.name}-tubes.csv, bore 4 mm. + is forward.",
    ]
    lines = _legend_lines(components)
    sheet = _choose_sheet(max(right, SUPPLY_WIDTH) + SHEET_MARGIN, len(lines), title_height(notes))
    tubes = {(row.origin, row.end): row for row in list_tubes(machine)}
    for column in columns:
        _draw_joint(sheet, column, tubes)
    _draw_supply(sheet, tubes, [inlet for column in columns for inlet in _inlets(column)])
    _draw_legend(sheet, lines)
    sheet.title_block(f"Pneumatic diagram of {machine.name}", notes)
    return sheet.document(f"Pneumatic diagram of {machine.name}")


def _choose_sheet(width: float, lines: int, title: float) -> Diagram:
    """Return the smallest sheet for a width, mm, lines of the legend, and the height of the title, mm."""
    for paper in (*PAPER_SIZES.values(), (width, 2.0 * width)):
        sheet = Diagram(*paper)
        if width <= sheet.width and LEGEND_Y + LEGEND_STEP * _legend_rows(sheet, lines) + title <= sheet.height:
            break
    return sheet


def _legend_lines(components: list[AirComponent]) -> list[tuple[str, str]]:
    """Return the lines of the legend: tag, empty on further lines, and text."""
    lines = []
    for part in components:
        first, *more = wrap(f"{part.name}: {part.rating}" if part.rating else part.name, LEGEND_LETTERS)
        lines += [(part.tag, first), *(("", text) for text in more)]
    return lines


def _legend_rows(sheet: Diagram, lines: int) -> int:
    """Return the number of rows in which a legend of lines fits beside itself on a sheet."""
    return -(-lines // max(int(sheet.inner_width // LEGEND_WIDTH), 1))


def _draw_legend(sheet: Diagram, lines: list[tuple[str, str]]) -> None:
    """Write the legend in columns."""
    rows = _legend_rows(sheet, len(lines))
    for i, (tag, text) in enumerate(lines):
        x, y = SHEET_MARGIN + LEGEND_WIDTH * (i // rows), LEGEND_Y + LEGEND_STEP * (i % rows)
        sheet.text((x, y), tag, height=1.9, bold=True)
        sheet.text((x + 8.0, y), text, height=1.9)


def _inlets(column: JointColumn) -> list[float]:
    """Return where a column's components are connected to the line of the supply, mm."""
    valves = [column.x - 19.0, column.x + 23.0] if column.kind == "switching" else [column.x]
    if column.joint.regulator is not None:
        valves = [column.x]
    own = PAIR_WIDTH if column.kind == "switching" else COLUMN_WIDTH
    return valves + ([column.x + own / 2 + 2.0] if column.joint.brake.calliper is not None else [])


def _draw_supply(sheet: Diagram, tubes: dict[tuple[str, str], TubeRow], inlets: list[float]) -> None:
    """Draw the supply from its source to the line above it, which feeds all inlets."""
    y = SUPPLY_Y
    sheet.polygon((SHEET_MARGIN + 1.0, y - 2.0), (SHEET_MARGIN + 1.0, y + 2.0), (SHEET_MARGIN + 5.0, y))
    sheet.line((SHEET_MARGIN + 5.0, y), (28.0, y))
    sheet.text((SHEET_MARGIN + 1.0, y - 3.0), "0P1", bold=True)
    _draw_chain_valve(sheet, 28.0, "0V1", by_hand=True)
    sheet.line((38.0, y), (48.0, y))
    symbols.draw_filter(sheet, (48.0, y))
    sheet.line((58.0, y), (62.0, y))
    with sheet.moved((62.0, y), 90.0):
        symbols.draw_regulator(sheet, (0.0, 0.0))
    sheet.line((70.0, y), (112.0, y))
    symbols.draw_gauge(sheet, (76.0, y))
    sheet.box((46.5, y - 12.0), 35.0, 24.0, "frame")
    sheet.text((47.0, y - 13.0), "0Z1", bold=True)
    sheet.dot((92.0, y))
    sheet.line((92.0, y), (92.0, y + 1.5))
    symbols.draw_relief_valve(sheet, (92.0, y + 1.5))
    sheet.text((88.0, y - 2.0), "0V2", bold=True)
    _draw_chain_valve(sheet, 112.0, "0V3")
    sheet.line((122.0, y), (132.0, y))
    symbols.draw_soft_start(sheet, (132.0, y))
    sheet.text((156.5, y - 8.0), "0V4", bold=True)
    sheet.line((158.0, y), (184.0, y), (184.0, RAIL_Y))
    sheet.dot((170.0, y))
    sheet.line((170.0, y), (170.0, y + 3.0))
    symbols.draw_transducer(sheet, (165.0, y + 3.0), "p", output_below=True)
    sheet.text((176.5, y + 9.0), "0S1", bold=True)
    sheet.text((185.5, RAIL_Y + 4.5), "0Z2", bold=True)
    for key, x in ((("0P1", "0V1:1"), 20.0), (("0V1:2", "0Z1:1"), 38.4), (("0V4:2", "0Z2"), 174.0)):
        sheet.text((x, y - 1.0), f"{tubes[key].number} d{1e3 * (tubes[key].bore or 0.0):.3g}", height=1.8)
    ends = [184.0, *inlets]
    sheet.line((min(ends), RAIL_Y), (max(ends), RAIL_Y), style="bold")
    for x in ends:
        sheet.dot((x, RAIL_Y))


def _draw_chain_valve(sheet: Diagram, x: float, tag: str, *, by_hand: bool = False) -> None:
    """Draw a 3/2 valve in the line of the supply, from its port 1, with its silencer below."""
    y = SUPPLY_Y
    with sheet.moved((x, y), 90.0):
        symbols.draw_three_port_valve(sheet, (0.0, 0.0), by_hand=by_hand)
    sheet.line((x, y + 4.0), (x - 4.0, y + 4.0), (x - 4.0, y + 8.0))
    symbols.draw_silencer(sheet, (x - 4.0, y + 8.0))
    sheet.text((x - 1.0, y - 8.0), tag, anchor="end", bold=True)


def _draw_joint(sheet: Diagram, column: JointColumn, tubes: dict[tuple[str, str], TubeRow]) -> None:
    """Draw the column of a joint: hoses, sensor, valve, regulator and calliper."""
    x, n, joint = column.x, column.number, column.joint
    sheet.text((x, 13.0), shorten_text(f"joint {n}: {column.name}", HEAD_LETTERS), anchor="middle", bold=True)
    _draw_hoses(sheet, column)
    if column.kind == "switching":
        _draw_pair(sheet, column, tubes)
    else:
        _draw_proportional(sheet, column, tubes)
    own = PAIR_WIDTH if column.kind == "switching" else COLUMN_WIDTH
    if joint.brake.calliper is not None:
        right = x + own / 2 + 2.0
        symbols.draw_calliper(sheet, (right, HOSE_Y + 4.0))
        sheet.line((right, HOSE_Y + 4.0), (right, REGULATOR_Y - 8.0))
        symbols.draw_regulator(sheet, (right, REGULATOR_Y), proportional=True)
        sheet.line((right, REGULATOR_Y), (right, RAIL_Y))
        sheet.text((right, HOSE_Y - 3.5), f"{n}A3", bold=True)
        sheet.text((right + 16.0, REGULATOR_Y - 2.5), f"{n}V3", bold=True)
        _label(sheet, (right, VALVE_Y - 20.0), tubes[f"{n}V3:2", f"{n}A3"], left=False)
        _label(sheet, (right, RAIL_Y - 3.5), tubes["0Z2", f"{n}V3:1"])


def _draw_hoses(sheet: Diagram, column: JointColumn) -> None:
    """Draw the shaft of a joint, its hoses, their straps, the transducer between them and its spring."""
    x, n, joint = column.x, column.number, column.joint
    double = joint.acting == "double"
    sheet.circle((x, HOSE_Y), 2.0)
    sheet.curve(f"M{x + 3.2:.2f},{HOSE_Y - 2.6:.2f} A4.2,4.2 0 0 0 {x - 3.2:.2f},{HOSE_Y - 2.6:.2f}", "thin")
    sheet.arrow((x - 2.7, HOSE_Y - 3.2), (x - 3.8, HOSE_Y - 1.7), style="thin")
    sheet.text((x, HOSE_Y - 5.0), "+", anchor="middle")
    for side, tag in ((-1.0, "A1"), (1.0, "A2"))[: 1 + double]:
        symbols.draw_hose(sheet, (x + side * 15.0, HOSE_Y))
        for offset in (-0.4, 0.4):
            sheet.line((x + side * 7.0, HOSE_Y + offset), (x + side * 2.0, HOSE_Y + offset))
        sheet.text((x + side * 15.0, HOSE_Y - 5.0), f"{n}{tag}", anchor="middle", bold=True)
        sheet.line((x + side * 15.0, HOSE_Y + 3.5), (x + side * 15.0, SENSOR_Y))
        sheet.dot((x + side * 15.0, SENSOR_Y))
        sheet.line((x + side * 15.0, SENSOR_Y), (x + side * 5.0, SENSOR_Y))
        sheet.text((x + side * 7.0, SENSOR_Y - 0.8), "+" if side < 0.0 else "-", height=1.8, anchor="middle")
    symbols.draw_transducer(sheet, (x - 5.0, SENSOR_Y - 4.0), "dp")
    sheet.text((x + 2.0, SENSOR_Y - 5.2), f"{n}S1", bold=True)
    if not double:
        sheet.line((x + 5.0, SENSOR_Y), (x + 9.0, SENSOR_Y), (x + 9.0, SENSOR_Y + 1.0))
        symbols.draw_exhaust(sheet, (x + 9.0, SENSOR_Y + 1.0))
    if joint.spring is not None:
        start = (x + 2.0, HOSE_Y) if not double else (x, HOSE_Y)
        with sheet.moved(start, 0.0 if not double else 90.0):
            sheet.line((0.0, 0.0), (2.0, 0.0))
            symbols.draw_spring(sheet, (2.0, 0.0), 7.0)
            sheet.line((9.0, -2.0), (9.0, 2.0), style="bold")


def _draw_proportional(sheet: Diagram, column: JointColumn, tubes: dict[tuple[str, str], TubeRow]) -> None:
    """Draw the 5/3 valve of a joint with its tubes, silencers and regulator."""
    x, n = column.x, column.number
    top, bottom = VALVE_Y - symbols.WIDE_BOX / 2, VALVE_Y + symbols.WIDE_BOX / 2
    symbols.draw_five_port_valve(sheet, (x, VALVE_Y), str(n))
    bend = top - 8.0
    sheet.line((x - 15.0, SENSOR_Y), (x - 15.0, bend), (x - 3.0, bend), (x - 3.0, top))
    _label(sheet, (x - 15.0, SENSOR_Y + 8.0), tubes[f"{n}V1:4", f"{n}A1"])
    if column.joint.acting == "double":
        sheet.line((x + 15.0, SENSOR_Y), (x + 15.0, bend), (x + 3.0, bend), (x + 3.0, top))
        _label(sheet, (x + 15.0, SENSOR_Y + 8.0), tubes[f"{n}V1:2", f"{n}A2"], left=False)
    else:
        symbols.draw_plug(sheet, (x + 3.0, top))
    for side in (-1.0, 1.0):
        sheet.line((x + side * 4.0, bottom), (x + side * 4.0, bottom + 5.0), (x + side * 9.0, bottom + 5.0))
        sheet.line((x + side * 9.0, bottom + 5.0), (x + side * 9.0, bottom + 7.0))
        symbols.draw_silencer(sheet, (x + side * 9.0, bottom + 7.0))
    _draw_feed(sheet, column, (x, bottom), tubes, f"{n}V1:1")


def _draw_pair(sheet: Diagram, column: JointColumn, tubes: dict[tuple[str, str], TubeRow]) -> None:
    """Draw the two 4/2 valves of a joint with their tubes, silencers and regulator."""
    x, n, double = column.x, column.number, column.joint.acting == "double"
    top, bottom = VALVE_Y - symbols.WIDE_BOX / 2, VALVE_Y + symbols.WIDE_BOX / 2
    rests = (x - 16.0, x + 26.0)
    for rest, which, fills_left in zip(rests, "ab", (True, False), strict=True):
        symbols.draw_four_port_valve(sheet, (rest, VALVE_Y), f"{n}V1{which}", fills_left=fills_left)
        sheet.line((rest + 3.0, bottom), (rest + 3.0, bottom + 6.0))
        symbols.draw_silencer(sheet, (rest + 3.0, bottom + 6.0))
    for actuator, port, shift, side in (("A1", 4, -3.0, -1.0), ("A2", 2, 3.0, 1.0))[: 1 + double]:
        bend = top - (10.0 if port == 4 else 6.0)
        sheet.line((x + side * 15.0, SENSOR_Y), (x + side * 15.0, bend))
        sheet.dot((x + side * 15.0, bend))
        sheet.line((rests[0] + shift, top), (rests[0] + shift, bend), (rests[1] + shift, bend), (rests[1] + shift, top))
        _label(sheet, (x + side * 15.0, SENSOR_Y + 7.0), tubes[f"{n}V1a:{port}", f"{n}{actuator}"], left=port == 4)
    if not double:
        for rest in rests:
            symbols.draw_plug(sheet, (rest + 3.0, top))
    if column.joint.regulator is None:
        for rest, which in zip(rests, "ab", strict=True):
            _draw_feed(sheet, column, (rest - 3.0, bottom), tubes, f"{n}V1{which}:1")
    else:
        joint = bottom + 4.0
        sheet.line((rests[0] - 3.0, bottom), (rests[0] - 3.0, joint), (rests[1] - 3.0, joint), (rests[1] - 3.0, bottom))
        sheet.dot((x, joint))
        _draw_feed(sheet, column, (x, joint), tubes, f"{n}V1a:1")


def _draw_feed(
    sheet: Diagram, column: JointColumn, point: tuple[float, float], tubes: dict[tuple[str, str], TubeRow], inlet: str
) -> None:
    """Draw the tube from the line of the supply to an inlet of a valve above it, through a regulator if there is one.

    Args:
        sheet: the diagram.
        column: column of the joint.
        point: of the inlet.
        tubes: all tubes, by their ends.
        inlet: name of the inlet.
    """
    (x, y), n = point, column.number
    if column.joint.regulator is None:
        sheet.line((x, y), (x, RAIL_Y))
        _label(sheet, (x, REGULATOR_Y), tubes["0Z2", inlet])
        return
    sheet.line((x, y), (x, REGULATOR_Y - 8.0))
    symbols.draw_regulator(sheet, (x, REGULATOR_Y), proportional=True)
    sheet.line((x, REGULATOR_Y), (x, RAIL_Y))
    sheet.text((x + 15.6, REGULATOR_Y - 2.5), f"{n}V2", bold=True)
    _label(sheet, (x, RAIL_Y - 3.5), tubes["0Z2", f"{n}V2:1"])


def _label(sheet: Diagram, point: tuple[float, float], tube: TubeRow, *, left: bool = True) -> None:
    """Write number and size of a tube beside a point of its vertical line."""
    x, y = point
    shift, anchor = (-0.8, "end") if left else (0.8, "start")
    sheet.text((x + shift, y), f"{tube.number} d{1e3 * (tube.bore or 0.0):.3g}", height=1.8, anchor=anchor)
