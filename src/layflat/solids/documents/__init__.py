"""Documents of a machine that need no solids: air, wires, settings of the firmware, and the sheet of a first start.

Example:
    >>> import layflat as lf
    >>> from layflat.solids.documents import make_documents
    >>> sorted(make_documents(lf.load("paper-arm")))[:3]
    ['paper-arm-air.svg', 'paper-arm-commissioning.html', 'paper-arm-tubes.csv']
"""

from pathlib import Path

from layflat.files import check_folder, write_text
from layflat.machine import Machine
from layflat.solids.documents.commissioning import commissioning_sheet
from layflat.solids.documents.pneumatics import draw_pneumatics
from layflat.solids.documents.settings import firmware_settings
from layflat.solids.documents.tubes import tubes_csv
from layflat.solids.documents.wires import wires_csv
from layflat.solids.documents.wiring import draw_wiring

__all__ = [
    "commissioning_sheet", "draw_pneumatics", "draw_wiring", "firmware_settings", "make_documents", "tubes_csv",
    "wires_csv", "write_documents",
]  # fmt: skip


def make_documents(machine: Machine) -> dict[str, str]:
    """Return the texts of all documents of a machine by the names of their files.

    Raises:
        MachineError: no valve, sensors or controller, or it does not fit the firmware's pins and converters.
        DriverError: its control cycle is shorter than the firmware's.
    """
    makers = {
        "air.svg": draw_pneumatics,
        "tubes.csv": tubes_csv,
        "wiring.svg": draw_wiring,
        "wiring.csv": wires_csv,
        "commissioning.html": commissioning_sheet,
    }
    texts = {f"{machine.name}-{ending}": make(machine) for ending, make in makers.items()}
    return texts | {"settings.py": firmware_settings(machine)}


def write_documents(machine: Machine, folder: Path | str) -> list[Path]:
    """Write all documents of a machine into a folder, none unless all can be made, and return their paths.

    Args:
        machine: the machine.
        folder: folder of the files, which is made.

    Raises:
        MachineError: as from `make_documents`.
        DriverError: likewise.
        OutputError: the folder can't be written, or a file may not be replaced.
    """
    texts = make_documents(machine)
    folder = check_folder(Path(folder), *texts)
    return [write_text(folder / name, text) for name, text in texts.items()]
