"""Settings of paper-arm's device, which have to agree with its file: the host checks them."""

JOINTS = 2  # large, small

VOLTAGE_BITS = 16
ANGLE_BITS = 12
PRESSURE_BITS = 12
SUPPLY_BITS = 12

VOLTAGE_LOW = 0  # mV, of the valves' drivers
VOLTAGE_HIGH = 10000
CENTRE_VOLTAGE = 5000  # where the valves are closed

CENTRES_AFTER = 20000  # us without a command: interface.watchdog_cycles times controller.cycle
DUMPS_AFTER = 200000  # us without a command: interface.dump_after
EMPTIES_AFTER = 300000  # us: from dumping until the valves open; enclosed air brakes joints
LETS_DOWN = False  # True: they stay centred and dither: the arm sinks, and does not fall
SHORTEST_CYCLE = 4000  # us, with room to spare on a Pico

DITHER_AMPLITUDE = 0.204  # fraction of full opening: valve.dither
DITHER_PERIOD = 20000  # us

# Pins of a Raspberry Pi Pico, by GPIO number.
VALVE_PINS = (2, 4)  # PWM, through a filter and an amplifier
AIR_PIN = 6  # high: the dump valve lets air in
OUTPUT_PINS = ()  # one for each of interface.outputs; off where the device has dumped
STOP_PIN = 7  # high: the e-stop's loop is closed
SERVICE_PIN = 8  # to ground while it starts: the program does not run
ADC_BITS = 12  # MCP3208
ADC_PINS = (16, 18, 19)  # MCP3208: data out, clock, data in
ADC_SELECTS = (17,)  # one a converter: channels 0 to 7 are the first one's, 8 to 15 the second one's
ANGLE_CHANNELS = (0, 1)
PRESSURE_CHANNELS = (2, 3)
SUPPLY_CHANNEL = 4
