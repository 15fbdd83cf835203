"""Commands that list, show and check machines, and print pages of the documentation."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from layflat.cli.common import MACHINE_HELP, print_findings, print_table
from layflat.cli.completers import complete_name, complete_page, docs_folder
from layflat.cli.groups import app, machines
from layflat.errors import InputError

ABOUT_TIP = "give its demands as an angle: places of the tip do not tell of it"

MachineOrBench = Annotated[
    str, typer.Argument(metavar="NAME|FILE", help=MACHINE_HELP, autocompletion=complete_name("machine", "bench"))
]


@machines.register("list", "")
def list_machines() -> None:
    """List the built-in machines, members of the cloud, and benches."""
    from layflat.identify.benches.loader import load_bench  # noqa: PLC0415
    from layflat.machine import load, names  # noqa: PLC0415
    from layflat.machine.cloud import load_cloud  # noqa: PLC0415
    from layflat.machine.loader import BENCH_LIBRARY  # noqa: PLC0415

    print_table(["machine", "what it is"], [[name, load(name).title] for name in names()])
    last = len(load_cloud().members) - 1
    members = [
        [f"{name}@0 to {name}@{last}", f"{load(name).title}: machines that the paper allows"]
        for name in load_cloud().bases
    ]
    typer.echo()
    print_table(["member of the cloud", "what it is"], members)
    typer.echo()
    print_table(["test bench", "what it is"], [[name, load_bench(name).title] for name in BENCH_LIBRARY.names])


@machines.register("show", "paper-arm", "paper-arm --toml > mine.toml")
def show_machine(
    machine: MachineOrBench,
    toml: Annotated[bool, typer.Option("--toml", help="print a description file to start from")] = False,
) -> None:
    """Show every value of a machine and where it comes from."""
    from layflat.identify.benches.loader import description_tables, load_description  # noqa: PLC0415
    from layflat.machine.listing import list_values, to_toml  # noqa: PLC0415

    plain, sources = description_tables(machine)
    if toml:
        typer.echo(to_toml(plain, sources), nl=False)
        return
    described = load_description(machine)
    rows = [[line.path, line.text, line.source, line.note] for line in list_values(plain, sources)]
    print_table(["key", "value", "source", "note"], rows, title=f"{described.name}: {described.title}")


@machines.register("check", "mine.toml")
def check_machine(machine: MachineOrBench) -> None:
    """Check a description: every value, and whether it can be made."""
    from layflat.identify.benches.loader import is_bench  # noqa: PLC0415

    if is_bench(machine):
        from layflat.identify.benches.loader import load_bench  # noqa: PLC0415

        load_bench(machine)
        typer.echo(f"{machine}: a valid description of a test bench")
        return
    from layflat.design.characteristic import stencils  # noqa: PLC0415
    from layflat.design.joint import design_joint  # noqa: PLC0415
    from layflat.design.summary import Finding  # noqa: PLC0415
    from layflat.machine import load, parameters  # noqa: PLC0415
    from layflat.machine.stale import stale_values, tubes_counted_twice  # noqa: PLC0415
    from layflat.motion.kinematics import joints_not_moving_tip  # noqa: PLC0415

    described = load(machine)
    if None not in (described.valve, described.angle_sensor, described.pressure_sensor):  # else it is no arm to run
        parameters.joints(described)
        parameters.control(described, closed_loop=False)
    stale = [Finding("warning", "stale", one.path, one.what, one.right) for one in stale_values(described)]
    stale += [Finding("note", "volume", one.path, one.what, one.right) for one in tubes_counted_twice(described)]
    stale += [
        Finding("note", "tip", f"joint.{name}", "turns about the tip, which does not move with it", ABOUT_TIP)
        for name in joints_not_moving_tip(described)
    ]
    findings = [f for name in described.joints for f in design_joint(described, name, through=stencils).findings]
    print_findings([*stale, *findings])
    count = len(described.joints)
    typer.echo(f"{machine}: a valid description of {count} joint{'s' if count > 1 else ''}")


@machines.register("schema", "--out layflat.schema.json")
def print_schema(
    out: Annotated[Path | None, typer.Option("--out", "-o", metavar="FILE", help="where to write it")] = None,
) -> None:
    """Print the JSON Schema of description files, for editors."""
    from layflat.files import write_text  # noqa: PLC0415
    from layflat.machine.listing import schema_text  # noqa: PLC0415

    if out is None:
        typer.echo(schema_text())
        return
    write_text(out, schema_text() + "\n")
    typer.echo(f"wrote {out}")


@app.register("docs", "", "control")
def print_docs(
    page: Annotated[
        str,
        typer.Argument(metavar="[PAGE]", help="page to print; default: a list of all", autocompletion=complete_page),
    ] = "",
) -> None:
    """List the pages of the documentation, or print one of them."""
    from layflat.description.wrong import did_you_mean  # noqa: PLC0415

    folder = docs_folder()
    pages = {path.relative_to(folder).with_suffix("").as_posix(): path for path in sorted(folder.rglob("*.md"))}
    if not page:
        print_table(["page", "title"], [[name, page_title(path)] for name, path in pages.items()])
        typer.echo(f"\nprint one: layflat docs PAGE; with their pictures they are in\n{folder}")
        return
    paths = {Path(name).name: path for name, path in pages.items()} | pages
    path = paths.get(page.removesuffix(".md"))
    if path is None:
        raise InputError(f"there is no page {page!r}", where="PAGE", right=did_you_mean(page, paths, "pages are {}"))
    print_page(path.read_text(encoding="utf-8"))


def page_title(path: Path) -> str:
    """Return the heading of a page: its first line without "# "."""
    return path.read_text(encoding="utf-8").partition("\n")[0].lstrip("# ")


def print_page(text: str) -> None:
    """Print a page: laid out and in a pager on a terminal, as Markdown elsewhere."""
    if not sys.stdout.isatty():
        typer.echo(text, nl=False)
        return
    from rich.console import Console  # noqa: PLC0415
    from rich.markdown import Markdown  # noqa: PLC0415

    console = Console()
    with console.pager(styles=True):
        console.print(Markdown(text))
