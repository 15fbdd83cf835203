"""What a virtual rig is told in words: "fail stuck-spool small 0.3", "heal stuck-spool small", "state", "failures"."""

from __future__ import annotations

from collections.abc import Sequence

from layflat.errors import InputError
from layflat.rig.device.failures import FAILURES, Size, failure
from layflat.rig.device.virtual import VirtualDevice

HELP = "fail NAME [JOINT] [SIZE], heal NAME [JOINT], state, failures or quit"


def obey(device: VirtualDevice, words: Sequence[str]) -> str:
    """Do what a line says; what is to be answered, in a line or several.

    Raises:
        InputError: it makes no sense.
    """
    match [str(word) for word in words]:
        case ["fail", name, *others] if len(others) <= 2:
            joint, size = _joint_and_size(device, others)
            failure(name).begin(device, joint, size)
            return f"{name}: {failure(name).what}"
        case ["heal", name, *others] if len(others) <= 1:
            failure(name).end(device, _joint(device, others[0]) if others else 0)
            return f"{name}: healed"
        case ["state"]:
            return state(device)
        case ["failures"]:
            return "\n".join(f"{one.name}: {one.what}{_sized(one.size)}" for one in FAILURES.values())
        case _:
            raise InputError(f"{' '.join(words)!r} is not understood", where="line", right=f"give {HELP}")


def state(device: VirtualDevice) -> str:
    """A line about what is so, whatever the sensors say."""
    device.tick()
    plant, parts = device.plant, [device.state.name.lower()]
    if device.stopped:
        parts.append("e-stop pressed")
    parts.append(f"supply {_gauge(device, plant.supply)}")
    for name, angle, (a, b) in zip(plant.joints, plant.angles, plant.pressures, strict=True):
        parts.append(f"{name} {57.29578 * angle:.2f} deg, hoses {_gauge(device, a)} and {_gauge(device, b)}")
    return "; ".join(parts)


def _gauge(device: VirtualDevice, pressure: float) -> str:
    return f"{max(pressure - device.line.ambient, 0.0) / 1e5:.2f} bar"


def _sized(size: Size | None) -> str:
    return "" if size is None else f" (SIZE: {size.unit}; default: {size.usual:g})"


def _joint_and_size(device: VirtualDevice, words: Sequence[str]) -> tuple[int, float | None]:
    """A joint and a size; a single number is a size if it is not that of a joint."""
    if len(words) == 2:
        return _joint(device, words[0]), _number(words[1])
    if len(words) == 1:
        known = words[0] in {*device.plant.joints, *map(str, range(len(device.plant.joints)))}
        return (_joint(device, words[0]), None) if known else (0, _number(words[0]))
    return 0, None


def _joint(device: VirtualDevice, word: str) -> int:
    names = list(device.plant.joints)
    if word in names:
        return names.index(word)
    if word.isdigit() and int(word) < len(names):
        return int(word)
    raise InputError(f"unknown joint {word!r}", where="line", right=f"give {' or '.join(names)}")


def _number(word: str) -> float:
    try:
        return float(word)
    except ValueError:
        raise InputError(f"{word!r} is neither joint nor number", where="line", right=f"give {HELP}") from None
