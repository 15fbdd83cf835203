"""Failures of a virtual rig that can be set and mended: one entry each.

A failure that goes on is there until it is healed. Several may be there at once, but for the link, which has one.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from typing import Any, NamedTuple

from layflat.errors import InputError
from layflat.rig.device.link import Spoil
from layflat.rig.device.virtual import ANGLE, PRESSURE, VirtualDevice


class Size(NamedTuple):
    """Size of a failure: its usual value, its unit, and the range that makes sense."""

    usual: float
    unit: str
    low: float
    high: float


@dataclass(frozen=True)
class Failure:
    """One thing that goes wrong."""

    name: str  # by which it is asked for
    what: str  # what it does, in a line
    put: Callable[[VirtualDevice, int, Any], None]  # puts a device's joint (where it is a joint's) into a state
    failed: Any = True  # state in which it is there; that of a failure with a size is the size
    sound: Any = None  # state in which it is mended
    size: Size | None = None  # None where it has none

    def begin(self, device: VirtualDevice, joint: int = 0, size: float | None = None) -> None:
        """Inject it at the present instant; raise InputError if there is no such joint, or the size makes no sense."""
        if self.size is None and size is not None:
            raise InputError(f"{size:g} was given", where=self.name, right="it has no size")
        state = self.failed
        if self.size is not None:
            usual, unit, low, high = self.size
            state = usual if size is None else size
            if not low <= state <= high:
                right = f"give {low:g} to {high:g}: {unit}"
                raise InputError(f"{size:g} is out of range", where=self.name, right=right)
        self._put(device, joint, state)

    def end(self, device: VirtualDevice, joint: int = 0) -> None:
        """Heal it at the present instant; raise InputError if there is no such joint."""
        self._put(device, joint, self.sound)

    def __str__(self) -> str:
        size = f" (SIZE: {self.size.unit}; default: {self.size.usual:g})" if self.size is not None else ""
        return f"{self.name}: {self.what}{size}"

    def _put(self, device: VirtualDevice, joint: int, state: Any) -> None:
        count = device.capabilities.joints
        if not 0 <= joint < count:
            raise InputError(f"has no joint {joint}", where="the rig", right=f"joints are 0 to {count - 1}")
        device.tick()
        self.put(device, joint, state)


def _spoilt(name: str, what: str, kind: Spoil) -> Failure:
    def put(device: VirtualDevice, _: int, replies: float | None) -> None:
        if replies is None:
            device.link.mend()
        else:
            device.link.spoil(kind, replies)

    return Failure(name, what, put, size=Size(inf, "replies", 0.0, inf))


def _silence(device: VirtualDevice, _: int, there: bool | None) -> None:
    device.link.mend()
    device.link.silent = bool(there)


def _sensed(name: str, what: str, rail: int | None, *sensors: int) -> Failure:
    """A failure of converters, which report an end of their range from now on, or repeat their next sample."""

    def put(device: VirtualDevice, joint: int, there: bool | None) -> None:
        for sensor in sensors:
            if there:
                device.converters.fail(joint, sensor, rail)
            else:
                device.converters.mend(joint, sensor)

    return Failure(name, what, put)


def _regulate(device: VirtualDevice, _: int, share: float) -> None:
    device.line.regulator = device.line.ambient + share * device.set_gauge


def _press(device: VirtualDevice, _: int, there: bool | None) -> None:
    device.stopped = bool(there)


def _burst(device: VirtualDevice, joint: int, hose: float | None) -> None:
    device.plant.burst(joint, None if hose is None else int(hose))


def _push(device: VirtualDevice, joint: int, share: float) -> None:
    device.plant.load[joint] = share * device.strengths[joint]


OPENING = Size(0.3, "opening of the valve", -1.0, 1.0)
HOSE = Size(0.0, "0 is hose A, 1 is hose B", 0.0, 1.0)
PASSED = Size(0.001, "share of what passed", 0.0, 1.0)
GAUGE = Size(1.5, "share of the set gauge pressure", 0.0, 3.0)
HELD, PUSHED = (Size(1.5, "share of its greatest torque", low, high) for low, high in ((0.0, 10.0), (-3.0, 3.0)))

ALL = (
    _spoilt("reply-lost", "commands are obeyed, replies do not come", Spoil.LOST),
    _spoilt("reply-crc", "replies come with a wrong checksum", Spoil.CRC),
    _spoilt("reply-sequence", "replies come with the number of another command", Spoil.SEQUENCE),
    _spoilt("reply-late", "replies come after the time limit", Spoil.LATE),
    Failure("silence", "the wire is cut: nothing is heard, nothing is answered", _silence),
    _sensed("angle-open", "the angle sensor reads the low end", 0, ANGLE),
    _sensed("angle-shorted", "the angle sensor reads the high end", 1, ANGLE),
    _sensed("angle-frozen", "the angle repeats one reading", None, ANGLE),
    _sensed("pressure-open", "the pressure sensor reads the low end", 0, PRESSURE),
    _sensed("pressure-frozen", "the pressure repeats one reading", None, PRESSURE),
    _sensed("converter-frozen", "angle and pressure repeat one reading", None, ANGLE, PRESSURE),
    Failure("stuck-spool", "the joint's valve stays at an opening", lambda d, j, x: d.plant.seize(j, x), size=OPENING),
    Failure("burst-hose", "a hose of the joint loses its air", _burst, size=HOSE),
    Failure(
        "kinked-hose", "next to no air passes between the joint and its valve", lambda d, j, x: d.plant.kink(j, x),
        sound=1.0, size=PASSED,
    ),
    Failure("supply-lost", "the compressor is gone", _regulate, failed=0.0, sound=1.0),
    Failure("supply-high", "the regulator gives too much", _regulate, sound=1.0, size=GAUGE),
    Failure("e-stop", "the e-stop is pressed; healed, it is released", _press),
    Failure(
        "grip", "somebody holds the joint where it is", lambda d, j, x: d.plant.grip(j, x * d.strengths[j]),
        sound=0.0, size=HELD,
    ),
    Failure("push", "somebody turns the joint", _push, sound=0.0, size=PUSHED),
)  # fmt: skip

FAILURES = {failure.name: failure for failure in ALL}


def failure(name: str) -> Failure:
    """The failure of a name; raise InputError if there is none of that name."""
    if name not in FAILURES:
        raise InputError(f"{name!r} is not a failure", where="failure", right=f"failures are {', '.join(FAILURES)}")
    return FAILURES[name]
