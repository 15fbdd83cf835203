"""Wiring diagram of a machine: the devices of its wires in columns, from the sensors to the valves.

A wire to a strip (X1 to X3), to earth or to the host is drawn as its end at the device, with its number and the strip's
terminal; wires of the converters' bus run in lanes; all others are straight.
"""

from collections import Counter
from collections.abc import Iterator
from typing import NamedTuple

from layflat.machine import Machine
from layflat.machine.parameters import valve_and_sensors
from layflat.solids.documents.diagram import PAPER_SIZES, SHEET_MARGIN, Diagram, Point, shorten_text, title_height
from layflat.solids.documents.pins import ADC_GPIOS, ADC_NAMES, AIR_GPIO, BOARD_PINS, SERVICE_GPIO, STOP_GPIO, BoardPins
from layflat.solids.documents.wires import ADC_TERMINALS, STRIP_ENDS, WireRow, channel_terminal, list_wires

SENSOR_X, ADC_X, BOARD_X, DRIVER_X, LOAD_X, TOTAL_WIDTH = 12.0, 88.0, 176.0, 244.0, 318.0, 385.0  # of columns, mm
SENSOR_WIDTH, ADC_WIDTH, BOARD_WIDTH, DRIVER_WIDTH, LOAD_WIDTH = 42.0, 26.0, 36.0, 28.0, 42.0  # mm
SHEET_TOP, ROW_HEIGHT = 14.0, 3.6  # of the first devices, and of a terminal, mm
LANES_X, LANE_STEP = 138.0, 3.5  # of the converters' bus, mm
STUB_LENGTH = 4.0  # of the drawn end of a wire to a strip, mm
LETTER_HEIGHT = 1.6  # of terminals and numbers, mm
NAME_LETTERS = 28  # of the name in a box


class Device(NamedTuple):
    """Box of a device on the sheet, and its terminals with their rows below its upper edge."""

    tag: str
    name: str
    corner: Point
    width: float
    left: dict[str, float]
    right: dict[str, float]

    @property
    def height(self) -> float:
        """Height of the box, mm."""
        return (max([*self.left.values(), *self.right.values()]) + 0.6) * ROW_HEIGHT

    @property
    def bottom(self) -> float:
        """Lower edge of the box, mm."""
        return self.corner[1] + self.height

    def ends(self) -> Iterator[tuple[str, Point, float]]:
        """Yield name, place, and outward direction (-1 left, 1 right) of each terminal."""
        x, y = self.corner
        for side, edge, terminals in ((-1.0, x, self.left), (1.0, x + self.width, self.right)):
            for terminal, row in terminals.items():
                yield f"{self.tag}:{terminal}", (edge, y + row * ROW_HEIGHT), side


class Terminal(NamedTuple):
    """Place of a terminal on the sheet, and the direction out of its device, -1 left or 1 right."""

    place: Point
    side: float


def draw_wiring(machine: Machine) -> str:
    """Return the wiring diagram of a machine as SVG.

    Raises:
        MachineError: no valve or sensors, or it does not fit the firmware's pins and converters.
    """
    wires, devices = list_wires(machine), place_devices(machine)
    strips = [wire for wire in wires if {wire.origin, wire.end} <= STRIP_ENDS]
    bottom = max(*(device.bottom for device in devices), devices[-1].bottom + 4 * ROW_HEIGHT)
    notes = [
        f"8 BU: wire 8 of {machine.name}-wiring.csv, blue (IEC 60757). X1, X2, X3: strips; PE: earth.",
        "Tags are those of the pneumatic diagram. A1: board, with its pins; A2, A3: converters; K: drivers.",
    ]
    needed = bottom + 6.0 + title_height(notes)
    sizes = (paper for paper in PAPER_SIZES.values() if paper[0] >= TOTAL_WIDTH and paper[1] >= needed)
    sheet = Diagram(*next(sizes, (TOTAL_WIDTH, needed)))
    for device in devices:
        _draw_device(sheet, device)
    places = {name: Terminal(place, side) for device in devices for name, place, side in device.ends()}
    _draw_wires(sheet, wires, places)
    _draw_strips(sheet, strips, devices[-1])
    sheet.title_block(f"Wiring diagram of {machine.name}", notes)
    return sheet.document(f"Wiring diagram of {machine.name}")


def place_devices(machine: Machine) -> list[Device]:
    """Return all devices of a machine on the sheet, power supplies last; errors as from `draw_wiring`."""
    pins = BoardPins.for_machine(machine)
    sensors, rows = list(_place_sensors(machine)), list(_place_outputs(machine, pins))
    converters = _place_converters(pins, sensors)
    right = {f"GP{gpio}": (y - SHEET_TOP) / ROW_HEIGHT for gpio, y, _ in rows if gpio is not None}
    bus = [f"GP{gpio}" for gpio in (*ADC_GPIOS, *pins.selects)]
    left = {name: float(row) for row, name in enumerate([*bus, "3V3", "GND", "USB"], start=1)}
    board = Device("A1", "Pico", (BOARD_X, SHEET_TOP), BOARD_WIDTH, left, right)
    loads = [device for _, _, devices in rows for device in devices]
    return [*sensors, *converters, board, *loads, *_place_power(machine, sensors[-1].bottom)]


