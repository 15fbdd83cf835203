"""Pins and converters of a Raspberry Pi Pico that runs `firmware/`: which one serves which signal of a machine.

Valves have PWM outputs of a slice and channel each. Converters are on bus SPI0, which has these pins. The first two
joints have the pins of `firmware/README.md`.
"""

from typing import NamedTuple, Self

from layflat.errors import MachineError
from layflat.machine import Machine
from layflat.machine.parameters import valve_and_sensors

VALVE_GPIOS = 2, 4, 10, 12, 14, 0, 3  # in the order of the joints
OUTPUT_GPIOS = 20, 21, 22, 26, 27, 28, 9, 11  # in the order of the outputs
AIR_GPIO, STOP_GPIO, SERVICE_GPIO = 6, 7, 8
ADC_GPIOS = 16, 18, 19  # data out, clock, data in
SELECT_GPIOS = 17, 15  # in the order of the converters
ADC_CHANNELS = 8  # of a converter
ADC_NAMES = {12: "MCP3208", 16: "ADS8344"}  # converters that the firmware can read, by their bits
ADC_REFERENCE = 3.3  # full scale of the converters and of a PWM output, V
BOARD_PINS = {
    0: 1, 1: 2, 2: 4, 3: 5, 4: 6, 5: 7, 6: 9, 7: 10, 8: 11, 9: 12, 10: 14, 11: 15, 12: 16, 13: 17, 14: 19, 15: 20,
    16: 21, 17: 22, 18: 24, 19: 25, 20: 26, 21: 27, 22: 29, 26: 31, 27: 32, 28: 34,
}  # fmt: skip
"""Pins of the board by GPIO."""


class BoardPins(NamedTuple):
    """Pins of the board, by GPIO, and channels of the converters for a machine."""

    valves: tuple[int, ...]  # one a joint
    outputs: tuple[int, ...]  # one a digital output
    selects: tuple[int, ...]  # one a converter
    adc_bits: int  # of each converter
    angles: tuple[int, ...]  # channels, one a joint; 8 and more are the second converter's
    pressures: tuple[int, ...]
    supply: int

    @classmethod
    def for_machine(cls, machine: Machine) -> Self:
        """Return the pins for a machine.

        Raises:
            MachineError: no valve or sensors, more joints than pins, or a sensor of more bits than a converter.
        """
        n, (_, angle, pressure) = len(machine.joints), valve_and_sensors(machine)
        if n > len(VALVE_GPIOS):
            right = f"the firmware has pins for up to {len(VALVE_GPIOS)}; split the arm between two boards"
            raise MachineError(f"has {n} joints", where=f"{machine.origin}: arm.joints", right=right)
        described = {
            "angle_sensor.bits": angle.bits,
            "pressure_sensor.bits": pressure.bits,
            "interface.supply_bits": machine.interface.supply_bits,
        }
        key, bits = max(described.items(), key=lambda item: item[1])
        fitting = [each for each in ADC_NAMES if each >= bits]
        if not fitting:
            right = f"the firmware's converters have up to {max(ADC_NAMES)}"
            raise MachineError(f"is {bits}", where=f"{machine.origin}: {key}", right=right)
        outputs = OUTPUT_GPIOS[: len(machine.interface.outputs)]
        converters = 1 if 2 * n < ADC_CHANNELS else 2
        angles, pressures = tuple(range(n)), tuple(range(n, 2 * n))
        return cls(VALVE_GPIOS[:n], outputs, SELECT_GPIOS[:converters], min(fitting), angles, pressures, 2 * n)
