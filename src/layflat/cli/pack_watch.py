"""Work of `layflat pack --watch`: a run, and a page in the browser that shows it."""

from pathlib import Path
from typing import TYPE_CHECKING

import typer

from layflat import extras
from layflat.cli.app import naming_options
from layflat.cli.pack_run import Asked, calibration_of, end, error_of, one_run, report
from layflat.cli.pages import OPTIONS, PageOptions
from layflat.errors import LayflatError, StoppedError

if TYPE_CHECKING:
    from layflat.pages.cell.link import PageLink


def watched(asked: Asked, calibration: Path | None, page: PageOptions) -> None:
    """Pack as without a page, which stays until Ctrl-C; a Ctrl-C before the run has ended ends both."""
    from layflat.cell.work.tables import COLUMNS  # noqa: PLC0415
    from layflat.pages.cell.link import PageLink  # noqa: PLC0415
    from layflat.pages.cell.snapshot import About, Stage  # noqa: PLC0415
    from layflat.rig.system import require_posix  # noqa: PLC0415

    require_posix("--watch")
    extras.require("panel", "nicegui", where="--watch")
    place = page.place()
    about = About(asked.cell.name, asked.cell.machine.name, asked.seed, asked.picks, COLUMNS)
    with naming_options(OPTIONS):
        link = PageLink(about, place)
    with link:
        page.tell(asked.cell.name, link.link)
        error: LayflatError | None
        try:
            error = _packed(asked, calibration, link)
        except KeyboardInterrupt:
            if not link.asked.stop:
                raise
            error = StoppedError(f"0 of {asked.picks} picks")
        except LayflatError as raised:
            error = raised
        link.show(stage=Stage.ENDED, error=str(error or ""))
        if link.asked.stop or not isinstance(error, StoppedError):
            _wait(link, error)
    end(error)


def _packed(asked: Asked, calibration: Path | None, link: "PageLink") -> LayflatError | None:
    """Pack and write the results; return what ended it early."""
    from layflat.cell.work.tables import summary  # noqa: PLC0415
    from layflat.pages.cell.watcher import Watcher  # noqa: PLC0415

    known = calibration_of(asked.cell, calibration, asked.out, lambda share: link.show(calibrated=share))
    link.show(images=known is not None)
    run, written = one_run(asked, known, Watcher(link))
    files = report(asked.cell, [run], asked.results, written)
    link.show(summary=tuple(summary(asked.cell, run.deliveries)), written=tuple(str(path) for path in files))
    return error_of(asked, run)


def _wait(link: "PageLink", error: LayflatError | None) -> None:
    """Serve the page until Ctrl-C."""
    how = f" early: {error}" if error is not None else ""
    typer.echo(f"the run has ended{how}; the page stays until Ctrl-C")
    try:
        link.wait()
    except KeyboardInterrupt:
        return
    typer.echo("layflat: the page's process is gone", err=True)