def _place_sensors(machine: Machine) -> Iterator[Device]:
    """Yield the sensors, in the order of their channels: angles, pressures, supply."""
    sensors = [(f"{j}S2", f"angle of {name}", "321") for j, name in enumerate(machine.joints, start=1)]
    sensors += [(f"{j}S1", f"pressure of {name}", "+U-") for j, name in enumerate(machine.joints, start=1)]
    for i, (tag, name, terminals) in enumerate([*sensors, ("0S1", "supply pressure", "+U-")]):
        corner = SENSOR_X, SHEET_TOP + 4 * ROW_HEIGHT * i
        yield Device(tag, name, corner, SENSOR_WIDTH, {}, dict(zip(terminals, (1, 2, 3), strict=True)))


def _place_converters(pins: BoardPins, sensors: list[Device]) -> list[Device]:
    """Return the converters, whose channels are as high as their sensors."""
    name = ADC_NAMES[pins.adc_bits]
    supply, bus = ADC_TERMINALS[name]
    right = {terminal: float(row) for row, terminal in enumerate((*bus, "CS", *supply), start=1)}
    heights = {channel_terminal(i): sensor.corner[1] + 2 * ROW_HEIGHT for i, sensor in enumerate(sensors)}
    converters: list[Device] = []
    for i in range(len(pins.selects)):
        channels = {key.split(":")[1]: y for key, y in heights.items() if key.startswith(f"A{2 + i}:")}
        top = max(min(channels.values()) - 2 * ROW_HEIGHT, converters[-1].bottom + 2.0 if converters else SHEET_TOP)
        left = {channel: (y - top) / ROW_HEIGHT for channel, y in channels.items()}
        converters.append(Device(f"A{2 + i}", name, (ADC_X, top), ADC_WIDTH, left, right))
    return converters


OutputRow = tuple[int | None, float, list[Device]]
"""GPIO of the board with the height of its wire, mm, and the devices of its row."""


def _place_outputs(machine: Machine, pins: BoardPins) -> Iterator[OutputRow]:
    """Yield the rows on the right of the board: valves, dump valve, e-stop, service pin, digital outputs."""
    y = SHEET_TOP
    for j, gpio in enumerate(pins.valves):
        for row in _place_joint(machine, j, gpio, y):
            yield row
            y = max(device.bottom for device in row[2]) + 0.4 * ROW_HEIGHT
    contact = Device("0S2", "e-stop", (DRIVER_X, y), DRIVER_WIDTH, {"11": 1}, {"12": 1})
    coil = Device("0V3", "dump valve", (LOAD_X, y), LOAD_WIDTH, {"+": 1, "-": 3}, {})
    driver = _place_driver("0K1", y + 2 * ROW_HEIGHT)
    yield AIR_GPIO, y + 3 * ROW_HEIGHT, [contact, coil, driver]
    y = driver.bottom + 0.4 * ROW_HEIGHT
    contacts = ((STOP_GPIO, "0S2", "e-stop", "22", "21"), (SERVICE_GPIO, "0S3", "service", "1", "2"))
    for gpio, tag, name, near, far in contacts:
        yield gpio, y + ROW_HEIGHT, [Device(tag, name, (DRIVER_X, y), DRIVER_WIDTH, {near: 1}, {far: 1})]
        y += 2 * ROW_HEIGHT
    for i, (name, gpio) in enumerate(zip(machine.interface.outputs, pins.outputs, strict=True), start=1):
        load = Device(f"0Y{i}", name, (LOAD_X, y), LOAD_WIDTH, {"-": 1}, {"+": 1})
        yield gpio, y + ROW_HEIGHT, [_place_driver(f"0K{i + 1}", y), load]
        y += 3 * ROW_HEIGHT


def _place_driver(tag: str, y: float) -> Device:
    """Return a driver of a load, with its upper edge at a height, mm."""
    return Device(tag, "driver", (DRIVER_X, y), DRIVER_WIDTH, {"IN": 1}, {"OUT": 1, "0V": 2})


def _place_joint(machine: Machine, j: int, gpio: int, y: float) -> Iterator[OutputRow]:
    """Yield the rows of joint j from a height on, mm: amplifier with valve or valves, regulator, calliper."""
    name, joint = list(machine.joints.items())[j]
    number, supply = j + 1, {"24V": 2.0, "0V": 3.0}
    if valve_and_sensors(machine)[0].kind == "switching":
        valves = [
            Device(
                f"{number}V1{which}", f"valve of {name}", (LOAD_X, y + row * ROW_HEIGHT), LOAD_WIDTH, {"+": 1}, {"-": 1}
            )
            for which, row in (("a", 0), ("b", 4))
        ]
        driver, outputs = "pulse driver", {"a": 1.0, "b": 5.0}
    else:
        valves = [Device(f"{number}V1", f"valve of {name}", (LOAD_X, y), LOAD_WIDTH, {"U": 1}, supply)]
        driver, outputs = "amplifier", {"OUT": 1.0}
    amplifier = Device(f"{number}K1", driver, (DRIVER_X, y), DRIVER_WIDTH, {"IN": 1}, outputs | supply)
    yield gpio, y + ROW_HEIGHT, [amplifier, *valves]
    y = amplifier.bottom + 0.4 * ROW_HEIGHT
    for part, tag, what in ((joint.regulator, "V2", "regulator"), (joint.brake.calliper, "V3", "calliper")):
        if part is not None:
            device = Device(f"{number}{tag}", f"{what} of {name}", (LOAD_X, y), LOAD_WIDTH, {}, {"U": 1, **supply})
            yield None, y, [device]
            y = device.bottom + 0.4 * ROW_HEIGHT


