"""Commands about logs that a rig has recorded: log info, log repair, log plot, log export."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from layflat.cli.bars import bar, busy
from layflat.cli.common import print_table
from layflat.cli.groups import logs
from layflat.errors import InputError

if TYPE_CHECKING:
    import xarray

RigLog = Annotated[
    Path, typer.Argument(metavar="LOG", help="MCAP of `layflat rig run`, or NetCDF of `layflat log export`")
]


@logs.register("info", "build/rig/run.mcap")
def info(log: RigLog) -> None:
    """Show what a rig's log holds: times, cycles, faults."""
    run = _read(log)
    rows = _log_facts(log, run)
    print_table(["", ""], rows, log.name)
    if run.sizes["event"]:
        typer.echo()
        named = {20: "", 30: "warning", 40: "error"}
        log_events = zip(run["event_time"].values, run["event_level"].values, run["event_text"].values, strict=True)
        events = [
            [str(i + 1), f"{t:.3f}", named.get(int(n), str(n)), str(text)] for i, (t, n, text) in enumerate(log_events)
        ]
        print_table(["event", "at (s)", "", ""], events)


@logs.register("repair", "build/rig/run.mcap")
def repair_log(log: RigLog) -> None:
    """Repair an MCAP file that was cut short.

    The original is kept as NAME.mcap.broken.
    """
    from layflat.rig.recorder.repair import repair  # noqa: PLC0415

    with bar("repairing", None, "DownloadColumn", "TimeRemainingColumn") as update:
        done = repair(log, lambda count, size: update(completed=count, total=size))
    if done is None:
        typer.echo(f"{log}: is complete, nothing to repair")
        return
    place, kept = done
    lost = f"lost {kept.lost} bytes that made no whole record" if kept.lost else "lost nothing that was written"
    typer.echo(f"wrote {place}: kept {kept.messages} messages over {kept.seconds:.3f} s, {lost}")


@logs.register("plot", "build/rig/run.mcap --out run.png")
def plot_log(
    log: RigLog,
    out: Annotated[Path | None, typer.Option("--out", "-o", metavar="FILE", help="figure [LOG's name].png")] = None,
) -> None:
    """Draw a rig's log with its faults and events.

    The figure is that of `layflat simulate`.
    """
    from layflat.files import check_file  # noqa: PLC0415
    from layflat.plot.runs import run_figure  # noqa: PLC0415
    from layflat.plot.style import save_figure  # noqa: PLC0415

    place = check_file(out or log.with_suffix(".png"))
    typer.echo(f"wrote {save_figure(run_figure(_read(log)), place)}")


@logs.register("export", "build/rig/run.mcap run.nc")
def export_log(
    log: RigLog, out: Annotated[Path, typer.Argument(metavar="FILE", help="ends in .nc (NetCDF) or .parquet")]
) -> None:
    """Export a rig's log as NetCDF or Parquet.

    Names and units are those of a simulated run.
    """
    from layflat.files import check_file  # noqa: PLC0415
    from layflat.rig.recorder.run import check_format, export_run  # noqa: PLC0415

    check_format(out)
    check_file(out)
    typer.echo(f"wrote {export_run(_read(log), out)}")


def _read(log: Path) -> "xarray.Dataset":
    """Return a rig's recorded log, or its NetCDF of `log export`, as a data set; raise InputError for another file."""
    from layflat.rig.recorder.run import read_run  # noqa: PLC0415
    from layflat.sim.dataset import open_run  # noqa: PLC0415

    with busy("reading"):
        run = open_run(log) if log.suffix == ".nc" else read_run(log)
    if "lateness" not in run or "event" not in run.sizes:
        right = "give a log that `layflat rig run` wrote, or `layflat log export` made of one"
        raise InputError("holds no log of a rig", where=str(log), right=right)
    return run


def _log_facts(log: Path, run: "xarray.Dataset") -> list[list[str]]:
    """Return names and values of the facts about a log."""
    import numpy as np  # noqa: PLC0415

    time, steps = run["time"].to_numpy(), np.diff(run["time"].to_numpy())
    cycle = float(np.median(steps)) if len(steps) else np.nan
    # By deadlines: a cycle that came late is none that is missing.
    apart = np.diff(run["time"].to_numpy() - run["lateness"].to_numpy())
    missing = int(np.rint(apart / cycle - 1.0).clip(0.0).sum()) if len(steps) else 0
    late, spent = 1e6 * run["lateness"].to_numpy(), 1e6 * run["compute"].to_numpy()
    lost = run["lost"].to_numpy()
    failed = int(((lost > 0.0) & (np.diff(lost, prepend=0.0) != 0.0)).sum())
    boxes = sorted(path.name for path in log.parent.glob(f"{log.stem}-fault-*.mcap"))
    rows = [
        ["machine", f"{run.attrs.get('machine_name', 'unknown')}: {', '.join(map(str, run['joint'].values))}"],
        ["start", str(run.attrs.get("start", "unknown"))],
        ["cycles", f"{len(time)} over {time[-1] - time[0]:.3f} s, one every {1e3 * cycle:.4g} ms, {missing} missing"],
        ["lateness", _percentiles_text(late)],
        ["compute time", _percentiles_text(spent)],
        ["failed transactions", str(failed)],
        ["cycles in fault", str(int((run["fault"].to_numpy() > 0.0).sum()))],
        ["recorded by", f"layflat {run.attrs.get('layflat_version', 'unknown')}"],
    ]
    rows += [[name, text] for name, text in json.loads(run.attrs.get("notes", "{}")).items()]
    return rows + ([["black boxes", ", ".join(boxes)]] if boxes else [])


def _percentiles_text(values: object) -> str:
    """Return median, 99th percentile and maximum of times (us) as text."""
    import numpy as np  # noqa: PLC0415

    middle, high, worst = np.percentile(values, (50.0, 99.0, 100.0))  # type: ignore[call-overload]
    return f"median {middle:.0f} us, 99 % within {high:.0f} us, worst {worst:.0f} us"
