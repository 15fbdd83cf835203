"""The command line: the one place that puts the parts together. Every command imports what it needs, when it runs."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from layflat.errors import DivergedError, InputError, LayflatError

if TYPE_CHECKING:
    import xarray

    from layflat.design import Characteristic, Finding
    from layflat.machine import Machine
    from layflat.sim.scenario import Scenario

app = typer.Typer(
    name="layflat",
    help="Design, simulate and control robot joints made of layflat hose.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)

MachineName = Annotated[str, typer.Argument(metavar="NAME|FILE", help="built-in machine or description file")]
Out = Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="folder for the results")]


def main() -> None:
    """Run a command; a mistake of the user's gives one line on stderr and exit status 2."""
    try:
        status = app(standalone_mode=False)
    except LayflatError as error:
        _fail(str(error))
    except typer.TyperException as error:
        _fail(f"{error.format_message()} (`layflat --help` shows how)")
    except (typer.Abort, KeyboardInterrupt):
        _fail("stopped", status=130)
    except BrokenPipeError:
        sys.stderr.close()
        sys.exit(0)
    sys.exit(status if isinstance(status, int) else 0)


def _fail(text: str, status: int = 2) -> None:
    print(f"layflat: {' '.join(text.split())}", file=sys.stderr)  # noqa: T201
    sys.exit(status)


def _table(columns: list[str], rows: list[list[str]], title: str = "") -> None:
    """A table that fits 100 columns."""
    from rich.console import Console  # noqa: PLC0415
    from rich.table import Table  # noqa: PLC0415

    table = Table(*columns, title=title or None, title_justify="left", header_style="bold", show_edge=False)
    for row in rows:
        table.add_row(*row)
    console = Console(highlight=False)
    console.width = min(console.width if console.is_terminal else 100, 100)
    console.print(table)


@app.command()
def machines() -> None:
    """List the built-in machines."""
    from layflat.machine import load, names  # noqa: PLC0415

    _table(["machine", "what it is"], [[name, load(name).title] for name in names()])


@app.command()
def show(
    machine: MachineName,
    toml: Annotated[bool, typer.Option("--toml", help="print a description file to start from")] = False,
) -> None:
    """Show every value of a machine and where it comes from."""
    from layflat.machine import load  # noqa: PLC0415
    from layflat.machine.listing import description_toml, listing  # noqa: PLC0415

    if toml:
        typer.echo(description_toml(machine), nl=False)
        return
    described = load(machine)
    rows = [[line.path, line.text, line.source, line.note] for line in listing(machine)]
    _table(["key", "value", "source", "note"], rows, title=f"{described.name}: {described.title}")


@app.command()
def check(machine: MachineName) -> None:
    """Check a description file: every value, and whether such a joint can be made."""
    from layflat.design import design_joint  # noqa: PLC0415
    from layflat.machine import load  # noqa: PLC0415

    described = load(machine)
    findings = [f for name in described.joints for f in design_joint(described, name).findings]
    _print_findings(findings)
    typer.echo(f"{machine}: a sound description of {len(described.joints)} joint(s)")


def _print_findings(findings: Iterable[Finding]) -> None:
    rows = [[f.severity, f.where, f.what, f.right] for f in findings]
    if rows:
        _table(["severity", "where", "found", "what is right, or follows"], rows)


@app.command()
def design(
    machine: MachineName,
    joint: Annotated[str | None, typer.Option(help="joint; all joints where not given")] = None,
    table: Annotated[Path | None, typer.Option(metavar="CSV", help="measured torque over angle, for Eq. (1)")] = None,
    pressure: Annotated[str | None, typer.Option(help="gauge pressure of the measurement")] = None,
    out: Out = Path("build/design"),
) -> None:
    """Design a machine's joints: torque, cam, strap, mass, air; write the cam as DXF, SVG and CSV."""
    from layflat.cli_design import print_design  # noqa: PLC0415
    from layflat.design import design_joint, write_drawings  # noqa: PLC0415
    from layflat.files import check_folder  # noqa: PLC0415
    from layflat.machine import load  # noqa: PLC0415

    described = load(machine)
    chosen = [_known_joint(described, joint)] if joint else list(described.joints)
    designs = []
    for name in chosen:
        measured = _measured(table, pressure, described.joint[name].output.radius) if table else None
        designs.append(design_joint(described, name, measured=measured))
    check_folder(out)
    for made in designs:
        print_design(made, _table)
        _print_findings(made.findings)
        for path in write_drawings(made, out) if made.cam is not None else []:
            typer.echo(f"wrote {path}")


