"""Atomic writing of results: under a temporary name in the same folder, then moved."""

import errno
import os
import shutil
import tempfile
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager, suppress
from filecmp import cmp
from pathlib import Path

from layflat.errors import LayflatError, OutputError
from layflat.outputs import check_reachable, check_replaceable, check_vacant, record_output, replaced_record

DISK_FULL_ERRORS = {errno.ENOSPC, errno.EFBIG, getattr(errno, "EDQUOT", errno.ENOSPC)}
"""Error numbers of a disk, a file or a quota that is full."""

TRIAL_BYTES = bytes(1 << 16)  # written to detect a full disk


@contextmanager
def whole_file(path: Path, *, owned: bool = False) -> Iterator[Path]:
    """Yield a temporary path to write to; move it to `path` when the block succeeds, remove it otherwise.

    A running command records the file (see outputs.py). An error of the block passes, unless writing caused it.

    Args:
        path: path of the file; its folder is made.
        owned: whether an existing file may be replaced in any case, and no record is kept.

    Raises:
        OutputError: the folder can't be made or written, the disk is full, or an existing file may not be
            replaced and has another content.
    """
    check_reachable(path)
    refused: OutputError | None = None
    if not owned:
        try:
            check_replaceable(path)
        except OutputError as error:
            if not path.is_file():
                raise
            refused = error  # unless the new content is the same
    with _temporary_path(path, path.parent, _make_file) as temporary:
        yield temporary
        if refused is not None:
            if cmp(temporary, path, shallow=False):
                return  # the existing file has the same content
            raise refused
        temporary.chmod(0o666 & ~_umask())
        replaced = None if owned else replaced_record(path)
        temporary.replace(path)
        if not owned:
            record_output(path, replaced)


@contextmanager
def _temporary_path(path: Path, folder: Path, make: Callable[[Path, Path], Path]) -> Iterator[Path]:
    """Yield a temporary path for what becomes `path`, and remove it at the end.

    Args:
        path: path of the result, for messages.
        folder: folder of the temporary path, which is made.
        make: function that makes a file or folder for a path in a folder, and returns the new path.

    Raises:
        OutputError: in place of an error that writing caused.
    """
    temporary: Path | None = None
    try:
        folder.mkdir(parents=True, exist_ok=True)
        temporary = make(path, folder)
        yield temporary
    except LayflatError as error:
        if isinstance(error, OutputError) and temporary is not None and Path(error.where).is_relative_to(temporary):
            raise OutputError(error.what, where=str(path), right=error.right) from error
        raise
    except Exception as error:
        failure = _write_error(error, path, temporary)
        if failure is None:
            raise
        raise failure from error
    finally:
        if temporary is not None and temporary.is_dir():
            shutil.rmtree(temporary, ignore_errors=True)
        elif temporary is not None:
            temporary.unlink(missing_ok=True)


def _make_file(path: Path, folder: Path) -> Path:
    """Make an empty hidden file with a name like that of `path` in a folder, and return its path."""
    handle, name = tempfile.mkstemp(prefix=f".{path.stem}-", suffix=path.suffix, dir=folder)
    os.close(handle)
    return Path(name)


def _make_folder(path: Path, folder: Path) -> Path:
    """Make an empty hidden folder with a name like that of `path` in a folder, and return its path."""
    return Path(tempfile.mkdtemp(prefix=f".{path.name}-", dir=folder))


def write_text(path: Path, text: str, *, owned: bool = False) -> Path:
    """Write a text file in UTF-8 atomically and return its path.

    Args:
        path: path of the file; its folder is made.
        text: its content.
        owned: as in `whole_file`.

    Raises:
        OutputError: as from `whole_file`.
    """
    with whole_file(path, owned=owned) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return path


@contextmanager
def whole_folder(folder: Path, names: Collection[str]) -> Iterator[Path]:
    """Yield a temporary folder to write to; move it to `folder` when the block succeeds, remove it otherwise.

    Args:
        folder: new or empty folder; with --force one that holds nothing but such results.
        names: names of what such a folder holds.

    Raises:
        OutputError: the folder holds something, or can't be made or written, or the disk is full.
    """
    check_reachable(folder)
    check_vacant(folder, names)
    exists = folder.exists()
    home = folder if exists else folder.parent
    with _temporary_path(folder, home, _make_folder) as temporary:
        new = temporary / "new"
        new.mkdir()
        yield new
        if exists:
            _exchange_content(folder, new, temporary / "old", names)
        else:
            new.replace(folder)


