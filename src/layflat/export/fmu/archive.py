"""FMUs: archives of a description and of libraries, the same bytes for the same content."""

import zipfile
from collections.abc import Mapping
from pathlib import Path

from layflat.export.fmu.libraries import System
from layflat.export.fmu.universal import join_libraries
from layflat.files import whole_file

NO_DATE = (1980, 1, 1, 0, 0, 0)  # the earliest that an archive can hold


def binaries(libraries: Mapping[System, bytes], version: str, identifier: str) -> dict[str, bytes]:
    """Return the libraries of an FMU by their paths in it.

    Args:
        libraries: libraries by system.
        version: "2.0" or "3.0".
        identifier: name of the library, without suffix.
    """
    by_folder: dict[str, list[tuple[System, bytes]]] = {}
    for system, library in libraries.items():
        by_folder.setdefault(system.folder_of(version), []).append((system, library))
    return {
        f"binaries/{folder}/{identifier}{items[0][0].suffix}": join_libraries([library for _, library in items])
        for folder, items in by_folder.items()
    }


def write_fmu(path: Path, contents: Mapping[str, bytes]) -> Path:
    """Write an FMU and return its path; raise OutputError if that fails.

    Args:
        path: of the file.
        contents: contents by their paths in the archive; modelDescription.xml comes first.
    """
    with whole_file(path) as temporary, zipfile.ZipFile(temporary, "w") as archive:
        for name, content in contents.items():
            entry = zipfile.ZipInfo(name, NO_DATE)
            entry.external_attr = (0o755 if name.startswith("binaries/") else 0o644) << 16
            archive.writestr(entry, content, zipfile.ZIP_DEFLATED, compresslevel=9)
    return path
