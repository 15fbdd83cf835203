"""Writing of a machine's FMUs into a folder."""

import logging
from collections.abc import Iterator
from hashlib import sha256
from pathlib import Path
from tempfile import TemporaryDirectory

from layflat.errors import InputError
from layflat.export.compiled import object_file, portable_entry
from layflat.export.entries import ControlEntries, Entry
from layflat.export.fmu.archive import binaries, write_fmu
from layflat.export.fmu.description import model_description
from layflat.export.fmu.documentation import FmuFile, documentation_page, folder_page
from layflat.export.fmu.libraries import LINKED_SYSTEMS, SOURCE_FOLDER, Linker, System, find_linker, link_libraries
from layflat.export.fmu.model import LAW_PREFIX, FmuModel
from layflat.export.fmu.plant import PlantFunctions
from layflat.export.layout import c_name
from layflat.export.targets import EXPORT_TARGETS
from layflat.files import write_text
from layflat.machine import Machine

LOG = logging.getLogger(__name__)

FMI_VERSIONS = {"2.0": "fmi2", "3.0": "fmi3"}  # of FMI, with the end of the file's name

FMU_SCOPES = {"": (True, True), "plant": (True, False), "controller": (False, True)}
"""FMUs of a machine: the part of the file's name, whether the plant is in it, and whether the control law is."""


def write_fmus(machine: Machine, folder: Path, *, target: str, precision: str) -> Iterator[Path]:  # noqa: ARG001
    """Write the FMUs of a machine: of plant and control law, of each alone, by FMI 2.0 and by 3.0.

    Args:
        machine: the machine.
        folder: their folder.
        target: "fmu".
        precision: "double", that of FMI's real numbers.

    Yields:
        The files.

    Raises:
        InputError: the precision is another one.
        KindError: the control law is plain Python.
        MissingExtraError: neither zig nor a C compiler is installed.
        CompilerError: a library can't be linked.
    """
    if precision != "double":
        raise InputError(f"FMUs are not made in {precision!r}", where="precision", right="give 'double'")
    linker = find_linker()
    plant, control = PlantFunctions(machine), ControlEntries(machine, 8)
    if len(linker.systems) < len(LINKED_SYSTEMS):
        systems = " and ".join(system.title for system in linker.systems)
        LOG.warning("the FMUs run on %s alone; for other systems: pip install 'layflat[export]'", systems)
    code, files = LawCode(), []
    for scope, (has_plant, has_control) in FMU_SCOPES.items():
        model = FmuModel(machine, plant, control, has_plant, has_control)
        for version, path in _write_scope(model, code, linker, folder, f"{machine.name}-{scope}".rstrip("-")):
            files.append(FmuFile(path.name, _parts(model), version, round(path.stat().st_size / 1000)))
            yield path
    whole = FmuModel(machine, plant, control, *FMU_SCOPES[""])
    page = folder_page(whole, files, [system.title for system in linker.systems])
    yield write_text(folder / "README.md", page)


class LawCode:
    """Object files of the laws' functions, each made once for all FMUs."""

    def __init__(self) -> None:
        self._texts, self._objects = dict[str, str](), dict[tuple[str, str], bytes]()

    def object_file(self, entry: Entry, system: System) -> bytes:
        """Return the object file of a function for a system."""
        key = entry.name, system.target
        if key not in self._objects:
            if entry.name not in self._texts:
                self._texts[entry.name] = _hidden(
                    portable_entry(entry, LAW_PREFIX, "double", small=True), f"{LAW_PREFIX}_{entry.name}"
                )
            self._objects[key] = object_file(entry, self._texts[entry.name], LAW_PREFIX, EXPORT_TARGETS[system.target])
        return self._objects[key]


def _hidden(text: str, name: str) -> str:
    """Return LLVM's text with a function that other libraries don't see.

    Else the functions of two FMUs in one process could take each other's place.
    """
    for kind in ("void", "i32"):
        text = text.replace(f"define {kind} @{name}(", f"define hidden {kind} @{name}(")
    return text


def _write_scope(model: FmuModel, code: LawCode, linker: Linker, folder: Path, name: str) -> Iterator[tuple[str, Path]]:
    """Write the FMUs of a model; yield the version of FMI and the file of each."""
    identifier, title = c_name(name), f"{_parts(model)} of {model.machine.name}"

    def objects(system: System) -> dict[str, bytes]:
        return {entry.name: code.object_file(entry, system) for entry in model.entries}

    sources = [path.read_text(encoding="utf-8") for path in sorted(SOURCE_FOLDER.rglob("*.[ch]"))]
    codes = [code for system in linker.systems for code in objects(system).values()]
    token = _token([model.header(""), *sources], codes)
    for version, end in FMI_VERSIONS.items():
        with TemporaryDirectory(prefix="layflat-fmu-") as place:
            libraries = link_libraries(linker, version, model.header(token), objects, Path(place))
        contents = {
            "modelDescription.xml": model_description(model, version, identifier, title, token),
            "documentation/index.html": documentation_page(model, version, title),
        }
        contents |= binaries(libraries, version, identifier)
        yield version, write_fmu(folder / f"{name}-{end}.fmu", contents)


def _parts(model: FmuModel) -> str:
    parts = {"plant": model.has_plant, "control law": model.has_control}
    return " and ".join(name for name, has_part in parts.items() if has_part)


def _token(texts: list[str], objects: list[bytes]) -> str:
    """Return a token in the form of a GUID that changes with anything in a library."""
    digest = sha256(b"\0".join([*(text.encode() for text in texts), *objects])).hexdigest()
    return f"{{{digest[:8]}-{digest[8:12]}-{digest[12:16]}-{digest[16:20]}-{digest[20:32]}}}"