@app.command()
def size(
    torque: Annotated[str, typer.Option(help='over the whole working stroke, such as "25 N m"')],
    stroke: Annotated[str, typer.Option(help='working stroke, such as "120 deg"')],
    supply: Annotated[str, typer.Option(help='gauge pressure of the supply, such as "4 bar"')],
    wrap: Annotated[str | None, typer.Option(help="wrap angle of the collapsed hose")] = None,
    hose_width: Annotated[str | None, typer.Option(help="of the flat hose; a standard width where not given")] = None,
    cylinder_diameter: Annotated[str | None, typer.Option(help="of the outer cylinder")] = None,
    strap_width: Annotated[str | None, typer.Option(help="of the steel strap")] = None,
    strap_thickness: Annotated[str | None, typer.Option(help="of the steel strap")] = None,
    payload_inertia: Annotated[str | None, typer.Option(help="about the joint")] = None,
    name: Annotated[str, typer.Option(help="of the machine")] = "sized-joint",
    out: Out = Path("build/size"),
) -> None:
    """Size a joint from what it shall do: a complete description that can be simulated, and its drawings."""
    from layflat.cli_design import print_design  # noqa: PLC0415
    from layflat.design import SizingRequest, size_joint, write_drawings  # noqa: PLC0415
    from layflat.files import check_folder  # noqa: PLC0415

    request = SizingRequest.from_text(
        torque=torque,
        stroke=stroke,
        supply=supply,
        wrap=wrap,
        hose_width=hose_width,
        cylinder_diameter=cylinder_diameter,
        strap_width=strap_width,
        strap_thickness=strap_thickness,
        payload_inertia=payload_inertia,
        name=name,
    )
    sized = size_joint(request)
    check_folder(out)
    print_design(sized.design, _table)
    _print_findings(sized.findings)
    typer.echo(f"wrote {sized.write(out / f'{name}.toml')}")
    for path in write_drawings(sized.design, out):
        typer.echo(f"wrote {path}")


def _measured(table: Path, pressure: str | None, radius: float) -> Characteristic:
    from layflat.design import read_characteristic  # noqa: PLC0415
    from layflat.machine import units as u  # noqa: PLC0415

    at = u.quantity(pressure, u.PRESSURE, "--pressure") if pressure else None
    return read_characteristic(table, pressure=at, roller_radius=radius)


@app.command()
def schema(
    out: Annotated[Path | None, typer.Option("--out", "-o", metavar="FILE", help="where to write it")] = None,
) -> None:
    """Print the JSON Schema of description files, for editors."""
    from layflat.files import whole_file  # noqa: PLC0415
    from layflat.machine.listing import schema_text  # noqa: PLC0415

    if out is None:
        typer.echo(schema_text())
        return
    with whole_file(out) as temporary:
        temporary.write_text(schema_text() + "\n", encoding="utf-8")
    typer.echo(f"wrote {out}")