def _place_power(machine: Machine, y: float) -> Iterator[Device]:
    """Yield the power supplies, below the sensors."""
    y += 2 * ROW_HEIGHT
    if any(wire.origin.startswith("G2:") for wire in list_wires(machine)):
        yield Device("G2", "reference 10 V", (SENSOR_X, y), SENSOR_WIDTH, {}, {"10V": 2})
        y += 3 * ROW_HEIGHT
    yield Device("G1", "power supply 24 V", (SENSOR_X, y), SENSOR_WIDTH, {}, {"+": 1, "-": 2})


def _draw_device(sheet: Diagram, device: Device) -> None:
    """Draw the box of a device with its terminals; those of the board have their pins."""
    (x, y), middle = device.corner, device.corner[0] + device.width / 2
    sheet.box(device.corner, device.width, device.height)
    name = shorten_text(device.name, NAME_LETTERS)
    if device.height < 2 * ROW_HEIGHT:
        text = f"{device.tag} {shorten_text(device.name, NAME_LETTERS - 8)}"
        sheet.text((middle, y + ROW_HEIGHT + 0.6), text, height=LETTER_HEIGHT, anchor="middle", bold=True)
    elif device.left:
        sheet.text((middle, y + ROW_HEIGHT - 0.5), device.tag, height=2.0, anchor="middle", bold=True)
        sheet.text((middle, y + 2 * ROW_HEIGHT), name, height=LETTER_HEIGHT, anchor="middle")
    else:
        sheet.text((x + 1.0, y + ROW_HEIGHT), device.tag, height=2.0, bold=True)
        sheet.text((x + 1.0, y + 2 * ROW_HEIGHT), name, height=LETTER_HEIGHT)
    for port, (end, height), side in device.ends():
        terminal = port.partition(":")[2]
        pin = BOARD_PINS.get(int(terminal[2:])) if device.tag == "A1" and terminal.startswith("GP") else None
        text = terminal if pin is None else f"{terminal} ({pin})"
        anchor = "start" if side < 0.0 else "end"
        sheet.text((end - 1.2 * side, height + 0.6), text, height=LETTER_HEIGHT, anchor=anchor)
        sheet.circle((end, height), 0.5)


def _draw_wires(sheet: Diagram, wires: list[WireRow], places: dict[str, Terminal]) -> None:
    """Draw the wires that end at a device, each with its number and colour."""
    uses = Counter(end for wire in wires for end in (wire.origin, wire.end))
    bus = sorted(
        (name for name in places if name.startswith("A1:") and places[name].side < 0.0),
        key=lambda n: places[n].place[1],
    )
    for wire in wires:
        label = f"{wire.number} {wire.colour}".strip()
        ends = [end for end in (wire.origin, wire.end) if end not in STRIP_ENDS]
        if len(ends) == 1:
            (x, y), side = places[ends[0]]
            other = wire.end if ends[0] == wire.origin else wire.origin
            sheet.line((x, y), (x + side * STUB_LENGTH, y))
            place = x + side * (STUB_LENGTH + 0.5), y + 0.6
            sheet.text(place, f"{label} {other}", height=LETTER_HEIGHT, anchor="start" if side > 0.0 else "end")
        elif len(ends) == 2:
            (left, y1), (right, y2) = sorted((places[end].place for end in ends), key=lambda place: place[0])
            sheet.text((left + 1.5, y1 - 0.6), label, height=LETTER_HEIGHT)
            if abs(y1 - y2) < 1e-6:
                sheet.line((left, y1), (right, y1))
                continue
            lane = LANES_X + LANE_STEP * bus.index(wire.origin)
            sheet.line((left, y1), (lane, y1), (lane, y2), (right, y2))
            if uses[wire.origin] > 1:
                sheet.dot((lane, y2))


def _draw_strips(sheet: Diagram, wires: list[WireRow], above: Device) -> None:
    """Draw the wires between two strips, or a strip and earth, below a device."""
    x, y = SHEET_MARGIN + 2.0, above.bottom + 1.5 * ROW_HEIGHT
    for wire in wires:
        sheet.text((x, y + 0.6), wire.origin, height=LETTER_HEIGHT)
        sheet.line((x + 10.0, y), (x + 26.0, y))
        sheet.text((x + 12.0, y - 0.6), f"{wire.number} {wire.colour}", height=LETTER_HEIGHT)
        sheet.text((x + 27.0, y + 0.6), wire.end, height=LETTER_HEIGHT)
        y += 1.2 * ROW_HEIGHT