def _exchange_content(folder: Path, new: Path, old: Path, names: Collection[str]) -> None:
    """Move what `new` holds to a folder, and what the folder holds of these names to `old`; all of it, or nothing.

    The folder itself stays: it may be the working folder or a disk of its own, which can't be moved.
    """
    old.mkdir()
    arrived: list[Path] = []
    try:
        for name in names:
            if (folder / name).exists():
                (folder / name).replace(old / name)
        for part in list(new.iterdir()):
            arrived.append(part)
            part.replace(folder / part.name)
    except BaseException:
        for part in arrived:
            if not part.exists():
                (folder / part.name).replace(part)
        for part in list(old.iterdir()):
            part.replace(folder / part.name)
        raise


def _write_error(error: Exception, path: Path, temporary: Path | None) -> OutputError | None:
    """Return the OutputError that explains an error while writing a file or folder; None if it has another cause.

    Another cause is that of an OSError of another file, or of an error without a number while a trial write succeeds.
    Libraries raise errors of their own on a full disk, without its number: a trial write shows the cause.
    """
    cause = error if isinstance(error, OSError) and error.errno is not None else _try_write(temporary)
    own = temporary is None or cause is None or cause.filename in {None, str(path)}
    if cause is None or not (own or Path(str(cause.filename)).is_relative_to(str(temporary))):
        return None
    full = cause.errno in DISK_FULL_ERRORS
    right = "free some space, or give another folder" if full else "give a folder that you may write to"
    return OutputError(f"can't write here ({cause.strerror})", where=str(path), right=right)


def _try_write(temporary: Path | None) -> OSError | None:
    """Append `TRIAL_BYTES` to a temporary file, or one in a folder, and return the error.

    None if it succeeds, or there is no file.
    """
    if temporary is None:
        return None
    try:
        with (temporary / "trial" if temporary.is_dir() else temporary).open("ab") as file:
            file.write(TRIAL_BYTES)
            file.flush()
            os.fsync(file.fileno())
    except OSError as error:
        return error
    return None


def _umask() -> int:
    """Return the umask of this process; to read it, it is set to 0 for an instant."""
    mask = os.umask(0)
    os.umask(mask)
    return mask


def check_file(path: Path, *, costly: bool = False) -> Path:
    """Check that a result can be written to a path, by a trial that leaves no trace, and return the path.

    Args:
        path: path of the file; its folder may be missing, and stays so.
        costly: whether an existing file may have taken minutes, or a person's work: then no command replaces it by a
            result of other inputs, except with --force.

    Raises:
        OutputError: nothing can be written there, or the running command may not replace the existing file (see
            `check_replaceable`).
    """
    check_folder(path.parent, path.name, costly=costly)
    return path


def check_folder(folder: Path, *names: str, costly: bool = False) -> Path:
    """Check that results can be written to a folder, by a trial that leaves no trace.

    Args:
        folder: folder of the results; it may be missing, and stays so.
        names: names of the files that will be written to it.
        costly: as in `check_file`.

    Returns:
        The folder.

    Raises:
        OutputError: nothing can be written there, or the running command may not replace an existing file.
    """
    for name in names:
        check_replaceable(folder / name, costly=costly)
    check_reachable(folder / ".layflat")
    file = next((parent for parent in (folder, *folder.parents) if parent.exists() and not parent.is_dir()), None)
    if file is not None:
        raise OutputError("can't write here (it is a file)", where=str(file), right="give the name of a folder")
    missing = [parent for parent in (folder, *folder.parents) if not parent.exists()]
    try:
        with whole_file(folder / ".layflat", owned=True) as trial:
            trial.write_bytes(TRIAL_BYTES)
        (folder / ".layflat").unlink(missing_ok=True)
    finally:
        for parent in missing:
            with suppress(OSError):  # it was never made, or another process writes here by now
                parent.rmdir()
    return folder
