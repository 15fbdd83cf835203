"""Settings of the firmware in MicroPython for a machine: `settings.py` of `firmware/`."""

from layflat.errors import MachineError
from layflat.machine import Machine
from layflat.machine.parameters import valve_and_sensors
from layflat.rig.abilities import falls_without_air
from layflat.rig.device.virtual import LINE_EMPTY_TIME
from layflat.rig.driver import Capabilities
from layflat.rig.wire import Identity
from layflat.solids.documents.pins import ADC_GPIOS, ADC_NAMES, AIR_GPIO, SERVICE_GPIO, STOP_GPIO, BoardPins

SHORTEST_CYCLE = 4000  # control cycle that the firmware keeps up with, us
MIN_DITHER_PERIOD = 32  # us; the firmware has as many steps of a period
DITHERLESS_PERIOD = 20000  # of a device without dither, us


def firmware_settings(machine: Machine) -> str:
    """Return the text of the firmware's `settings.py` for a machine.

    Raises:
        MachineError: no valve, sensors or controller, or it does not fit the wire, the pins or the converters.
        DriverError: its control cycle is shorter than the firmware's.
    """
    able = Capabilities.required_by(machine)._replace(shortest_cycle=1e-6 * SHORTEST_CYCLE)
    one, pins = Identity.for_machine(machine, able), BoardPins.for_machine(machine)
    one.check(machine, f"{machine.origin}: controller.cycle")
    amplitude, period = _dither(machine)
    outputs = ", ".join(machine.interface.outputs) or "one for each of interface.outputs"
    converter = ADC_NAMES[pins.adc_bits]
    return f'''"""Settings of {machine.name}'s device, which have to agree with its file: the host checks them."""

JOINTS = {one.joints}  # {", ".join(machine.joints)}

VOLTAGE_BITS = {one.voltage_bits}
ANGLE_BITS = {one.angle_bits}
PRESSURE_BITS = {one.pressure_bits}
SUPPLY_BITS = {one.supply_bits}

VOLTAGE_LOW = {one.voltage_low}  # mV, of the valves' drivers
VOLTAGE_HIGH = {one.voltage_high}
CENTRE_VOLTAGE = {one.centre_voltage}  # where the valves are closed

CENTRES_AFTER = {1000 * one.centres_after}  # us without a command: interface.watchdog_cycles times controller.cycle
DUMPS_AFTER = {1000 * one.dumps_after}  # us without a command: interface.dump_after
EMPTIES_AFTER = {LINE_EMPTY_TIME // 1000}  # us: from dumping until the valves open; enclosed air brakes joints
LETS_DOWN = {falls_without_air(machine)}  # True: they stay centred and dither: the arm sinks, and does not fall
SHORTEST_CYCLE = {one.shortest_cycle}  # us, with room to spare on a Pico

DITHER_AMPLITUDE = {amplitude!r}  # fraction of full opening: valve.dither
DITHER_PERIOD = {period}  # us

# Pins of a Raspberry Pi Pico, by GPIO number.
VALVE_PINS = {pins.valves}  # PWM, through a filter and an amplifier
AIR_PIN = {AIR_GPIO}  # high: the dump valve lets air in
OUTPUT_PINS = {pins.outputs}  # {outputs}; off where the device has dumped
STOP_PIN = {STOP_GPIO}  # high: the e-stop's loop is closed
SERVICE_PIN = {SERVICE_GPIO}  # to ground while it starts: the program does not run
ADC_BITS = {pins.adc_bits}  # {converter}
ADC_PINS = {ADC_GPIOS}  # {converter}: data out, clock, data in
ADC_SELECTS = {pins.selects}  # one a converter: channels 0 to 7 are the first one's, 8 to 15 the second one's
ANGLE_CHANNELS = {pins.angles}
PRESSURE_CHANNELS = {pins.pressures}
SUPPLY_CHANNEL = {pins.supply}
'''


def _dither(machine: Machine) -> tuple[float, int]:
    """Return amplitude, as a fraction of full opening, and period, us, of the dither; 0.0 for a valve without."""
    dither = valve_and_sensors(machine)[0].dithered
    if dither is None:
        return 0.0, DITHERLESS_PERIOD
    period = round(1e6 / dither.frequency)
    if period < MIN_DITHER_PERIOD:
        what, right = f"is {dither.frequency:g} Hz", f"the firmware adds up to {1e6 / MIN_DITHER_PERIOD:g} Hz"
        raise MachineError(what, where=f"{machine.origin}: valve.dither.frequency", right=right)
    return dither.amplitude, period
