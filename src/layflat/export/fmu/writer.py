"""Writing of a machine's FMUs into a folder."""

import logging
from collections.abc import Iterator
from functools import cached_property
from hashlib import sha256
from pathlib import Path
from tempfile import TemporaryDirectory

from layflat.errors import InputError, KindError
from layflat.export.compiled import object_file, portable_entry
from layflat.export.entries import ControlEntries, Entry
from layflat.export.fmu.archive import binaries, write_fmu
from layflat.export.fmu.description import model_description
from layflat.export.fmu.documentation import FmuFile, documentation_page, folder_page
from layflat.export.fmu.law_source import law_source
from layflat.export.fmu.libraries import (
    LINKED_SYSTEMS,
    SOURCE_FOLDER,
    Linker,
    System,
    compile_laws,
    find_linker,
    link_libraries,
)
from layflat.export.fmu.model import LAW_PREFIX, FmuModel
from layflat.export.fmu.plant import PlantFunctions
from layflat.export.layout import c_name
from layflat.export.targets import EXPORT_TARGETS, Target
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
    files = []
    for scope, (has_plant, has_control) in FMU_SCOPES.items():
        model = FmuModel(machine, plant, control, has_plant, has_control)
        for version, path in _write_scope(model, linker, folder, f"{machine.name}-{scope}".rstrip("-")):
            files.append(FmuFile(path.name, _parts(model), version, round(path.stat().st_size / 1000)))
            yield path
    whole = FmuModel(machine, plant, control, *FMU_SCOPES[""])
    page = folder_page(whole, files, [system.title for system in linker.systems])
    yield write_text(folder / "README.md", page)


class LawCode:
    """Object files of the laws of an FMU, made once for both versions of FMI.

    Args:
        model: the model.
        linker: compiler and systems.
    """

    def __init__(self, model: FmuModel, linker: Linker) -> None:
        self.model, self.linker = model, linker
        try:
            self.texts = {"law": law_source(model)}
        except KindError as error:
            LOG.debug("laws of the FMU are compiled by numba: %s", error)
            self.texts = {entry.name: _hidden(entry) for entry in model.entries}

    @cached_property
    def by_system(self) -> dict[System, dict[str, bytes]]:
        """Object files of the laws for each system, by name."""
        if "law" in self.texts:
            with TemporaryDirectory(prefix="layflat-fmu-") as place:
                compiled = compile_laws(self.linker, self.texts["law"], Path(place))
            return {system: {"law": code} for system, code in compiled.items()}
        return {system: self._of_numba(EXPORT_TARGETS[system.target]) for system in self.linker.systems}

    def _of_numba(self, target: Target) -> dict[str, bytes]:
        return {
            entry.name: object_file(entry, self.texts[entry.name], LAW_PREFIX, target) for entry in self.model.entries
        }


def _hidden(entry: Entry) -> str:
    """Return LLVM's text of a function that other libraries don't see.

    Else the functions of two FMUs in one process could take each other's place.
    """
    text, name = portable_entry(entry, LAW_PREFIX, "double"), f"{LAW_PREFIX}_{entry.name}"
    for kind in ("void", "i32"):
        text = text.replace(f"define {kind} @{name}(", f"define hidden {kind} @{name}(")
    return text


def _write_scope(model: FmuModel, linker: Linker, folder: Path, name: str) -> Iterator[tuple[str, Path]]:
    """Write the FMUs of a model; yield the version of FMI and the file of each."""
    identifier, title = c_name(name), f"{_parts(model)} of {model.machine.name}"
    code, sources = (
        LawCode(model, linker),
        [path.read_text(encoding="utf-8") for path in sorted(SOURCE_FOLDER.rglob("*.[ch]"))],
    )
    token = _token([model.header(""), *sources, *code.texts.values()])
    for version, end in FMI_VERSIONS.items():
        with TemporaryDirectory(prefix="layflat-fmu-") as place:
            libraries = link_libraries(linker, version, model.header(token), code.by_system, Path(place))
        contents = {
            "modelDescription.xml": model_description(model, version, identifier, title, token),
            "documentation/index.html": documentation_page(model, version, title),
        }
        contents |= binaries(libraries, version, identifier)
        yield version, write_fmu(folder / f"{name}-{end}.fmu", contents)


def _parts(model: FmuModel) -> str:
    parts = {"plant": model.has_plant, "control law": model.has_control}
    return " and ".join(name for name, has_part in parts.items() if has_part)


def _token(texts: list[str]) -> str:
    """Return a token in the form of a GUID that changes with anything that a library is made of."""
    digest = sha256("\0".join(texts).encode()).hexdigest()
    return f"{{{digest[:8]}-{digest[8:12]}-{digest[12:16]}-{digest[16:20]}-{digest[20:32]}}}"
