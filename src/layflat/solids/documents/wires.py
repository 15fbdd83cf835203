"""Wires of a machine with the firmware: every terminal that `firmware/pico.py` uses, and what it needs around it.

Tags are those of the pneumatic diagram; A1 is the board, A2 and A3 converters, K amplifiers and drivers, Y loads of
digital outputs, G power supplies, X terminal strips. X1 has 24 V, X2 the board's 3.3 V, X3 10 V.
"""

import csv
import io
from collections.abc import Iterator
from enum import StrEnum
from typing import NamedTuple

from layflat.machine import Machine
from layflat.machine.parameters import valve_and_sensors
from layflat.physics.valves import ValvePart
from layflat.solids.documents.components import joint_components
from layflat.solids.documents.pins import (
    ADC_CHANNELS,
    ADC_GPIOS,
    ADC_NAMES,
    ADC_REFERENCE,
    AIR_GPIO,
    BOARD_PINS,
    SERVICE_GPIO,
    STOP_GPIO,
    BoardPins,
)


class Strip(StrEnum):
    """Terminal of a strip, or earth, at which many wires end."""

    V24 = "X1:24V"
    V0 = "X1:0V"
    V3 = "X2:3V3"
    GND = "X2:GND"
    V10 = "X3:10V"
    PE = "PE"


STRIP_ENDS = frozenset({*Strip, "host"})
"""Ends of wires at no device of the diagram."""
COLOURS = {
    Strip.V24: "BU", Strip.V0: "WHBU", Strip.V3: "RD", Strip.GND: "BK", Strip.V10: "OG", Strip.PE: "GNYE",
    "valve": "YE", "angle": "WH", "pressure": "GN", "clock": "GY", "data": "PK", "select": "VT",
    "contact": "BN", "output": "TQ",
}  # fmt: skip
"""Colours (IEC 60757) by terminal or signal; 24 V are blue, their 0 V white with blue (IEC 60204-1)."""
SIGNAL_AREA, LOAD_AREA, EARTH_AREA = 0.25, 0.75, 1.5  # cross-sections, mm2
ADC_TERMINALS = {
    "MCP3208": ({"VDD": Strip.V3, "VREF": Strip.V3, "AGND": Strip.GND, "DGND": Strip.GND}, ("DOUT", "CLK", "DIN")),
    "ADS8344": (
        {"VCC": Strip.V3, "VREF": Strip.V3, "SHDN": Strip.V3, "COM": Strip.GND, "GND": Strip.GND},
        ("DOUT", "DCLK", "DIN"),
    ),
}
"""Terminals of a converter: its supply, and data out, clock and data in."""
DIODE_NOTE = "free-wheeling diode at the driver"
FIXED_NOTE = "stays at its greatest: the firmware has no output for it"
PULL_DOWN = "10 kOhm to 0 V at the driver"
COLUMNS = ("number", "signal", "from", "to", "colour", "area_mm2", "note")


class WireRow(NamedTuple):
    """Wire between two terminals, each DEVICE:TERMINAL."""

    signal: str
    origin: str
    end: str
    colour: str  # IEC 60757; empty for a cable
    area: float | None = SIGNAL_AREA  # cross-section, mm2
    note: str = ""
    number: int = 0


def list_wires(machine: Machine) -> list[WireRow]:
    """Return the wires of a machine, numbered from 1.

    Raises:
        MachineError: no valve or sensors, or it does not fit the firmware's pins and converters.
    """
    pins = BoardPins.for_machine(machine)
    wires = [*_power(machine), *_stop_and_air(), *_converters(pins), *_supply_sensor(machine, pins)]
    for j in range(len(machine.joints)):
        wires += [*_sensors(machine, pins, j), *_valves(machine, pins, j)]
    wires += _outputs(machine, pins)
    return [wire._replace(number=number) for number, wire in enumerate(wires, start=1)]


def gpio_terminal(gpio: int) -> str:
    """Return the terminal of a GPIO of the board."""
    return f"A1:GP{gpio}"


def channel_terminal(channel: int) -> str:
    """Return the terminal of a channel, of the first converter or of the second one."""
    return f"A{2 + channel // ADC_CHANNELS}:CH{channel % ADC_CHANNELS}"