@app.command()
def loop(
    machine: MachineName,
    joint: Annotated[str | None, typer.Option(help="joint; all joints where not given")] = None,
    pressure: Annotated[str, typer.Option(help="gauge pressure in hose A")] = "3 bar",
    stroke: Annotated[str | None, typer.Option(help="of the sweep; the working stroke where not given")] = None,
    brake: Annotated[float, typer.Option(help="share of the brake's torque")] = 1.0,
    out: Out = Path("build/loop"),
) -> None:
    """Sweep a joint slowly at constant pressure: its torque-angle loop."""
    from layflat.machine import load  # noqa: PLC0415
    from layflat.machine import units as u  # noqa: PLC0415
    from layflat.plot.loops import loops  # noqa: PLC0415
    from layflat.plot.style import save  # noqa: PLC0415
    from layflat.sim.sweep import sweep  # noqa: PLC0415

    described = load(machine)
    chosen = [_known_joint(described, joint)] if joint else list(described.joints)
    at = u.quantity(pressure, u.PRESSURE, "--pressure")
    if at <= 0.0:
        raise InputError(
            f"{pressure!r} presses no hose", where="--pressure", right='give a gauge pressure such as "3 bar"'
        )
    reach = u.quantity(stroke, u.ANGLE, "--stroke") if stroke else None
    swept = {name: sweep(described, name, at, stroke=reach, brake=brake) for name in chosen}
    rows = [
        [name, f"{s.maximum_torque:.1f}", f"{s.height:.2f}", f"{100 * s.hysteresis:.1f}"]
        for name, s in swept.items()
    ]
    _table(["joint", "torque (N m)", "loop height (N m)", "hysteresis (%)"], rows, f"{described.name} at {pressure}")
    typer.echo(f"wrote {save(loops(swept), out / f'{described.name}-loop.png')}")


def _known_joint(machine: Machine, joint: str) -> str:
    if joint not in machine.joints:
        raise InputError(f"{joint!r} is no joint here", where="--joint", right=f"give {' or '.join(machine.joints)}")
    return joint


@app.command()
def simulate(
    machine: MachineName,
    move: Annotated[
        list[str] | None,
        typer.Option(help='demand: "40 deg", "40 deg, 20 deg" or "large=40 deg", with "@ 2 s" for later; repeatable'),
    ] = None,
    opening: Annotated[str | None, typer.Option(help='open loop: valve openings, such as "0.1, 0"')] = None,
    duration: Annotated[str, typer.Option(help="of the run")] = "3 s",
    start: Annotated[str | None, typer.Option(help="angles at the start; zero where not given")] = None,
    payload: Annotated[list[str] | None, typer.Option(help='such as "2 kg @ 1 s"; repeatable')] = None,
    supply: Annotated[list[str] | None, typer.Option(help='gauge, such as "0 bar @ 1 s"; repeatable')] = None,
    drift: Annotated[list[str] | None, typer.Option(help='of the valve\'s neutral, such as "0.2 V @ 1 s"')] = None,
    load_torque: Annotated[
        list[str] | None, typer.Option("--load", help='on the joints, such as "2 N m @ 1 s"')
    ] = None,
    brake: Annotated[list[str] | None, typer.Option(help='share of the brake\'s torque, such as "0.5 @ 1 s"')] = None,
    seed: Annotated[int, typer.Option(help="of the sensors' noise")] = 0,
    step: Annotated[str, typer.Option(help="of the plant")] = "0.25 ms",
    out: Out = Path("build/simulate"),
) -> None:
    """Simulate a machine with its controller: metrics, a NetCDF data set and a figure."""
    from layflat.cli_text import signal, timed  # noqa: PLC0415
    from layflat.files import check_folder  # noqa: PLC0415
    from layflat.machine import load  # noqa: PLC0415
    from layflat.sim import Scenario, rollout  # noqa: PLC0415

    described = load(machine)
    names = list(described.joints)
    check_folder(out)
    begin = timed([start or "0 deg"], names, "--start")[0][1]
    moves = timed(move or [], names, "--move")
    scenario = Scenario(
        demand=[(0.0, begin), *[(0.1 if t == 0.0 else t, values) for t, values in moves]],
        duration=duration,
        start=begin,
        opening=signal([opening], names, "--opening") if opening else None,
        payload=signal(payload, ["payload"], "--payload"),
        supply=signal(supply, ["supply"], "--supply"),
        drift=signal(drift, names, "--drift") or 0.0,
        load=signal(load_torque, names, "--load") or 0.0,
        brake=signal(brake, names, "--brake") or 1.0,
        seed=seed,
    )
    try:
        run = _waiting("simulating", lambda: rollout(described, scenario=scenario, step=step))
    except DivergedError as error:
        _write_run(described, error.run, out)  # type: ignore[arg-type]
        raise
    _print_metrics(described, run, scenario)
    _write_run(described, run, out)


