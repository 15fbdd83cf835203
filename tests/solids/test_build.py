"""The folder of a machine to be built: what it holds, and what independent readers find in its files."""

import csv
import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
import trimesh

from layflat import extras
from layflat.errors import MissingExtraError, OutputError
from layflat.machine import load
from layflat.solids.build import BuiltMachine, build_files, build_machine
from layflat.solids.cost import Prices
from layflat.solids.exchange import write_assembly_step

pytestmark = pytest.mark.skipif(not extras.available("cad"), reason="no extra cad; pip install layflat[cad]")

NAME = "paper-small-joint"
READER = """
import json, sys
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps
from OCP.STEPControl import STEPControl_Reader
from OCP.TopAbs import TopAbs_SOLID
from OCP.TopExp import TopExp_Explorer
reader = STEPControl_Reader()
reader.ReadFile(sys.argv[1])
reader.TransferRoots()
explorer, volumes = TopExp_Explorer(reader.OneShape(), TopAbs_SOLID), []
while explorer.More():
    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(explorer.Current(), properties)
    volumes.append(properties.Mass())
    explorer.Next()
print(json.dumps(volumes))
"""
"""A reader of STEP without layflat, in a process of its own: prints the volumes of all solids, mm3."""


PRICES = Prices.model_validate({"bought": {"*": "2"}})


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> BuiltMachine:
    return build_machine(load(NAME), tmp_path_factory.mktemp("built") / "joint", prices=PRICES, aside=True)


def volumes_in(path: Path) -> list[float]:
    found = subprocess.run([sys.executable, "-c", READER, str(path)], capture_output=True, check=True, text=True)
    return [float(volume) for volume in json.loads(found.stdout.splitlines()[-1])]


def test_the_folder_holds_what_it_says(built: BuiltMachine) -> None:
    assert {path.name for path in built.folder.iterdir()} == set(build_files(NAME))
    assert built.omitted == {}
    made = [part for part in built.parts.parts if not part.bought]
    assert len(list((built.folder / "parts").glob("*.step"))) == len(made)
    assert len(list((built.folder / "drawings").glob("*.pdf"))) >= len(made)


def test_step_has_a_body_a_part_with_its_volume(built: BuiltMachine) -> None:
    found = sorted(volumes_in(built.folder / f"{NAME}.step"))
    components = built.assembly.components
    wanted = sorted(built.assembly.integrals(part.shape).volume for part in components for _ in part.places)
    assert len(found) == sum(part.quantity for part in built.parts.parts)
    assert found == pytest.approx(wanted, rel=1e-3)


def test_masses_of_the_list_add_up_to_the_assemblys(built: BuiltMachine) -> None:
    with (built.folder / f"{NAME}-parts.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    (column,) = [name for name in rows[0] if name.startswith("mass of all")]
    mass = sum(built.assembly.mass_of(part) * part.quantity for part in built.assembly.components)
    assert sum(float(row[column]) for row in rows) == pytest.approx(1e3 * mass, abs=1.0)


def test_prices_of_the_list_add_up_to_the_cost(built: BuiltMachine) -> None:
    with (built.folder / f"{NAME}-parts.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    bought = sum(part.quantity for part in built.parts.parts if part.bought)
    assert built.cost is not None
    assert sum(float(row["price of all"] or 0.0) for row in rows) == built.cost.total == 2.0 * bought
    assert {part.number for part in built.cost.unpriced} == {
        int(row["number"]) for row in rows if not row["price of one"]
    }


def test_every_stl_is_watertight(built: BuiltMachine) -> None:
    for path in sorted((built.folder / "parts").glob("*.stl")):
        assert trimesh.load_mesh(path).is_watertight, path.name


def geometry(path: Path) -> str:
    """The geometry in a STEP file, without the kernel's counter of occurrences; colours follow in any order."""
    text, _, _ = path.read_text(encoding="utf-8").partition("MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION")
    return re.sub(r"(NEXT_ASSEMBLY_USAGE_OCCURRENCE\(')\d+", r"\1", text)


def test_an_assembly_gives_the_same_geometry_again(built: BuiltMachine, tmp_path: Path) -> None:
    paths = [write_assembly_step(built.assembly, lambda part: part.name, tmp_path / k / "a.step") for k in "12"]
    assert geometry(paths[0]) == geometry(paths[1])


def test_a_folder_that_is_not_empty_stays_as_it_is(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(OutputError, match="mine"):
        build_machine(load(NAME), tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]


def test_a_missing_extra_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(extras, "_is_installed", lambda module: module != "OCP")
    with pytest.raises(MissingExtraError, match=r"layflat\[cad\]"):
        build_machine(load(NAME), tmp_path / "out")
    assert not (tmp_path / "out").exists()
