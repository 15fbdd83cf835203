"""Pins of a Raspberry Pi Pico: PWM to the valves, MCP3208 converters, dump valve, e-stop, USB."""

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
        self._asked, self._told = bytearray(3), bytearray(3)
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
        return self._count(self._settings.ANGLE_CHANNELS[joint])

    def pressure(self, joint):
        return self._count(self._settings.PRESSURE_CHANNELS[joint])

    def supply(self):
        return self._count(self._settings.SUPPLY_CHANNEL)

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

    def _count(self, channel):
        chosen, channel = self._chosen[channel >> 3], channel & 7
        self._asked[0], self._asked[1] = 6 | channel >> 2, (channel & 3) << 6
        chosen.value(0)
        self._adc.write_readinto(self._asked, self._told)
        chosen.value(1)
        return (self._told[1] & 15) << 8 | self._told[2]
