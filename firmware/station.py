"""What the microcontroller does, without knowing its pins: it obeys, answers, dithers, and is safe when nobody speaks.

All of its input and output is an object with

    ticks()         microseconds, which may go round
    elapsed(then)   microseconds since then
    received()      bytes that have come, or b""
    send(data)
    stopped()       whether the e-stop is pressed: its loop is open
    angle(joint), pressure(joint), supply()     counts
    drive(counts)   of the voltages to the valves
    air(on)         whether the dump valve lets air in
    switch(outputs) which digital outputs are on, as bits
    alive()         tells the hardware's watchdog so
"""

import struct
from math import pi, sin

from frames import IDENTIFY, COMMAND, READING, IDENTITY, Decoder, encode, whole

RUNNING, CENTRED, DUMPED = 0, 1, 2
STOPPED = 4
AIR, RESET = 1, 2
OUTPUTS = 8
"""Where the bits of the digital outputs begin in a command's flags, and their number in an identity's."""
MAGIC, VERSION, DITHERS, LETS_DOWN = 0x4C46, 1, 1, 2
STEPS = 32
"""Of the dither's sine."""


MAX_JOINTS = 7
RANGES = (
    ("JOINTS", 1, MAX_JOINTS),
    ("VOLTAGE_BITS", 8, 16),
    ("ANGLE_BITS", 4, 24),
    ("PRESSURE_BITS", 4, 24),
    ("SUPPLY_BITS", 4, 16),
    ("VOLTAGE_LOW", -32000, 32000),
    ("VOLTAGE_HIGH", -32000, 32000),
    ("SHORTEST_CYCLE", 1, 0xFFFF),
    ("CENTRES_AFTER", 1000, 65535999),
    ("DUMPS_AFTER", 1000, 65535999),
    ("EMPTIES_AFTER", 0, 65535999),
    ("DITHER_PERIOD", STEPS, 65535999),
)
"""Settings that are whole numbers, with their ranges: what a word of the identity carries, and what ticks can tell."""


def check(settings):
    """Raise ValueError if a setting can't be, or does not fit into the word that tells it to the host."""
    for name, low, high in RANGES:
        whole(getattr(settings, name), low, high, name)
    whole(settings.VOLTAGE_HIGH - settings.VOLTAGE_LOW, 1, 64000, "VOLTAGE_HIGH less VOLTAGE_LOW")
    whole(settings.CENTRE_VOLTAGE, settings.VOLTAGE_LOW, settings.VOLTAGE_HIGH, "CENTRE_VOLTAGE")
    whole(len(settings.OUTPUT_PINS), 0, 8, "number of OUTPUT_PINS")
    if not 0 <= settings.DITHER_AMPLITUDE <= 1:
        raise ValueError(f"DITHER_AMPLITUDE is {settings.DITHER_AMPLITUDE}; it goes from 0 to 1")


