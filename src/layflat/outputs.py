"""Outputs of commands: a file is replaced only where that loses nothing, or where the user says so.

What a command writes is recorded: a digest of the content, and the words of the command. The same command may replace
it as long as nobody has changed it. So may the same command with other words, where its results are made anew in
seconds, and it says so. All else stays, unless it is what would be written, or the user gives --force. The records
stand in the user's state folder, not beside the results, so that folders hold results alone; a file without a record
is somebody else's.

Where no command runs, in Python, a function writes to the path that it is given, as those of other libraries do.
"""

import json
import os
import shlex
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path

from layflat.errors import OutputError

REPLACE_ADVICE = "give another place, or --force to replace it"
FORCE = "--force"
OUT_OPTIONS = ("-o", "--out")


@dataclass(frozen=True)
class OutputCommand:
    """Running command: its name, its words as they were typed, and the function that reports replaced files."""

    name: str
    typed: tuple[str, ...]
    report: Callable[[str], None] = lambda _: None
    reported: set[str] = field(default_factory=set, compare=False)

    @property
    def forced(self) -> bool:
        """True if the user allows it to replace any file."""
        return FORCE in self.typed

    @property
    def words(self) -> list[str]:
        """Words that determine its results: all but the output path and --force."""
        words: list[str] = []
        skipped = False
        for word in self.typed:
            is_place = word.startswith(tuple(f"{option}=" for option in OUT_OPTIONS))
            if not (skipped or is_place or word in {FORCE, *OUT_OPTIONS}):
                words.append(word)
            skipped = word in OUT_OPTIONS
        return words

    def reads(self, path: Path) -> bool:
        """Return whether a file that is to be written is one of the inputs, too: its words name it twice."""
        values = [word.partition("=")[2] if word.startswith("--") and "=" in word else word for word in self.typed]
        return sum(_is_same_file(value, path) for value in values) > 1


@dataclass(frozen=True)
class OutputRecord:
    """Record of a written file: name and words of the command, and a digest of the content."""

    name: str
    words: list[str]
    digest: str

    @property
    def line(self) -> str:
        """Command line that repeats the command."""
        return f"layflat {shlex.join(self.words)}"


_running: OutputCommand | None = None


@contextmanager
def run_command(command: OutputCommand) -> Iterator[None]:
    """Run a command in this block: only --force replaces files that it did not write, and its outputs are recorded."""
    global _running  # noqa: PLW0603  # a process runs one command; its threads write for it
    before, _running = _running, command
    try:
        yield
    finally:
        _running = before


def is_forced() -> bool:
    """Return whether a command runs that may replace anything."""
    return _running is not None and _running.forced


def check_reachable(path: Path) -> None:
    """Raise OutputError for "no/../file" without a folder "no": once it is made, something else may be there."""
    if ".." in path.parts and not path.parent.exists():
        right = "give the path without .."
        raise OutputError("leads through a folder that is not there", where=str(path), right=right)


def check_replaceable(path: Path, *, costly: bool = False) -> None:
    """Check that writing a file loses nothing.

    Args:
        path: of the file.
        costly: whether existing results may have taken minutes, or a person's work: they are then not replaced by
            those of other inputs.

    Raises:
        OutputError: the path is a folder or a device; or a command runs that reads the file; or, without --force, the
            existing file was not written by it from the same inputs, or has been changed since.
    """
    check_reachable(path)
    if path.exists() and not path.is_file():
        what = "is a folder" if path.is_dir() else "is no file that can be replaced"
        raise OutputError(what, where=str(path), right="give the name of a file")
    command = _running
    if command is None or not path.exists():
        return
    if command.reads(path):
        raise OutputError("is what this command reads", where=str(path), right="give another place")
    if command.forced:
        return
    record = _read_record(path)
    if record is None:
        raise OutputError("is there already, and not from this command", where=str(path), right=REPLACE_ADVICE)
    if record.digest != _digest(path) or not path.stat().st_mode & 0o222:
        raise OutputError("was changed or protected since it was written", where=str(path), right=REPLACE_ADVICE)
    if record.words == command.words:
        return
    if costly or record.name != command.name:
        raise OutputError(f"holds what `{record.line}` wrote", where=str(path), right=REPLACE_ADVICE)


