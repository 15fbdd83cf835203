"""The description that a design begins with, as it was when it was read, and whether its files have changed since."""

from dataclasses import dataclass, field, replace
from hashlib import sha256
from pathlib import Path
from typing import Self

from layflat.description.provenance import Sources
from layflat.description.tables import Plain
from layflat.machine.loader import MACHINES, load, tables
from layflat.machine.model import Machine, build


@dataclass(frozen=True)
class Opened:
    """A description as it was read."""

    given: str  # built-in name or file
    plain: Plain  # its values as they are written, what it extends included
    sources: Sources
    own: Plain  # what stands in its own file, sources and `extends` included
    machine: Machine
    digests: dict[str, str] = field(default_factory=dict)  # of its file and of those that it extends, by path
    rewritten: bool = False  # whether its own file was saved since: what stands there is not what was opened

    @property
    def file(self) -> Path | None:
        """The machine's own file; None of a built-in machine."""
        path = Path(self.given)
        return path.resolve() if str(path.resolve()) in self.digests else None

    @property
    def files(self) -> list[Path]:
        """The machine's file and those that it extends, as far as they are not built in."""
        return [Path(path) for path in self.digests]

    def as_rewritten(self) -> Self:
        """Return the same, knowing that its own file has been saved with changes."""
        digests = {
            path: _digest(Path(path)) if Path(path) == self.file else known for path, known in self.digests.items()
        }
        return replace(self, digests=digests, rewritten=True)

    def changed_on_disk(self) -> list[Path]:
        """Return those of its files that are other than they were, or gone."""
        return [Path(path) for path, known in self.digests.items() if _digest(Path(path)) != known]

    def state(self, path: Path) -> str:
        """Return what tells the present content of a file from any other; "" if it is gone."""
        return _digest(path)


def open_description(given: str) -> Opened:
    """Read a built-in machine or a file.

    Raises:
        MachineError: it is missing or wrong.
    """
    load(given)  # whatever is wrong with it is told as everywhere
    digests = {
        str(path.resolve()): _digest(path)
        for path in (Path(layer.where) for layer in MACHINES.layers(given) if layer.where not in MACHINES.names)
        if path.is_file()
    }
    plain, sources = tables(given)
    own = MACHINES.raw(given) if str(Path(given).resolve()) in digests else {}
    return Opened(given, plain, sources, own, build(plain, sources, given), digests)


def _digest(path: Path) -> str:
    try:
        return sha256(path.read_bytes()).hexdigest()
    except OSError:
        return ""