def amplifier_note(valve: ValvePart) -> str:
    """Return the gain of the amplifier between a PWM output and a valve, and its state without the board."""
    low, span = valve.centre_voltage - valve.volts_to_full, 2.0 * valve.volts_to_full
    offset = f", {low:+g} V" if low else ""
    return f"filter 1 kHz, second order; gain {span / ADC_REFERENCE:.3g}{offset}; input pulled to its middle"


def _fed(signal: str, rail: Strip, terminal: str, note: str = "") -> WireRow:
    """Return a wire from a strip's terminal to a device."""
    return WireRow(
        signal, rail, terminal, COLOURS[rail], LOAD_AREA if rail in {Strip.V24, Strip.V0} else SIGNAL_AREA, note
    )


def _from_board(signal: str, gpio: int, terminal: str, colour: str, note: str = "") -> WireRow:
    """Return a wire of a GPIO of the board; `colour` is a key of `COLOURS`."""
    pin = f"pin {BOARD_PINS[gpio]}"
    return WireRow(signal, gpio_terminal(gpio), terminal, COLOURS[colour], note=f"{pin}; {note}" if note else pin)


def _power(machine: Machine) -> Iterator[WireRow]:
    """Yield the wires of the power supplies, and the cable to the host."""
    yield WireRow("24 V", "G1:+", Strip.V24, COLOURS[Strip.V24], LOAD_AREA)
    yield WireRow("0 V", "G1:-", Strip.V0, COLOURS[Strip.V0], LOAD_AREA)
    yield WireRow("protective earth", Strip.V0, Strip.PE, COLOURS[Strip.PE], EARTH_AREA)
    yield WireRow("common ground", Strip.V0, Strip.GND, COLOURS[Strip.GND], LOAD_AREA, "the only connection of both")
    yield WireRow("3.3 V", "A1:3V3", Strip.V3, COLOURS[Strip.V3], note="pin 36")
    yield WireRow("ground", "A1:GND", Strip.GND, COLOURS[Strip.GND], note="pin 38")
    yield WireRow("USB to the host, 5 V", "A1:USB", "host", "", None, "cable")
    if any(joint.regulator or joint.brake.calliper for joint in machine.joints.values()):
        yield WireRow("10 V", "G2:10V", Strip.V10, COLOURS[Strip.V10], note="reference, for set points that stay")


def _stop_and_air() -> Iterator[WireRow]:
    """Yield the wires of the e-stop's contacts, the dump valve and the service pin."""
    yield _fed("dump valve", Strip.V24, "0S2:11", "first contact: cuts the dump valve's current itself")
    yield WireRow("dump valve", "0S2:12", "0V3:+", COLOURS[Strip.V24], LOAD_AREA)
    yield WireRow("dump valve", "0V3:-", "0K1:OUT", COLOURS[Strip.V0], LOAD_AREA, DIODE_NOTE)
    yield _fed("dump valve", Strip.V0, "0K1:0V")
    yield _from_board("air in", AIR_GPIO, "0K1:IN", "output", PULL_DOWN)
    yield _fed("e-stop", Strip.V3, "0S2:21", "second contact, open is pressed")
    yield _from_board("e-stop", STOP_GPIO, "0S2:22", "contact")
    yield _from_board("service", SERVICE_GPIO, "0S3:1", "contact", "closed while it starts: no program")
    yield _fed("service", Strip.GND, "0S3:2")


def _converters(pins: BoardPins) -> Iterator[WireRow]:
    """Yield the wires of the converters' supply and bus."""
    supply, bus = ADC_TERMINALS[ADC_NAMES[pins.adc_bits]]
    for i, select in enumerate(pins.selects):
        tag = f"A{2 + i}"
        for signal, terminal, gpio, colour in zip(
            ("data out", "clock", "data in"), bus, ADC_GPIOS, ("data", "clock", "data"), strict=True
        ):
            yield _from_board(signal, gpio, f"{tag}:{terminal}", colour)
        yield _from_board(f"select {tag}", select, f"{tag}:CS", "select")
        for terminal, rail in supply.items():
            yield _fed(f"supply of {tag}", rail, f"{tag}:{terminal}")


