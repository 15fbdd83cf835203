"""A plant and control laws as one WebAssembly module, and the description of its structs for JavaScript."""

# mypy: disable-error-code="no-untyped-call"
# The compiler's own modules are untyped.

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from layflat.errors import InputError
from layflat.export.compiled import portable_entry
from layflat.export.entries import ControlEntries, Entry, PlantEntries
from layflat.export.header import Api
from layflat.export.layout import Struct, c_name
from layflat.export.targets import EXPORT_TARGETS
from layflat.export.web.linking import finish_module
from layflat.jit.objects import machine_code
from layflat.lanes import Like, leaves
from layflat.machine import Machine
from layflat.machine.exchanged import with_tracking

PLANT_PREFIX = "plant"
INTEGER_FIELDS = frozenset({"step", "due"})  # of the plant's state; all other fields are floating-point numbers
DOUBLE_BYTES = 8


@dataclass(frozen=True)
class WebPart:
    """Plant or control law: its entries, and its parameters."""

    name: str  # prefix of its structs and functions, an identifier
    entries: Any
    settings: Any  # tuple of the parameters
    settings_name: str  # of its struct

    @property
    def structure(self) -> tuple[Any, ...]:
        """All that its machine code depends on: parts of equal structure share it."""
        if isinstance(self.entries, PlantEntries):
            return Like.from_tuple(self.settings).text, self.entries.steps, self.entries.h
        return Like.from_tuple(self.settings).text, Like.from_tuple(self.entries.memory).text

    def interface(self) -> Api:
        """Return its structs in C's terms."""
        return Api(self.name, "double", self.entries)


@dataclass(frozen=True)
class WebMachine:
    """Machine in a browser: its plant, and its control laws by their names, the machine's own first."""

    machine: Machine
    plant: WebPart = field(init=False)
    laws: dict[str, WebPart] = field(init=False)

    def __post_init__(self) -> None:
        """Build the parts."""
        entries = PlantEntries(self.machine)
        object.__setattr__(self, "plant", WebPart(PLANT_PREFIX, entries, entries.setting, "parameters"))
        object.__setattr__(self, "laws", dict(_laws(self.machine)))

    @property
    def structure(self) -> tuple[Any, ...]:
        """All that the module's code depends on."""
        return self.plant.structure, *((name, law.structure) for name, law in self.laws.items())

    def description(self) -> dict[str, Any]:
        """Return names, units, structs and parameters as a nested table for JavaScript."""
        return {
            "name": self.machine.name,
            "title": self.machine.title,
            "joints": list(self.machine.joints),
            "cycle": self.machine.cycle,
            "steps": self.plant.entries.steps,
            "plant": _part_description(self.plant),
            "laws": {name: _part_description(law) for name, law in self.laws.items()},
        }


def _laws(machine: Machine) -> Iterator[tuple[str, WebPart]]:
    """Yield the machine's control law by its name, and the tracking law if the machine can have it."""
    own, tracking = machine.control_law.name, with_tracking(machine)
    yield own, _law_part(own, machine)
    if own != "tracking" and tracking is not None:
        yield "tracking", _law_part("tracking", tracking)


def _law_part(name: str, machine: Machine) -> WebPart:
    entries = ControlEntries(machine, DOUBLE_BYTES)
    prefix = c_name(name)
    return WebPart(f"{prefix}_law" if prefix == PLANT_PREFIX else prefix, entries, entries.settings, "settings")


def check_precision(precision: str) -> None:
    """Check that numbers are of double precision, JavaScript's only one; raise InputError otherwise."""
    if precision != "double":
        raise InputError(
            f"{precision!r} is no precision of the target wasm", where="precision", right='give "double", JavaScript\'s'
        )


def web_module(machine: WebMachine, target: str) -> bytes:
    """Return the WebAssembly module of a machine's plant and control laws.

    Args:
        machine: the machine.
        target: "wasm" or "wasm-plain", without SIMD.

    Raises:
        CompilerError: the code needs something from outside.
    """
    exports, texts = {}, []
    for part in (machine.plant, *machine.laws.values()):
        for entry in part.entries:
            exports[f"{part.name}_{entry.name}"] = export_name(part, entry)
            texts.append(portable_entry(entry, part.name, "double"))
    names = tuple(exports)
    text = _joined_text(texts, names)
    code = machine_code(text, names, EXPORT_TARGETS[target].processor, ordered=False, outside=frozenset())
    return finish_module(code, exports)


def export_name(part: WebPart, entry: Entry) -> str:
    """Return the name under which a module exports an entry, such as `plant_advance` or `paper_step`."""
    return f"{part.name}_{entry.name.removeprefix('control_').removeprefix('plant_')}"


def _joined_text(texts: list[str], names: tuple[str, ...]) -> str:
    """Return one module of LLVM with the functions of several, all but the named ones of these internal."""
    from llvmlite import binding  # noqa: PLC0415  # part of the compiler, which takes long to load

    joined = binding.parse_assembly("")
    for text in texts:
        module = binding.parse_assembly(text)
        for one in (*module.functions, *module.global_variables):
            if not one.is_declaration and one.name not in names:
                one.linkage = "internal"
        joined.link_in(module)
    return str(joined)


def _part_description(part: WebPart) -> dict[str, Any]:
    interface = part.interface()
    arguments = {}
    for entry in part.entries:
        for argument in entry.arguments:
            if argument.like is not None:
                arguments[argument.name] = [interface.struct(argument).name, argument.rows or 0]
    structs = {struct.name: struct_fields(struct) for struct in interface.structs()}
    return {
        "prefix": part.name,
        "structs": structs,
        "arguments": arguments,
        part.settings_name: list(leaves(part.settings)),
    }


def struct_fields(struct: Struct) -> list[list[Any]]:
    """Return name, type and count (0: a single one) of each field of a struct."""
    integers = INTEGER_FIELDS if struct.name == f"{PLANT_PREFIX}_state" else frozenset[str]()
    return [
        [one.name, one.struct.name if one.struct else "integer" if one.name in integers else "real", one.count or 0]
        for one in struct.fields
    ]


def shared_modules(machines: list[WebMachine], target: str) -> Mapping[tuple[Any, ...], bytes]:
    """Return the modules of machines by their structure; machines of equal structure share one.

    Args:
        machines: the machines.
        target: "wasm" or "wasm-plain".
    """
    modules: dict[tuple[Any, ...], bytes] = {}
    for machine in machines:
        if machine.structure not in modules:
            modules[machine.structure] = web_module(machine, target)
    return modules
