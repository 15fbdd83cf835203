"""Libraries of descriptions of machines and test benches; a file or a built-in name becomes a validated `Machine`."""

from dataclasses import replace
from functools import reduce
from pathlib import Path
from typing import Any

from layflat.control import CONTROL_LAWS
from layflat.description.library import Layer, Library
from layflat.description.provenance import Sources
from layflat.description.tables import Plain
from layflat.errors import MachineError
from layflat.jit.outside import load_kinds
from layflat.kinds import Table
from layflat.machine.cloud import cloud, parted
from layflat.machine.model import Machine, build
from layflat.physics.arms import ARMS
from layflat.physics.friction import FRICTION
from layflat.physics.hysteresis import HYSTERESIS
from layflat.physics.valves import VALVES

_BUILT_IN = Path(__file__).parent / "builtin"
_SHOWN = "`layflat machines` lists them"


class MachineLibrary(Library):
    """Machines: a file and those that it extends may each name files of kinds, relative to their own folders."""

    def layers(self, where: str | Path, above: tuple[str, ...] = ()) -> list[Layer]:
        """Return layers; `NAME@17` are those of a description, with what a cloud's member lays over them."""
        if (member := parted(str(where))) is None:
            return super().layers(where, above)
        name, file, number = member
        members, found = cloud(file), list[Layer]()
        nothing: tuple[Plain, Sources] = ({}, {})
        for layer in super().layers(name, above):
            own = members.layer(number, layer, reduce(self.laid, [*found, layer], nothing)[0])
            found += [layer, own] if own else [layer]
        if not any(layer.where in members.bases for layer in found):
            known = ", ".join(members.bases)
            raise MachineError(f"{name!r} is no machine of this cloud", where=members.where, right=f"it has {known}")
        return found

    def beside(self, where: str, name: str) -> str:
        """Return names beside as any library does; members of clouds are named as the machines are."""
        member = parted(name)
        return name if member and member[0] in self.names else super().beside(where, name)

    def laid(self, under: tuple[Plain, Sources], layer: Layer) -> tuple[Plain, Sources]:
        """Return tables laid over others; of a part below that is of another kind only what both kinds know is kept.

        Files of meshes get full paths, as those of kinds do: they are beside the file that names them.
        """
        for path in _kinds(layer):
            load_kinds(Path(path), f"{layer.where}: kinds")
        below, joints = under[0], under[0].get("joint", {})
        places: dict[str, Table[Any]] = {"controller": CONTROL_LAWS, "valve": VALVES, "arm": ARMS}
        for name in joints:
            losses = f"joint.{name}.losses"
            parts = _part(below, f"{losses}.parts") or {}
            places |= {losses: HYSTERESIS, f"joint.{name}.friction": FRICTION}
            places |= {f"{losses}.parts.{part}": HYSTERESIS for part in parts}
        lost = [key for at, table in places.items() for key in _lost(below, layer.plain, at, table)]
        if any(key.startswith("controller.") for key in lost):
            lost += [f"joint.{name}.gains" for name, joint in joints.items() if "gains" in joint]
        omitted = [key for key in lost if not any(f"{key}.".startswith(f"{path}.") for path in layer.omits)]
        plain = _with_meshes(layer.plain, self.folder if layer.where in self.names else Path(layer.where).parent)
        return super().laid(under, replace(layer, plain=plain, omits=(*layer.omits, *omitted)))

    def tables(self, where: str | Path) -> tuple[Plain, Sources]:
        """Return tables as any library does; `kinds` are those of all files, the lowest first, with full paths."""
        plain, sources = super().tables(where)
        kinds = [path for layer in self.layers(where) for path in _kinds(layer)] if "kinds" in plain else []
        return plain | ({"kinds": list(dict.fromkeys(kinds))} if kinds else {}), sources


def _part(plain: Plain, place: str) -> Any:
    """Return what stands at a dotted path, None where nothing does."""
    part: Any = plain
    for key in place.split("."):
        part = part.get(key) if isinstance(part, dict) else None
    return part


def _with_meshes(plain: Plain, folder: Path) -> Plain:
    """Return what a file says, with full paths of the meshes by which links of its arm are drawn."""
    links = _part(plain, "arm.link")
    if not isinstance(links, dict):
        return plain
    drawn = {
        name: link | {"shapes": [_with_mesh(shape, folder) for shape in link["shapes"]]}
        for name, link in links.items()
        if isinstance(link, dict) and isinstance(link.get("shapes"), list)
    }
    return plain | {"arm": plain["arm"] | {"link": links | drawn}}


def _with_mesh(shape: Any, folder: Path) -> Any:
    file = shape.get("file") if isinstance(shape, dict) else None
    return shape | {"file": str((folder / file).resolve())} if isinstance(file, str) and file else shape


def _lost(below: Plain, above: Plain, at: str, table: Table[Any]) -> list[str]:
    """Dotted paths of what a part that names another kind does not know of the part below it."""
    old, new = _part(below, at), _part(above, at)
    if not (isinstance(old, dict) and isinstance(new, dict) and "kind" in new):
        return []
    known = [kind.description.model_fields for kind in table if kind.name == new["kind"]]
    if not known or new["kind"] == old.get("kind", table.usual):
        return []
    return [f"{at}.{key}" for key in old if key not in known[0]]


def _kinds(layer: Layer) -> list[str]:
    named = layer.plain.get("kinds", [])
    if not isinstance(named, list) or not all(isinstance(path, str) for path in named):
        raise MachineError(
            f"{named!r} is not a list of files", where=f"{layer.where}: kinds", right='give one such as ["mine.py"]'
        )
    return [str((Path(layer.where).parent / path).resolve()) for path in named]


MACHINES = MachineLibrary(_BUILT_IN, "machine", _SHOWN, 'width = "160 mm"', MachineError)
BENCHES = Library(_BUILT_IN / "benches", "test bench", _SHOWN, 'volume = "10 l"', MachineError)


BUILT_IN = MACHINES.folder


def names() -> tuple[str, ...]:
    """Return the names of the built-in machines."""
    return MACHINES.names


def load(machine: str | Path | Machine) -> Machine:
    """Return a machine from its built-in name or from a TOML file; a `Machine` is passed through.

    Raises:
        MachineError: in one line, which file, key and value is wrong and what would be right.
    """
    if isinstance(machine, Machine):
        return machine
    return build(*tables(machine), str(machine))


def tables(machine: str | Path) -> tuple[Plain, Sources]:
    """Return the plain values of a description as they are written, what it extends included, and their sources.

    Raises:
        MachineError: the file is missing or broken, or describes a test bench.
    """
    where = str(machine)
    if where in BENCHES.names:
        raise _is_bench(where)
    plain, sources = MACHINES.tables(machine)
    if "kind" in plain:
        raise _is_bench(where)
    return plain, sources


def _is_bench(where: str) -> MachineError:
    return MachineError("is a test bench, not a machine", where=where, right="`layflat identify` takes it")