def _transducer(tag: str, signal: str, channel: int, note: str) -> Iterator[WireRow]:
    """Yield the wires of a pressure transducer with an output of 0 to 3.3 V."""
    yield _fed(signal, Strip.V24, f"{tag}:+", "as the transducer needs")
    yield _fed(signal, Strip.V0, f"{tag}:-")
    yield WireRow(signal, f"{tag}:U", channel_terminal(channel), COLOURS["pressure"], note=note)


def _supply_sensor(machine: Machine, pins: BoardPins) -> Iterator[WireRow]:
    """Yield the wires of the transducer of the supply."""
    top = machine.interface.supply_range_gauge / 1e5
    yield from _transducer("0S1", "supply pressure", pins.supply, f"0 V at 0 bar, {ADC_REFERENCE:g} V at {top:g} bar")


def _sensors(machine: Machine, pins: BoardPins, j: int) -> Iterator[WireRow]:
    """Yield the wires of the sensors of joint j."""
    name, tag, half = list(machine.joints)[j], f"{j + 1}S2", 0.5 * valve_and_sensors(machine)[2].range / 1e5
    yield _fed(f"angle of {name}", Strip.V3, f"{tag}:3", "forward end")
    yield _fed(f"angle of {name}", Strip.GND, f"{tag}:1", "back end")
    yield WireRow(f"angle of {name}", f"{tag}:2", channel_terminal(pins.angles[j]), COLOURS["angle"], note="wiper")
    note = f"0 V at -{half:g} bar, {ADC_REFERENCE:g} V at {half:g} bar"
    yield from _transducer(f"{j + 1}S1", f"pressure of {name}", pins.pressures[j], note)


def _valves(machine: Machine, pins: BoardPins, j: int) -> Iterator[WireRow]:
    """Yield the wires of the valve, or pair of valves, of joint j, of its regulator and its calliper."""
    name, number, (valve, _, _) = list(machine.joints)[j], j + 1, valve_and_sensors(machine)
    signal, amplifier = f"valve of {name}", f"{number}K1"
    yield _from_board(signal, pins.valves[j], f"{amplifier}:IN", "valve", amplifier_note(valve))
    yield _fed(signal, Strip.V24, f"{amplifier}:24V")
    yield _fed(signal, Strip.V0, f"{amplifier}:0V")
    if valve.kind == "switching":
        for which in "ab":
            yield WireRow(signal, f"{amplifier}:{which}", f"{number}V1{which}:+", COLOURS["valve"], LOAD_AREA, "pulses")
            yield _fed(signal, Strip.V0, f"{number}V1{which}:-")
    else:
        yield WireRow(
            signal, f"{amplifier}:OUT", f"{number}V1:U", COLOURS["valve"], note="0 V of the amplifier beside it"
        )
        yield _fed(signal, Strip.V24, f"{number}V1:24V")
        yield _fed(signal, Strip.V0, f"{number}V1:0V")
    for part in joint_components(machine, number):
        if part.tag in {f"{number}V2", f"{number}V3"}:
            what = "regulator" if part.tag.endswith("V2") else "calliper"
            yield _fed(f"{what} of {name}", Strip.V10, f"{part.tag}:U", FIXED_NOTE)
            yield _fed(f"{what} of {name}", Strip.V24, f"{part.tag}:24V")
            yield _fed(f"{what} of {name}", Strip.V0, f"{part.tag}:0V")


def _outputs(machine: Machine, pins: BoardPins) -> Iterator[WireRow]:
    """Yield the wires of the digital outputs."""
    for i, (name, gpio) in enumerate(zip(machine.interface.outputs, pins.outputs, strict=True), start=1):
        driver, load = f"0K{i + 1}", f"0Y{i}"
        yield _from_board(name, gpio, f"{driver}:IN", "output", PULL_DOWN)
        yield _fed(name, Strip.V0, f"{driver}:0V")
        yield _fed(name, Strip.V24, f"{load}:+")
        yield WireRow(name, f"{load}:-", f"{driver}:OUT", COLOURS[Strip.V0], LOAD_AREA, DIODE_NOTE)


def wires_csv(machine: Machine) -> str:
    """Return the wiring table as CSV; errors as from `list_wires`."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for wire in list_wires(machine):
        area = "" if wire.area is None else f"{wire.area:g}"
        writer.writerow((wire.number, wire.signal, wire.origin, wire.end, wire.colour, area, wire.note))
    return text.getvalue()
