"""Descriptions, units, names and archives of FMUs; and what is missing or wrong when they are made."""

import struct
import zipfile
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree as ET

import pytest

from layflat.description import units as u
from layflat.errors import CompilerError, InputError, MissingExtraError
from layflat.export.entries import ControlEntries
from layflat.export.fmu import libraries, writer
from layflat.export.fmu.description import model_description
from layflat.export.fmu.model import FmuModel
from layflat.export.fmu.plant import PlantFunctions
from layflat.export.fmu.units import commented_unit, unit_exponents
from layflat.export.fmu.universal import join_libraries
from layflat.export.fmu.variables import parameter_variables, quoted
from layflat.machine import load
from layflat.machine.signals import SIGNALS


def model_of(name: str, has_plant: bool = True, has_control: bool = True) -> FmuModel:
    machine = load(name)
    return FmuModel(machine, PlantFunctions(machine), ControlEntries(machine, 8), has_plant, has_control)


@pytest.mark.parametrize("quantity", u.QUANTITIES, ids=lambda quantity: quantity.name)
def test_exponents_are_those_of_the_unit(quantity: u.Quantity) -> None:
    """Another package's definitions as reference."""
    pint = pytest.importorskip("pint")
    unit = quantity.unit
    exponents = unit_exponents(unit)
    assert exponents == unit_exponents(unit.replace("*", " ").replace("^", ""))
    assert exponents is not None
    registry = pint.UnitRegistry()
    base = registry.Quantity(1.0, unit).to_base_units()
    names = {"kilogram": "kg", "meter": "m", "second": "s", "ampere": "A", "kelvin": "K"}
    expected = {names[name]: power for name, power in base.unit_items() if name in names}
    assert {name: power for name, power in exponents.items() if name != "rad"} == expected
    assert base.magnitude == 1.0


@pytest.mark.parametrize("text", ["", "voltage", "N m//s", "of F", "N/m/", "(m)", "m0", "m/s Pa"])
def test_texts_that_are_no_units(text: str) -> None:
    assert unit_exponents(text) is None


@pytest.mark.parametrize(
    ("comment", "unit"),
    [
        ("k_e, V/rad", "V/rad"),
        ("rad/s", "rad/s"),
        ("rule 2: min duration of this, s, since a joint that reverses is slow for a moment too", "s"),
        ("of the short-term integral F, V/(rad s)", "V/(rad s)"),
        ("number of joints", ""),
        ("", ""),
    ],
)
def test_units_of_comments(comment: str, unit: str) -> None:
    assert commented_unit(comment) == unit


class Pair(NamedTuple):
    first: float  # the first, kg
    joints: tuple[float, ...]
    rest: tuple[tuple[float, ...], ...]


def test_parameters_have_the_names_of_their_fields() -> None:
    variables = list(parameter_variables(Pair(1.0, (2.0, 3.0), ((4.0,), (5.0,))), "law", ["base", "right-hand"]))
    names = ["law.first", "law.base", "law.'right-hand'", "law.rest[1][1]", "law.rest[2][1]"]
    assert [one.name for one in variables] == names
    assert [one.start for one in variables] == [1.0, 2.0, 3.0, 4.0, 5.0]
    assert variables[0].unit == "kg"


@pytest.mark.parametrize(("name", "structured"), [("large", "large"), ("4th", "'4th'"), ("it's", r"'it\'s'")])
def test_names_of_joints_in_structured_names(name: str, structured: str) -> None:
    assert quoted(name) == structured


@pytest.mark.parametrize("name", ["paper-arm-tracking", "paper-small-joint"])
def test_units_of_reports_are_defined(name: str) -> None:
    """Some are written with other signs than those of signals."""
    for _, variable in model_of(name).variables:
        assert variable.unit == "" or unit_exponents(variable.unit) is not None, variable


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_signals_have_names_and_units_of_data_sets(version: str) -> None:
    root = ET.fromstring(model_description(model_of("paper-arm"), version, "arm", "an arm", "{token}"))
    variables = {one.attrib["name"]: one for one in root.iterfind("ModelVariables/*")}
    for name, (unit, meaning) in SIGNALS.items():
        if name != "tip":
            variable = variables[f"large.{name}"]
            typed = variable if version == "3.0" else variable[0]
            assert typed.get("unit", "1") == unit
            assert variable.attrib["description"] == meaning
    units = {unit.attrib["name"]: unit[0].attrib for unit in root.iterfind("UnitDefinitions/Unit")}
    assert units["Pa"] == {"kg": "1", "m": "-1", "s": "-2"}
    used = {one.get("unit") for one in root.iter() if one.get("unit")}
    assert used == set(units)