def _waiting(what: str, work: Callable[[], Any]) -> Any:
    """Show that something is going on, on a terminal."""
    from rich.console import Console  # noqa: PLC0415

    with Console(stderr=True).status(f"{what} (compiles for some seconds the first time)"):
        return work()


def _print_metrics(machine: Machine, run: xarray.Dataset, scenario: Scenario) -> None:
    from layflat.sim.metrics import air_used, moves_of, peak_tip_acceleration  # noqa: PLC0415

    def seconds(value: float) -> str:
        return f"{value:.3f}" if value < 1e6 else "not settled"

    if scenario.opening is None:
        rows = [
            [
                f"{since:g}",
                m.joint,
                seconds(m.settling),
                *(f"{57.29578 * x:.3f}" for x in (m.overshoot, m.steady_error)),
            ]
            for since, m in moves_of(run)
        ]
        columns = ["from (s)", "joint", "settling (s)", "overshoot (deg)", "steady error (deg)"]
        _table(columns, rows, f"{machine.name}: moves, settled within 0.3 deg")
    typer.echo(
        f"air used {air_used(run):.2f} normal litres, peak tip acceleration {peak_tip_acceleration(run):.1f} m/s2"
    )


def _write_run(machine: Machine, run: xarray.Dataset, out: Path) -> None:
    from layflat.plot.runs import run_figure  # noqa: PLC0415
    from layflat.plot.style import save  # noqa: PLC0415
    from layflat.sim.dataset import save as save_run  # noqa: PLC0415

    typer.echo(f"wrote {save_run(run, out / f'{machine.name}.nc')}")
    typer.echo(f"wrote {save(run_figure(run), out / f'{machine.name}.png')}")


@app.command()
def reproduce(
    machine: Annotated[
        str, typer.Option("--machine", "-m", metavar="NAME|FILE", help="the arm under test")
    ] = "paper-arm",
    out: Out = Path("build/reproduce"),
) -> int:
    """Reproduce the paper: perform its experiments, judge its claims, write report.html and claims.json."""
    from layflat.experiments import bench, reproduce, write_claims, write_report  # noqa: PLC0415
    from layflat.experiments.report import lines  # noqa: PLC0415
    from layflat.files import check_folder  # noqa: PLC0415
    from layflat.machine.listing import listing  # noqa: PLC0415

    check_folder(out)
    on = bench(machine)
    with _progress() as advance:
        found = reproduce(on, advance)
        assumed = [line for line in listing(machine) if line.source in {"assumed", "calibrated", "identified", "given"}]
        write_claims(found, out / "claims.json")
        report = write_report(found, assumed, out / "report.html")
    rows = [[c.id, c.where, "\n".join(lines(c)), c.unit, "yes" if c.agrees else "NO"] for c in found.claims]
    _table(["claim", "where", "simulated", "unit", "agrees"], rows)
    typer.echo(f"{sum(c.agrees for c in found.claims)} of {len(found.claims)} claims agree; wrote {report}")
    return 0 if found.agrees else 1


@contextmanager
def _progress() -> Iterator[Callable[[str], None]]:
    """A bar over the experiments."""
    from rich.console import Console  # noqa: PLC0415
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn  # noqa: PLC0415

    from layflat.experiments import EXPERIMENTS  # noqa: PLC0415

    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("compiling (the first time only)", total=EXPERIMENTS + 1)

        def advance(name: str) -> None:
            bar.update(task, advance=1, description=f"done: {name}")

        yield advance
