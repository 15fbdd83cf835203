"""Failures of a virtual rig that can be injected and healed: one entry each.

A failure lasts until it is healed. Several may be present at once, except of the link, which has one at a time.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import inf
from typing import Any, NamedTuple

from layflat.errors import InputError
from layflat.rig.device.virtual import ANGLE, PRESSURE, ReplyFault, VirtualDevice

LINE_HELP = "fail NAME [JOINT] [SIZE], heal NAME [JOINT], state, failures or quit"


class FailureSize(NamedTuple):
    """Size of a failure: its usual value, its unit, and the range that makes sense."""

    usual: float
    unit: str
    low: float
    high: float


@dataclass(frozen=True)
class Failure:
    """Failure that can be injected and healed."""

    name: str  # in commands
    what: str  # effect, in a line
    apply: Callable[[VirtualDevice, int, Any], None]  # sets a state of a device, or of its joint of this number
    failed: Any = True  # state in which it is present; for a failure with a size this is the size
    healthy: Any = None  # state in which it is healed
    size: FailureSize | None = None  # None where it has none

    def inject(self, device: VirtualDevice, joint: int = 0, size: float | None = None) -> None:
        """Inject the failure at the present instant.

        Args:
            device: the device.
            joint: number of the joint, from 0; it must exist also where the failure is not a joint's.
            size: size in the unit of the failure's size; default: the usual one.

        Raises:
            InputError: there is no such joint, the failure has no size, or the size is out of range.
        """
        if self.size is None and size is not None:
            raise InputError(f"{size:g} was given", where=self.name, right="it has no size: leave it out")
        state = self.failed
        if self.size is not None:
            usual, unit, low, high = self.size
            state = usual if size is None else size
            if not low <= state <= high:
                right = f"give {low:g} to {high:g}: {unit}"
                raise InputError(f"{size:g} is out of range", where=self.name, right=right)
        self._set_state(device, joint, state)

    def heal(self, device: VirtualDevice, joint: int = 0) -> None:
        """Heal the failure now, of a joint by its number from 0; raise InputError if there is no such joint."""
        self._set_state(device, joint, self.healthy)

    def __str__(self) -> str:
        size = f" (SIZE: {self.size.unit}; default: {self.size.usual:g})" if self.size is not None else ""
        return f"{self.name}: {self.what}{size}"

    def _set_state(self, device: VirtualDevice, joint: int, state: Any) -> None:
        """Apply `failed`, a size or `healthy` to a joint, once the device's clock has caught up.

        Raise InputError if there is no such joint.
        """
        count = device.capabilities.joints
        if not 0 <= joint < count:
            raise InputError(f"has no joint {joint}", where="the rig", right=f"joints are 0 to {count - 1}")
        device.tick()
        self.apply(device, joint, state)


def _reply_failure(name: str, what: str, kind: ReplyFault) -> Failure:
    """Return a failure of the link that spoils a number of replies, by default all until it is healed."""

    def apply(device: VirtualDevice, _: int, replies: float | None) -> None:
        if replies is None:
            device.link.mend()
        else:
            device.link.spoil(kind, replies)

    return Failure(name, what, apply, size=FailureSize(inf, "replies", 0.0, inf))


def _set_silence(device: VirtualDevice, _: int, there: bool | None) -> None:
    """Cut the wire, or (None) mend it; either clears faults of replies."""
    device.link.mend()
    device.link.silent = bool(there)


def _sensor_failure(name: str, what: str, rail: int | None, *sensors: int) -> Failure:
    """Return a failure of converters that report an end of their range (0, 1), or repeat their next sample (None)."""

    def apply(device: VirtualDevice, joint: int, there: bool | None) -> None:
        for sensor in sensors:
            if there:
                device.converters.fail(joint, sensor, rail)
            else:
                device.converters.mend(joint, sensor)

    return Failure(name, what, apply)


def _set_regulator(device: VirtualDevice, _: int, share: float) -> None:
    device.line.regulator = device.line.ambient + share * device.set_gauge


def _set_e_stop(device: VirtualDevice, _: int, there: bool | None) -> None:
    device.stopped = bool(there)


def _set_burst(device: VirtualDevice, joint: int, hose: float | None) -> None:
    device.plant.burst(joint, None if hose is None else int(hose))


def _set_push(device: VirtualDevice, joint: int, share: float) -> None:
    device.plant.load[joint] = share * device.strengths[joint]


OPENING_SIZE = FailureSize(0.3, "opening of the valve", -1.0, 1.0)
HOSE_SIZE = FailureSize(0.0, "0 is hose A, 1 is hose B", 0.0, 1.0)
KINK_SIZE = FailureSize(0.001, "share of what passed", 0.0, 1.0)
SUPPLY_SIZE = FailureSize(1.5, "share of the set gauge pressure", 0.0, 3.0)
GRIP_SIZE, PUSH_SIZE = (
    FailureSize(1.5, "share of its greatest torque", low, high) for low, high in ((0.0, 10.0), (-3.0, 3.0))
)

ALL_FAILURES = (
    _reply_failure("reply-lost", "commands are obeyed, replies do not come", ReplyFault.LOST),
    _reply_failure("reply-crc", "replies come with a wrong checksum", ReplyFault.CRC),
    _reply_failure("reply-sequence", "replies come with the number of another command", ReplyFault.SEQUENCE),
    _reply_failure("reply-late", "replies come after the time limit", ReplyFault.LATE),
    Failure("silence", "the wire is cut: nothing is heard, nothing is answered", _set_silence),
    _sensor_failure("angle-open", "the angle sensor reads the low end", 0, ANGLE),
    _sensor_failure("angle-shorted", "the angle sensor reads the high end", 1, ANGLE),
    _sensor_failure("angle-frozen", "the angle repeats one reading", None, ANGLE),
    _sensor_failure("pressure-open", "the pressure sensor reads the low end", 0, PRESSURE),
    _sensor_failure("pressure-frozen", "the pressure repeats one reading", None, PRESSURE),
    _sensor_failure("converter-frozen", "angle and pressure repeat one reading", None, ANGLE, PRESSURE),
    Failure(
        "stuck-spool", "the joint's valve stays at an opening", lambda d, j, x: d.plant.seize(j, x), size=OPENING_SIZE
    ),
    Failure("burst-hose", "a hose of the joint loses its air", _set_burst, size=HOSE_SIZE),
    Failure(
        "kinked-hose", "next to no air passes between the joint and its valve", lambda d, j, x: d.plant.kink(j, x),
        healthy=1.0, size=KINK_SIZE,
    ),
    Failure("supply-lost", "the compressor is gone", _set_regulator, failed=0.0, healthy=1.0),
    Failure("supply-high", "the regulator gives too much", _set_regulator, healthy=1.0, size=SUPPLY_SIZE),
    Failure("e-stop", "the e-stop is pressed; healed, it is released", _set_e_stop),
    Failure(
        "grip", "somebody holds the joint where it is", lambda d, j, x: d.plant.grip(j, x * d.strengths[j]),
        healthy=0.0, size=GRIP_SIZE,
    ),
    Failure("push", "somebody turns the joint", _set_push, healthy=0.0, size=PUSH_SIZE),
)  # fmt: skip

FAILURES_BY_NAME = {failure.name: failure for failure in ALL_FAILURES}


def get_failure(name: str) -> Failure:
    """Return the failure of a name; raise InputError if there is none of that name."""
    if name not in FAILURES_BY_NAME:
        raise InputError(
            f"{name!r} is not a failure", where="failure", right=f"failures are {', '.join(FAILURES_BY_NAME)}"
        )
    return FAILURES_BY_NAME[name]


def execute_line(device: VirtualDevice, words: Sequence[str]) -> str:
    """Execute the words of a command line (see `LINE_HELP`) and return its answer; raise InputError if invalid.

    Without a joint it acts on joint 0; a single number after a failure is a joint's if there is one, else a size.
    """
    match words:
        case ["fail", name, *others] if len(others) <= 2:
            # A single number is a size if it is not that of a joint.
            named = len(others) == 2 or (bool(others) and _find_joint(device, others[0]) is not None)
            joint, size = (others[0], others[1:]) if named else ("0", others)
            get_failure(name).inject(device, _parse_joint(device, joint), *map(_parse_size, size))
            return f"{name}: {get_failure(name).what}"
        case ["heal", name, *others] if len(others) <= 1:
            get_failure(name).heal(device, *(_parse_joint(device, word) for word in others))
            return f"{name}: healed"
        case ["state"]:
            return describe_state(device)
        case ["failures"]:
            return "\n".join(map(str, ALL_FAILURES))
        case _:
            raise InputError(f"{' '.join(words)!r} is not understood", where="line", right=f"give {LINE_HELP}")


def describe_state(device: VirtualDevice) -> str:
    """Return a line about the true state of a device now, whatever its sensors report; its time is advanced to now."""
    device.tick()
    plant, parts = device.plant, [device.state.name.lower()]
    if device.stopped:
        parts.append("e-stop pressed")
    parts.append(f"supply {_format_gauge(device, plant.supply)}")
    for name, angle, (a, b) in zip(plant.joints, plant.angles, plant.pressures, strict=True):
        parts.append(
            f"{name} {57.29578 * angle:.2f} deg, hoses {_format_gauge(device, a)} and {_format_gauge(device, b)}"
        )
    on = [name for number, name in enumerate(device.output_names) if device.outputs >> number & 1]
    parts += [f"{name} on" for name in on]
    return "; ".join(parts)


def _format_gauge(device: VirtualDevice, pressure: float) -> str:
    return f"{max(pressure - device.line.ambient, 0.0) / 1e5:.2f} bar"


def _find_joint(device: VirtualDevice, word: str) -> int | None:
    """Return the number of a joint by its name or number; None where there is none."""
    names = list(device.plant.joints)
    words = [*names, *map(str, range(len(names)))]
    return words.index(word) % len(names) if word in words else None


def _parse_joint(device: VirtualDevice, word: str) -> int:
    """Return the number of the joint that a word names; raise InputError if there is none."""
    number = _find_joint(device, word)
    if number is None:
        right = f"give {' or '.join(device.plant.joints)}"
        raise InputError(f"unknown joint {word!r}", where="line", right=right)
    return number


def _parse_size(word: str) -> float:
    """Return the number that a word gives; raise InputError if it is none."""
    try:
        return float(word)
    except ValueError:
        raise InputError(f"{word!r} is neither joint nor number", where="line", right=f"give {LINE_HELP}") from None