def check_vacant(folder: Path, names: Collection[str]) -> None:
    """Check that results which are a whole folder can be written there; raise OutputError otherwise.

    Args:
        folder: missing, empty or, with --force, one that holds nothing but `names`.
        names: names of what such a folder holds.
    """
    if folder.exists() and not folder.is_dir():
        raise OutputError("is no folder", where=str(folder), right="give the name of a new folder")
    content = sorted(path.name for path in folder.iterdir()) if folder.exists() else []
    foreign = [name for name in content if name not in names]
    if content and (foreign or not is_forced()):
        right = "give a new folder"
        if not foreign and _running is not None:
            right += f", or {FORCE} to replace what it holds"
        raise OutputError(f"is not empty, it holds {(foreign or content)[0]!r}", where=str(folder), right=right)


def replaced_record(path: Path) -> OutputRecord | None:
    """Return the record of an existing file if it has other words than the running command; None otherwise."""
    record = _read_record(path) if _running is not None and path.exists() else None
    return record if record is not None and _running is not None and record.words != _running.words else None


def record_output(path: Path, replaced: OutputRecord | None = None) -> None:
    """Record a file that the running command has written, and report, once, the command line that wrote it before.

    Without a running command it does nothing. A record that can't be written is left out.
    """
    command = _running
    if command is None:
        return
    if replaced is not None and replaced.line not in command.reported:
        command.reported.add(replaced.line)
        command.report(f"{path}: replaced what `{replaced.line}` wrote")
    content = {"path": str(path.resolve()), "name": command.name, "words": command.words, "digest": _digest(path)}
    place = _record_path(path)
    with suppress(OSError):  # without a record the file is taken for somebody else's, which loses nothing
        place.parent.mkdir(parents=True, exist_ok=True)
        temporary = place.with_suffix(f".{os.getpid()}")
        temporary.write_text(json.dumps(content), encoding="utf-8")
        temporary.replace(place)


def parse_command(typed: Sequence[str], groups: Sequence[str], report: Callable[[str], None]) -> OutputCommand:
    """Return the command of a command line.

    Args:
        typed: words of the command line.
        groups: names of command groups, whose commands have two words.
        report: called with a line on each replaced file.
    """
    return OutputCommand(" ".join(typed[: 2 if typed and typed[0] in groups else 1]), tuple(typed), report)


def _read_record(path: Path) -> OutputRecord | None:
    """Return the record of a file that a command has written, None if there is none."""
    try:
        content = json.loads(_record_path(path).read_text(encoding="utf-8"))
        return OutputRecord(content["name"], content["words"], content["digest"])
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _record_path(path: Path) -> Path:
    """Return the path of the record of a file, in LAYFLAT_STATE_DIR or the user's state folder."""
    # Only commands that write need them.
    import hashlib  # noqa: PLC0415

    import platformdirs  # noqa: PLC0415

    root = Path(os.environ.get("LAYFLAT_STATE_DIR") or platformdirs.user_state_dir("layflat"))
    name = hashlib.blake2b(os.fsencode(path.resolve()), digest_size=16).hexdigest()
    return root / "outputs" / f"{name}.json"


def _digest(path: Path) -> str:
    """Return the BLAKE2b digest of a file's content, 32 hexadecimal digits."""
    import hashlib  # noqa: PLC0415  # as above

    with path.open("rb") as file:
        return hashlib.file_digest(file, lambda: hashlib.blake2b(digest_size=16)).hexdigest()


def _is_same_file(word: str, path: Path) -> bool:
    """Return whether a word of a command line is the path of a file."""
    try:
        return Path(word).samefile(path)
    except (OSError, ValueError):
        return False
