"""Pins of a Raspberry Pi Pico: PWM to the valves, MCP3208 or ADS8344 converters, dump valve, e-stop, USB."""

import sys
import time

import machine
import micropython
import select

PWM_FREQUENCY = 20000
WATCHDOG = 100  # ms


class PicoIO:
    """Input and output as `station.Station` wants it."""

    def __init__(self, settings):
        self._adc_bits = getattr(settings, "ADC_BITS", 12)
        if self._adc_bits not in (12, 16):
            raise ValueError(f"ADC_BITS is {self._adc_bits}; it is 12 (MCP3208) or 16 (ADS8344)")
        bits = max(settings.ANGLE_BITS, settings.PRESSURE_BITS, settings.SUPPLY_BITS)
        if bits > self._adc_bits:
            raise ValueError(f"a sensor of {bits} bits; its converter has {self._adc_bits}")
        out, clock, into = settings.ADC_PINS
        self._settings = settings
        self._air = machine.Pin(settings.AIR_PIN, machine.Pin.OUT, value=0)
        self._stop = machine.Pin(settings.STOP_PIN, machine.Pin.IN, machine.Pin.PULL_DOWN)
        self._outputs = [machine.Pin(pin, machine.Pin.OUT, value=0) for pin in settings.OUTPUT_PINS]
        self._valves = [machine.PWM(machine.Pin(pin), freq=PWM_FREQUENCY, duty_u16=0) for pin in settings.VALVE_PINS]
        self._shift = 16 - settings.VOLTAGE_BITS
        self._chosen = [machine.Pin(pin, machine.Pin.OUT, value=1) for pin in settings.ADC_SELECTS]
        self._adc = machine.SPI(
            0, baudrate=1000000, sck=machine.Pin(clock), mosi=machine.Pin(into), miso=machine.Pin(out)
        )
        self._asked, self._told = bytearray(4), bytearray(4)
        self._poll = select.poll()
        self._poll.register(sys.stdin, select.POLLIN)
        micropython.kbd_intr(-1)  # a 3 in a frame is not a Ctrl-C
        self._watchdog = machine.WDT(timeout=WATCHDOG)

    def ticks(self):
        return time.ticks_us()

    def elapsed(self, then):
        return time.ticks_diff(time.ticks_us(), then)

    def received(self):
        data = bytearray()
        while self._poll.poll(0):
            data.extend(sys.stdin.buffer.read(1))
        return bytes(data)

    def send(self, data):
        sys.stdout.buffer.write(data)

    def stopped(self):
        return not self._stop.value()

    def angle(self, joint):
        return self._count(self._settings.ANGLE_CHANNELS[joint], self._settings.ANGLE_BITS)

    def pressure(self, joint):
        return self._count(self._settings.PRESSURE_CHANNELS[joint], self._settings.PRESSURE_BITS)

    def supply(self):
        return self._count(self._settings.SUPPLY_CHANNEL, self._settings.SUPPLY_BITS)

    def drive(self, counts):
        for valve, count in zip(self._valves, counts):
            valve.duty_u16(count << self._shift)

    def air(self, on):
        self._air.value(on)

    def switch(self, outputs):
        for bit, pin in enumerate(self._outputs):
            pin.value(outputs >> bit & 1)

    def alive(self):
        self._watchdog.feed()

    def _count(self, channel, bits):
        """Return a channel's count in so many bits; the ADS8344 takes the bits of a channel in the order 0, 2, 1."""
        chosen, channel, told = self._chosen[channel >> 3], channel & 7, self._told
        wide = self._adc_bits == 16
        if wide:
            self._asked[0], self._asked[1] = 0x87 | (channel & 1) << 6 | (channel >> 1) << 4, 0
        else:
            self._asked[0], self._asked[1] = 6 | channel >> 2, (channel & 3) << 6
        chosen.value(0)
        self._adc.write_readinto(self._asked, told)
        chosen.value(1)
        count = (told[1] << 9 | told[2] << 1 | told[3] >> 7) & 0xFFFF if wide else (told[1] & 15) << 8 | told[2]
        return count >> self._adc_bits - bits
