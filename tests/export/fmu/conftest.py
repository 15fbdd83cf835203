"""FMUs of the paper's arm for this computer, made once."""

import shutil
from pathlib import Path

import pytest

from layflat.export.fmu import libraries, writer
from layflat.machine import load
from tests.export.fmu.importer import Fmu


@pytest.fixture(scope="session")
def compiler() -> str:
    """Name of this computer's C compiler."""
    found = next((name for name in libraries.C_COMPILERS if shutil.which(name)), None)
    if found is None or libraries.host_system() is None:
        pytest.skip("needs a C compiler (cc, gcc or clang)")
    return found


@pytest.fixture(scope="session")
def fmu_folder(compiler: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of the FMUs of the paper's arm, linked by this computer's C compiler even where zig is installed."""
    folder = tmp_path_factory.mktemp("fmus") / "paper-arm"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(libraries, "find_spec", lambda _: None)
        written = list(writer.write_fmus(load("paper-arm"), folder, target="fmu", precision="double"))
    assert sorted(folder.iterdir()) == sorted(written)
    return folder


@pytest.fixture(scope="session", params=["fmi2", "fmi3"])
def version(request: pytest.FixtureRequest) -> str:
    """End of the name of FMUs by a version of FMI."""
    return str(request.param)


@pytest.fixture(scope="session")
def fmus(fmu_folder: Path, version: str, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Fmu]:
    """Unpacked FMUs of a version of FMI by their parts of the machine."""
    system = libraries.host_system()
    assert system is not None
    folders = (system.folder_2 or system.folder, system.folder)
    names = {"both": "paper-arm", "plant": "paper-arm-plant", "controller": "paper-arm-controller"}
    return {
        part: Fmu(fmu_folder / f"{name}-{version}.fmu", tmp_path_factory.mktemp(part), folders)
        for part, name in names.items()
    }
