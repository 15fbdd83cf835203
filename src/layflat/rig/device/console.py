"""What a virtual rig is told in words: "fail stuck-spool small 0.3", "heal stuck-spool small", "state", "failures"."""

from collections.abc import Sequence

from layflat.errors import InputError
from layflat.rig.device.failures import ALL, failure
from layflat.rig.device.virtual import VirtualDevice

HELP = "fail NAME [JOINT] [SIZE], heal NAME [JOINT], state, failures or quit"


def obey(device: VirtualDevice, words: Sequence[str]) -> str:
    """Do what a line says; what is to be answered, in a line or several. Raise InputError if it makes no sense."""
    match words:
        case ["fail", name, *others] if len(others) <= 2:
            # A single number is a size if it is not that of a joint.
            named = len(others) == 2 or (bool(others) and _number_of(device, others[0]) is not None)
            joint, size = (others[0], others[1:]) if named else ("0", others)
            failure(name).begin(device, _joint(device, joint), *map(_size, size))
            return f"{name}: {failure(name).what}"
        case ["heal", name, *others] if len(others) <= 1:
            failure(name).end(device, *(_joint(device, word) for word in others))
            return f"{name}: healed"
        case ["state"]:
            return state(device)
        case ["failures"]:
            return "\n".join(map(str, ALL))
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
    on = [name for number, name in enumerate(device.output_names) if device.outputs >> number & 1]
    parts += [f"{name} on" for name in on]
    return "; ".join(parts)


def _gauge(device: VirtualDevice, pressure: float) -> str:
    return f"{max(pressure - device.line.ambient, 0.0) / 1e5:.2f} bar"


def _number_of(device: VirtualDevice, word: str) -> int | None:
    """Number of the joint of a name or a number; None where there is none."""
    names = list(device.plant.joints)
    known = [*names, *map(str, range(len(names)))]
    return known.index(word) % len(names) if word in known else None


def _joint(device: VirtualDevice, word: str) -> int:
    number = _number_of(device, word)
    if number is None:
        right = f"give {' or '.join(device.plant.joints)}"
        raise InputError(f"unknown joint {word!r}", where="line", right=right)
    return number


def _size(word: str) -> float:
    try:
        return float(word)
    except ValueError:
        raise InputError(f"{word!r} is neither joint nor number", where="line", right=f"give {HELP}") from None