class Station:
    """A rig's device; call `step` again and again."""

    def __init__(self, io, settings):
        check(settings)
        self.io = io
        self.settings = settings
        counts = 1 << settings.VOLTAGE_BITS
        span = settings.VOLTAGE_HIGH - settings.VOLTAGE_LOW
        self.top = counts - 1
        self.centre = (settings.CENTRE_VOLTAGE - settings.VOLTAGE_LOW) * counts // span
        amplitude = settings.DITHER_AMPLITUDE * counts / 2
        self.wave = [round(amplitude * sin(2 * pi * i / STEPS)) for i in range(STEPS)]
        self.outputs = len(settings.OUTPUT_PINS)
        self.decoder = Decoder()
        self.last = None
        self.heard = io.ticks()
        self.reset = True  # low has to be seen before it rises
        self.counts = [self.centre] * settings.JOINTS
        self.state = RUNNING
        self.dump()

    def step(self):
        """Look at everything once."""
        if self.io.stopped():
            self.dump()
        data = self.io.received()
        if data:
            for kind, sequence, payload in self.decoder.feed(data):
                self.answer(kind, sequence, payload)
        self.watch()
        self.output()
        self.io.alive()

    def answer(self, kind, sequence, payload):
        """Reply to a frame; what is old, or none of the host's, is passed over."""
        if kind == IDENTIFY:
            self.last = None
            self.io.send(encode(IDENTITY, sequence, self.identity()))
        elif kind == COMMAND and self.obey(sequence, payload):
            self.output()
            self.io.send(encode(READING, sequence, self.reading()))

    def obey(self, sequence, payload):
        """Take a command; whether it was a new one."""
        if len(payload) != 2 + 2 * self.settings.JOINTS:
            return False
        words = struct.unpack(">" + str(1 + self.settings.JOINTS) + "H", payload)
        outputs = words[0] >> OUTPUTS
        if words[0] & ~(AIR | RESET) & 0xFF or outputs >> self.outputs or max(words[1:]) > self.top:
            return False
        if self.last is not None and not 0 < (sequence - self.last) & 0xFFFF < 0x8000:
            return False
        self.last, self.heard = sequence, self.io.ticks()
        edge = words[0] & RESET and not self.reset
        self.reset = bool(words[0] & RESET)
        if self.state == CENTRED or (self.state == DUMPED and edge and not self.io.stopped()):
            self.state = RUNNING
        if self.state == RUNNING:
            self.counts = list(words[1:])
            self.io.air(bool(words[0] & AIR))
            self.io.switch(outputs)
        return True

    def watch(self):
        """Be safe if nobody has spoken for some time."""
        silence = self.io.elapsed(self.heard)
        if silence >= self.settings.DUMPS_AFTER:
            self.dump()
        elif silence >= self.settings.CENTRES_AFTER and self.state == RUNNING:
            self.state = CENTRED
            self.counts = [self.centre] * self.settings.JOINTS

    def dump(self):
        """Vent the air: first that of the supply's line, with the valves centred, then that of the hoses.

        Hoses A let go through the line, hoses B through the valves' exhaust. Of an arm that would fall the valves stay
        centred, with dither, so that it is let down slowly.
        """
        if self.state != DUMPED:
            self.state, self.dumped, self.opened = DUMPED, self.io.ticks(), False
            self.counts = [self.centre] * self.settings.JOINTS
        self.io.air(False)
        self.io.switch(0)

    def output(self):
        """Drive the valves, with the dither unless they are opened to vent the hoses."""
        if self.state == DUMPED and not self.settings.LETS_DOWN:
            if not self.opened and self.io.elapsed(self.dumped) >= self.settings.EMPTIES_AFTER:
                self.opened = True
                self.counts = [self.top] * self.settings.JOINTS
            self.io.drive(self.counts)
            return
        period = self.settings.DITHER_PERIOD
        dither = self.wave[self.io.ticks() % period * STEPS // period]
        self.io.drive([min(max(count + dither, 0), self.top) for count in self.counts])

    def reading(self):
        """The payload of a reading; a converter of 16 bits or more takes two words."""
        settings, io = self.settings, self.io
        out = struct.pack(">H", self.state | (STOPPED if io.stopped() else 0))
        out += packed(io.supply(), settings.SUPPLY_BITS)
        for joint in range(settings.JOINTS):
            out += packed(io.angle(joint), settings.ANGLE_BITS) + packed(io.pressure(joint), settings.PRESSURE_BITS)
        return out

    def identity(self):
        """The payload that says what rig this is."""
        s = self.settings
        words = (MAGIC, VERSION, s.JOINTS, s.VOLTAGE_BITS, s.ANGLE_BITS, s.PRESSURE_BITS, s.SUPPLY_BITS)
        volts = (s.VOLTAGE_LOW & 0xFFFF, s.VOLTAGE_HIGH & 0xFFFF, s.CENTRE_VOLTAGE & 0xFFFF)
        flags = (DITHERS if s.DITHER_AMPLITUDE else 0) | (LETS_DOWN if s.LETS_DOWN else 0)
        flags |= self.outputs << OUTPUTS
        times = (s.SHORTEST_CYCLE, s.CENTRES_AFTER // 1000, s.DUMPS_AFTER // 1000)
        return struct.pack(">14H", *(words + volts + (flags,) + times))


def packed(count, bits):
    """Return a converter's count as bytes; one beyond its ends is the nearer end, which the host takes for a rail."""
    return struct.pack(">I" if bits >= 16 else ">H", min(max(count, 0), 1 << bits))
