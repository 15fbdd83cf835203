"""Joints of hose that take the place of a robot's: those of machines, by machine and joint."""

from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass

from layflat.description.hints import did_you_mean
from layflat.description.provenance import Sources
from layflat.description.tables import Plain
from layflat.errors import InputError
from layflat.machine.loader import MACHINES, load, tables
from layflat.machine.parts import Joint

USUAL = "paper-small-joint-fast:small"  # the paper's small joint, with the larger valve


@dataclass(frozen=True)
class Template:
    """A joint of a machine, and all of that machine."""

    plain: Plain  # of the machine, as written
    sources: Sources
    name: str  # of the joint
    described: Joint
    title: str  # of the machine

    def joint(self) -> tuple[Plain, Sources]:
        """Return what is written of the joint, without what belongs to a planar arm or to the paper's controller."""
        start, left_out = f"joint.{self.name}.", ("link", "gains")
        plain = {key: value for key, value in self.plain["joint"][self.name].items() if key not in left_out}
        sources = {path.removeprefix(start): of for path, of in self.sources.items() if path.startswith(start)}
        return deepcopy(plain), {path: of for path, of in sources.items() if path.partition(".")[0] in plain}


def template(text: str, where: str = "--joints") -> Template:
    """Return the joint that a text names as MACHINE:JOINT, MACHINE being built in or a file.

    Raises:
        InputError: it names none.
        MachineError: the machine's description is wrong.
    """
    machine, colon, joint = text.rpartition(":")
    if not colon or not machine:
        raise InputError(f"{text!r} names no joint", where=where, right=f"give MACHINE:JOINT, such as {USUAL}")
    described = load(machine)
    if joint not in described.joint:
        right = did_you_mean(joint, described.joint, "its joints are {}")
        raise InputError(f"{machine} has no joint {joint!r}", where=where, right=right)
    if described.valve is None or described.angle_sensor is None or described.pressure_sensor is None:
        raise InputError(f"{machine} has no valve or sensors", where=where, right=f"give a joint such as {USUAL}")
    plain, sources = tables(machine)
    title = machine if machine in MACHINES.names else described.name
    return Template(plain, sources, joint, described.joint[joint], title)


def templates(
    names: Sequence[str], choices: Sequence[str], renamed: Mapping[str, str] | None = None
) -> Mapping[str, Template]:
    """Return the joint of hose for each joint of an arm.

    Args:
        names: the arm's joints.
        choices: "MACHINE:JOINT" for all joints, or "NAME=MACHINE:JOINT" for one of them, which goes before.
        renamed: names of joints by other names that NAME may be.

    Raises:
        InputError: a joint is not known, or named twice, or as from `template`.
    """
    general, single = "", dict[str, str]()
    for text in choices:
        name, equals, joint = text.rpartition("=")
        name = (renamed or {}).get(name, name)
        if equals and name not in names:
            raise InputError(f"unknown joint {name!r}", where="--joints", right=did_you_mean(name, names, "give {}"))
        if name in single or (not equals and general):
            what = f"there are two for {'joint ' + repr(name) if equals else 'all joints'}"
            other = single[name] if equals else general
            raise InputError(what, where="--joints", right=f"give {other} or {joint}")
        if equals:
            single[name] = joint
        else:
            general = joint
    chosen = dict.fromkeys(names, general or USUAL) | single
    known = {text: template(text) for text in dict.fromkeys(chosen.values())}
    return {name: known[text] for name, text in chosen.items()}
