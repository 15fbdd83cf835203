"""Types of a machine's structs for TypeScript, with unit and meaning of every field."""

from collections.abc import Iterator
from importlib.resources import files

from layflat.export.layout import Struct, StructField
from layflat.export.web.module import WebMachine, WebPart

PLANT_VIEWS = {name: name for name in ("parameters", "state", "inputs", "outputs", "noise")} | {
    "readings": "sensed",
    "restAngles": "angles",
    "restPressures": "pressures",
}
LAW_VIEWS = {name: name for name in ("settings", "memory", "demand", "command", "report")}
"""Structs of plants and controllers, by the properties that hold them."""


def type_name(struct: str) -> str:
    """Return the name of a struct in TypeScript, such as "PaperGains" of "paper_gains"."""
    return "".join(word[:1].upper() + word[1:] for word in struct.split("_"))


def type_declarations(machine: WebMachine) -> str:
    """Return the file index.d.ts of a machine."""
    template = files(__package__).joinpath("package/index.d.ts").read_text(encoding="utf-8")
    parts = (machine.plant, *machine.laws.values())
    structs = "\n".join(_interface(struct) for part in parts for struct in part.interface().structs())
    laws = [
        f"  {_quoted(name)}: {{ {' '.join(f'{key}: {kind};' for key, kind in _views(law, LAW_VIEWS))} }};"
        for name, law in machine.laws.items()
    ]
    plant = [f"  readonly {key}: {kind};" for key, kind in _views(machine.plant, PLANT_VIEWS)]
    texts = {"@LAWS@": "\n".join(laws), "@PLANT@": "\n".join(plant), "@STRUCTS@": structs}
    for mark, text in texts.items():
        template = template.replace(mark, text)
    return template


def _quoted(name: str) -> str:
    return name if name.isidentifier() else f'"{name}"'


def _views(part: WebPart, names: dict[str, str]) -> Iterator[tuple[str, str]]:
    """Yield property and type of the structs of a part."""
    interface = part.interface()
    arguments = {argument.name: argument for entry in part.entries for argument in entry.arguments}
    for key, name in names.items():
        kind = type_name(interface.struct(arguments[name]).name)
        yield key, kind if arguments[name].rows is None else f"readonly {kind}[]"


def _interface(struct: Struct) -> str:
    comment = [f"/** {_comment(struct.comment)}. */"] if struct.comment else []
    lines = [*comment, f"export interface {type_name(struct.name)} extends Struct {{"]
    for field in struct.fields:
        lines += [f"  /** {_comment(field.comment)} */"] if field.comment else []
        lines.append(f"  {_declaration(field)};")
    return "\n".join([*lines, "}", ""])


def _declaration(field: StructField) -> str:
    if field.struct is None:
        return f"{field.name}: number" if field.count is None else f"readonly {field.name}: Row"
    kind = type_name(field.struct.name)
    return f"readonly {field.name}: {kind if field.count is None else f'readonly {kind}[]'}"


def _comment(text: str) -> str:
    return text.replace("*/", "* /")
