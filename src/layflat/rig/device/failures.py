"""What a virtual rig can be told to fail, and to mend again: one entry a failure.

A failure that goes on is there until it is healed. Several may be there at once, but for the link, which has one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf

from layflat.errors import InputError
from layflat.rig.device.link import Spoil
from layflat.rig.device.sensors import ANGLE, PRESSURE
from layflat.rig.device.virtual import VirtualDevice


@dataclass(frozen=True)
class Failure:
    """One thing that goes wrong.

    Args:
        name: by which it is asked for.
        what: what it does, in a line.
        inject: makes it happen now, to a joint (where it is a joint's), of a size.
        heal: mends it now.
        size: usual size; None where it has none.
        unit: what the size counts.
        limits: between which a size makes sense.
    """

    name: str
    what: str
    inject: Callable[[VirtualDevice, int, float], None]
    heal: Callable[[VirtualDevice, int], None]
    size: float | None = None
    unit: str = ""
    limits: tuple[float, float] = (0.0, inf)

    def begin(self, device: VirtualDevice, joint: int = 0, size: float | None = None) -> None:
        """Inject it at the present instant of the device's clock.

        Raises:
            InputError: there is no such joint, or a size that makes no sense.
        """
        _check_joint(device, joint)
        size = self._sized(size)
        device.tick()
        self.inject(device, joint, size)

    def end(self, device: VirtualDevice, joint: int = 0) -> None:
        """Heal it at the present instant of the device's clock.

        Raises:
            InputError: there is no such joint.
        """
        _check_joint(device, joint)
        device.tick()
        self.heal(device, joint)

    def _sized(self, size: float | None) -> float:
        if size is None:
            return self.size or 0.0
        if self.size is None:
            raise InputError(f"{size:g} was given", where=self.name, right="it has no size")
        low, high = self.limits
        if not low <= size <= high:
            raise InputError(
                f"{size:g} is out of range", where=self.name, right=f"give {low:g} to {high:g}: {self.unit}"
            )
        return size


def _check_joint(device: VirtualDevice, joint: int) -> None:
    count = device.capabilities.joints
    if not 0 <= joint < count:
        raise InputError(f"there is no joint {joint}", where="failure", right=f"joints are 0 to {count - 1}")


def _spoilt(name: str, what: str, kind: Spoil) -> Failure:
    def inject(device: VirtualDevice, _: int, replies: float) -> None:
        device.link.spoil(kind, replies)

    return Failure(name, what, inject, lambda device, _: device.link.mend(), inf, "replies")


def _sensed(name: str, what: str, fail: Callable[[VirtualDevice, int], None], *sensors: int) -> Failure:
    def heal(device: VirtualDevice, joint: int) -> None:
        for sensor in sensors:
            device.converters.mend(joint, sensor)

    return Failure(name, what, lambda device, joint, _: fail(device, joint), heal)


def _silence(device: VirtualDevice, _joint: int, _size: float) -> None:
    device.link.silent = True


def _freeze_both(device: VirtualDevice, joint: int) -> None:
    device.converters.freeze(joint, ANGLE)
    device.converters.freeze(joint, PRESSURE)


def _regulate(device: VirtualDevice, share: float) -> None:
    device.line.regulator = device.line.ambient + share * device.set_gauge


def _press(device: VirtualDevice, *, pressed: bool) -> None:
    device.stopped = pressed


def _push(device: VirtualDevice, joint: int, share: float) -> None:
    device.plant.load[joint] = share * device.strengths[joint]


ALL = (
    _spoilt("reply-lost", "commands are obeyed, replies do not come", Spoil.LOST),
    _spoilt("reply-crc", "replies come with a wrong checksum", Spoil.CRC),
    _spoilt("reply-sequence", "replies come with the number of another command", Spoil.SEQUENCE),
    _spoilt("reply-late", "replies come after the time limit", Spoil.LATE),
    Failure("silence", "the wire is cut: nothing is heard, nothing is answered", _silence, lambda d, _: d.link.mend()),
    _sensed("angle-open", "the angle sensor reads the low end", lambda d, j: d.converters.fix_low(j, ANGLE), ANGLE),
    _sensed(
        "angle-shorted", "the angle sensor reads the high end", lambda d, j: d.converters.fix_high(j, ANGLE), ANGLE
    ),
    _sensed("angle-frozen", "the angle repeats one reading", lambda d, j: d.converters.freeze(j, ANGLE), ANGLE),
    _sensed(
        "pressure-open",
        "the pressure sensor reads the low end",
        lambda d, j: d.converters.fix_low(j, PRESSURE),
        PRESSURE,
    ),
    _sensed(
        "pressure-frozen",
        "the pressure repeats one reading",
        lambda d, j: d.converters.freeze(j, PRESSURE),
        PRESSURE,
    ),
    _sensed("converter-frozen", "angle and pressure repeat one reading", _freeze_both, ANGLE, PRESSURE),
    Failure(
        "stuck-spool",
        "the joint's valve stays at an opening",
        lambda d, j, opening: d.plant.seize(j, opening),
        lambda d, j: d.plant.seize(j, None),
        0.3,
        "opening of the valve",
        (-1.0, 1.0),
    ),
    Failure(
        "burst-hose",
        "a hose of the joint loses its air",
        lambda d, j, hose: d.plant.burst(j, int(hose)),
        lambda d, j: d.plant.burst(j, None),
        0.0,
        "0 is hose A, 1 is hose B",
        (0.0, 1.0),
    ),
    Failure(
        "kinked-hose",
        "next to no air passes between the joint and its valve",
        lambda d, j, share: d.plant.kink(j, share),
        lambda d, j: d.plant.kink(j, 1.0),
        0.001,
        "share of what passed",
        (0.0, 1.0),
    ),
    Failure(
        "supply-lost", "the compressor is gone", lambda d, _, __: _regulate(d, 0.0), lambda d, _: _regulate(d, 1.0)
    ),
    Failure(
        "supply-high",
        "the regulator gives too much",
        lambda d, _, share: _regulate(d, share),
        lambda d, _: _regulate(d, 1.0),
        1.5,
        "share of the set gauge pressure",
        (0.0, 3.0),
    ),
    Failure(
        "e-stop",
        "the e-stop is pressed; healed, it is released",
        lambda d, _, __: _press(d, pressed=True),
        lambda d, _: _press(d, pressed=False),
    ),
    Failure(
        "grip",
        "somebody holds the joint where it is",
        lambda d, j, share: d.plant.grip(j, share * d.strengths[j]),
        lambda d, j: d.plant.grip(j, 0.0),
        1.5,
        "share of its greatest torque",
        (0.0, 10.0),
    ),
    Failure(
        "push",
        "somebody turns the joint",
        _push,
        lambda d, j: _push(d, j, 0.0),
        1.5,
        "share of its greatest torque",
        (-3.0, 3.0),
    ),
)

FAILURES = {failure.name: failure for failure in ALL}


def failure(name: str) -> Failure:
    """The failure of a name.

    Raises:
        InputError: there is none of that name.
    """
    if name not in FAILURES:
        raise InputError(f"{name!r} is no failure", where="failure", right=f"failures are {', '.join(FAILURES)}")
    return FAILURES[name]
