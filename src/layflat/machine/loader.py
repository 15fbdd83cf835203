"""Libraries of descriptions of machines and test benches, and loading of a validated `Machine` from them."""

from dataclasses import replace
from functools import reduce
from pathlib import Path
from typing import Any

from layflat.control import CONTROL_LAWS
from layflat.description.library import Layer, Library
from layflat.description.tables import Plain, Sources
from layflat.errors import MachineError
from layflat.jit.outside import load_kinds
from layflat.kinds import KindTable
from layflat.machine.cloud import load_cloud, split_member_name
from layflat.machine.model import Machine, build
from layflat.physics.arms import ARM_KINDS
from layflat.physics.friction import FRICTION
from layflat.physics.hysteresis import HYSTERESIS
from layflat.physics.valves import VALVE_KINDS

_BUILT_IN = Path(__file__).parent / "builtin"
_LISTING_ADVICE = "`layflat machine list` lists them"


class MachineLibrary(Library):
    """Library of machines, whose files may name files of kinds, relative to their own folders."""

    def layers(self, where: str | Path, above: tuple[str, ...] = ()) -> list[Layer]:
        """Return the layers of a machine; those of `NAME@17` have the layer of a cloud's member above each.

        Raises:
            MachineError: there is no such machine, cloud or member, or the cloud has no values of the machine.
        """
        if (member := split_member_name(str(where))) is None:
            return super().layers(where, above)
        name, file, number = member
        members, layers = load_cloud(file), list[Layer]()
        nothing: tuple[Plain, Sources] = ({}, {})
        for layer in super().layers(name, above):
            overlay = members.layer(number, layer, reduce(self.apply_layer, [*layers, layer], nothing)[0])
            layers += [layer, overlay] if overlay else [layer]
        if not any(layer.where in members.bases for layer in layers):
            known = ", ".join(members.bases)
            raise MachineError(f"{name!r} is no machine of this cloud", where=members.where, right=f"it has {known}")
        return layers

    def resolve(self, where: str, name: str) -> str:
        """Return a name resolved as `Library` does; names of members of built-in machines stay as they are."""
        member = split_member_name(name)
        return name if member and member[0] in self.names else super().resolve(where, name)

    def apply_layer(self, under: tuple[Plain, Sources], layer: Layer) -> tuple[Plain, Sources]:
        """Return tables overlaid by a layer; a part that changes its kind keeps only keys that both kinds have.

        Python files of kinds that the layer names are run first.
        Files of meshes get full paths, as those of kinds do: they are relative to the file that names them.
        """
        for path in _kind_files(layer):
            load_kinds(Path(path), f"{layer.where}: kinds")
        below, joints = under[0], under[0].get("joint", {})
        places: dict[str, KindTable[Any]] = {"controller": CONTROL_LAWS, "valve": VALVE_KINDS, "arm": ARM_KINDS}
        for name in joints:
            losses = f"joint.{name}.losses"
            parts = _nested_part(below, f"{losses}.parts") or {}
            places |= {losses: HYSTERESIS, f"joint.{name}.friction": FRICTION}
            places |= {f"{losses}.parts.{part}": HYSTERESIS for part in parts}
        lost = [key for at, table in places.items() for key in _incompatible_paths(below, layer.plain, at, table)]
        if any(key.startswith("controller.") for key in lost):
            lost += [f"joint.{name}.gains" for name, joint in joints.items() if "gains" in joint]
        omitted = [key for key in lost if not any(f"{key}.".startswith(f"{path}.") for path in layer.omits)]
        plain = _with_meshes(layer.plain, self.folder if layer.where in self.names else Path(layer.where).parent)
        return super().apply_layer(under, replace(layer, plain=plain, omits=(*layer.omits, *omitted)))

    def tables(self, where: str | Path) -> tuple[Plain, Sources]:
        """Return tables as any library does; `kinds` has the files of all layers, the lowest first, with full paths."""
        plain, sources = super().tables(where)
        kinds = [path for layer in self.layers(where) for path in _kind_files(layer)] if "kinds" in plain else []
        return plain | ({"kinds": list(dict.fromkeys(kinds))} if kinds else {}), sources