def test_value_references_are_places_of_the_header() -> None:
    """The description and the library count in the same way."""
    for has_plant, has_control in writer.FMU_SCOPES.values():
        model = model_of("paper-arm", has_plant, has_control)
        header = model.header("{token}")
        lines = {line.split()[1]: line.split()[2] for line in header.splitlines() if line.startswith("#define")}
        assert int(lines["MODEL_VALUES"]) == model.size
        start = header.partition("model_start[")[2].partition("{")[2].partition("}")[0].split(", ")
        access = header.partition("model_access[")[2].partition("{")[2].partition("}")[0].split(", ")
        assert len(start) == len(access) == model.size
        assert [i for i, use in enumerate(access) if use != lines["ACCESS_NONE"]] == [i for i, _ in model.variables]
        if has_control:
            demand = {one.name: i for i, one in model.variables}["large.demand"]
            assert demand == int(lines["MODEL_DEMAND"])


def test_joints_whose_variables_have_one_name_are_refused() -> None:
    machine = load("paper-arm")
    twins = machine.model_copy(update={"name": "twins"})
    model = FmuModel(twins, PlantFunctions(machine), ControlEntries(machine, 8), True, True)
    model.sections.append(model.sections[0])
    with pytest.raises(InputError, match=r"twins: two variables of the FMU are called 'plant\.arm\.a'; rename"):
        _ = model.variables


def test_archives_are_the_same_bytes_again(fmu_folder: Path, tmp_path: Path) -> None:
    for path in fmu_folder.glob("*.fmu"):
        with zipfile.ZipFile(path) as archive:
            assert archive.testzip() is None
            dates = {entry.date_time for entry in archive.infolist()}
            names = [entry.filename for entry in archive.infolist()]
        assert dates == {(1980, 1, 1, 0, 0, 0)}
        assert names[:2] == ["modelDescription.xml", "documentation/index.html"]
        assert path.stat().st_size < 45_000  # one system


def test_pages_list_files_and_variables(fmu_folder: Path) -> None:
    text = (fmu_folder / "README.md").read_text(encoding="utf-8")
    files = sorted(fmu_folder.glob("*.fmu"))
    assert len(files) == 6
    assert all(f"| `{path.name}` |" in text for path in files)
    for path in files:
        with zipfile.ZipFile(path) as archive:
            page = ET.fromstring(archive.read("documentation/index.html").removeprefix(b"<!DOCTYPE html>"))
            description = ET.fromstring(archive.read("modelDescription.xml"))
        variables = [*description.iterfind("ModelVariables/*")]
        listed = {one.text for one in page.iterfind(".//tr/td[1]")}
        assert listed == {one.get("name") for one in variables if one.get("causality") in {"input", "output"}}
        parameters = sum(one.get("causality") == "parameter" for one in variables)
        assert f"{parameters} numbers of the machine" in "".join(page.itertext())


def test_a_universal_library_holds_each_part() -> None:
    parts = [struct.pack("<III", 0xFEEDFACF, kind, 3) + bytes([kind % 256]) * 5000 for kind in (0x01000007, 12)]
    joined = join_libraries(parts)
    magic, count = struct.unpack_from(">II", joined)
    assert (magic, count) == (0xCAFEBABE, 2)
    for i, part in enumerate(parts):
        processor, kind, offset, size, alignment = struct.unpack_from(">IIIII", joined, 8 + 20 * i)
        assert struct.pack("<II", processor, kind) == part[4:12]
        assert joined[offset : offset + size] == part
        assert offset % (1 << alignment) == 0
    assert join_libraries(parts[:1]) == parts[0]


def test_without_zig_and_compiler(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(libraries, "find_spec", lambda _: None)
    monkeypatch.setattr(libraries, "which", lambda _: None)
    with pytest.raises(MissingExtraError, match=r"fmu: needs ziglang or a C compiler.*layflat\[export\]"):
        list(writer.write_fmus(load("paper-arm"), tmp_path, target="fmu", precision="double"))


def test_single_precision_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="precision: FMUs are not made in 'single'; give 'double'"):
        list(writer.write_fmus(load("paper-arm"), tmp_path, target="fmu", precision="single"))


def test_a_compiler_that_fails_is_named(tmp_path: Path, compiler: str) -> None:
    system = libraries.host_system()
    assert system is not None
    linker = libraries.Linker(compiler, (compiler,), (system,), cross=False)
    with pytest.raises(CompilerError, match=rf"{compiler} can't link the FMU's library for .* \(.*error"):
        libraries.link_libraries(linker, "2.0", "#error no model\n", {system: {}}, tmp_path)


def test_zig_links_for_all_systems(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(libraries, "find_spec", lambda _: object())
    linker = libraries.find_linker()
    assert linker.systems == libraries.LINKED_SYSTEMS
    assert linker.cross