def _nested_part(plain: Plain, place: str) -> Any:
    """Return the value at a dotted path of nested tables, or None."""
    part: Any = plain
    for key in place.split("."):
        part = part.get(key) if isinstance(part, dict) else None
    return part


def _with_meshes(plain: Plain, folder: Path) -> Plain:
    """Return the values of a file, with full paths of the meshes that its arm's links are drawn by."""
    links = _nested_part(plain, "arm.link")
    if not isinstance(links, dict):
        return plain
    drawn = {
        name: link | {"shapes": [_with_mesh(shape, folder) for shape in link["shapes"]]}
        for name, link in links.items()
        if isinstance(link, dict) and isinstance(link.get("shapes"), list)
    }
    return plain | {"arm": plain["arm"] | {"link": links | drawn}}


def _with_mesh(shape: Any, folder: Path) -> Any:
    """Return a shape whose file has a full path; a shape without file, or a wrong one, is unchanged."""
    file = shape.get("file") if isinstance(shape, dict) else None
    return shape | {"file": str((folder / file).resolve())} if isinstance(file, str) and file else shape


def _incompatible_paths(below: Plain, above: Plain, at: str, table: KindTable[Any]) -> list[str]:
    """Return the dotted paths of the keys of a part below that the kind named above does not have.

    There are none where the kind stays the same or is unknown.
    """
    old, new = _nested_part(below, at), _nested_part(above, at)
    if not (isinstance(old, dict) and isinstance(new, dict) and "kind" in new):
        return []
    new_fields = [kind.description.model_fields for kind in table if kind.name == new["kind"]]
    if not new_fields or new["kind"] == old.get("kind", table.usual):
        return []
    return [f"{at}.{key}" for key in old if key not in new_fields[0]]


def _kind_files(layer: Layer) -> list[str]:
    """Return the full paths of the files of kinds that a layer names; raise MachineError if they are no list."""
    named = layer.plain.get("kinds", [])
    if not isinstance(named, list) or not all(isinstance(path, str) for path in named):
        raise MachineError(
            f"{named!r} is not a list of files", where=f"{layer.where}: kinds", right='give one such as ["mine.py"]'
        )
    return [str((Path(layer.where).parent / path).resolve()) for path in named]


MACHINE_LIBRARY = MachineLibrary(_BUILT_IN, "machine", _LISTING_ADVICE, 'width = "160 mm"', MachineError)
BENCH_LIBRARY = Library(_BUILT_IN / "benches", "test bench", _LISTING_ADVICE, 'volume = "10 l"', MachineError)


BUILT_IN = MACHINE_LIBRARY.folder


def names() -> tuple[str, ...]:
    """Return the names of the built-in machines.

    Example:
        >>> import layflat as lf
        >>> "paper-arm" in lf.names()
        True
    """
    return MACHINE_LIBRARY.names


def load(machine: str | Path | Machine) -> Machine:
    """Return a machine from its built-in name or from a TOML file; a `Machine` is passed through.

    Raises:
        MachineError: a file, key or value is wrong; the message names it and what would be right.
        KindError: a file of kinds that the machine names can't be run.

    Example:
        >>> import layflat as lf
        >>> arm = lf.load("paper-arm")
        >>> list(arm.joints), arm.arm.payload
        (['large', 'small'], 1.5)
    """
    if isinstance(machine, Machine):
        return machine
    return build(*tables(machine), str(machine))


def tables(machine: str | Path) -> tuple[Plain, Sources]:
    """Return the plain values of a description as written, inherited ones included, and their sources.

    Raises:
        MachineError: the file is missing or broken, or describes a test bench.
    """
    where = str(machine)
    if where in BENCH_LIBRARY.names:
        raise _is_bench(where)
    plain, sources = MACHINE_LIBRARY.tables(machine)
    if "kind" in plain:
        raise _is_bench(where)
    return plain, sources


def _is_bench(where: str) -> MachineError:
    return MachineError("is a test bench, not a machine", where=where, right="`layflat identify` takes it")
