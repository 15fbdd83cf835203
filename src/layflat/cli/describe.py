"""Commands about descriptions: machines, show, check, schema."""

from pathlib import Path
from typing import Annotated

import typer

from layflat.cli.app import MachineName, app, print_findings, print_table

ABOUT_TIP = "give its demands as an angle: places of the tip do not tell of it"


@app.command()
def machines() -> None:
    """List the built-in machines, the members of their cloud, and the test benches."""
    from layflat.identify.benches.loader import load_bench  # noqa: PLC0415
    from layflat.machine import load, names  # noqa: PLC0415
    from layflat.machine.cloud import cloud  # noqa: PLC0415
    from layflat.machine.loader import BENCHES  # noqa: PLC0415

    print_table(["machine", "what it is"], [[name, load(name).title] for name in names()])
    last = len(cloud().members) - 1
    members = [
        [f"{name}@0 to {name}@{last}", f"{load(name).title}: machines that the paper allows"] for name in cloud().bases
    ]
    typer.echo()
    print_table(["member of the cloud", "what it is"], members)
    typer.echo()
    print_table(["test bench", "what it is"], [[name, load_bench(name).title] for name in BENCHES.names])


@app.command()
def show(
    machine: MachineName,
    toml: Annotated[bool, typer.Option("--toml", help="print a description file to start from")] = False,
) -> None:
    """Show every value of a machine and where it comes from."""
    from layflat.identify.benches.loader import described_tables, load_described  # noqa: PLC0415
    from layflat.machine.listing import listing, to_toml  # noqa: PLC0415

    plain, sources = described_tables(machine)
    if toml:
        typer.echo(to_toml(plain, sources), nl=False)
        return
    described = load_described(machine)
    rows = [[line.path, line.text, line.source, line.note] for line in listing(plain, sources)]
    print_table(["key", "value", "source", "note"], rows, title=f"{described.name}: {described.title}")


@app.command()
def check(machine: MachineName) -> None:
    """Check a description: every value, and whether it can be made."""
    from layflat.identify.benches.loader import is_bench  # noqa: PLC0415

    if is_bench(machine):
        from layflat.identify.benches.loader import load_bench  # noqa: PLC0415

        load_bench(machine)
        typer.echo(f"{machine}: a valid description of a test bench")
        return
    from layflat.design.characteristic import stencils  # noqa: PLC0415
    from layflat.design.findings import Finding  # noqa: PLC0415
    from layflat.design.joint import design_joint  # noqa: PLC0415
    from layflat.machine import load  # noqa: PLC0415
    from layflat.machine.stale import counted_twice, stale_values  # noqa: PLC0415
    from layflat.motion.levers import joints_beside_tip  # noqa: PLC0415

    described = load(machine)
    stale = [Finding("warning", "stale", one.path, one.what, one.right) for one in stale_values(described)]
    stale += [Finding("note", "volume", one.path, one.what, one.right) for one in counted_twice(described)]
    stale += [
        Finding("note", "tip", f"joint.{name}", "turns about the tip, which does not move with it", ABOUT_TIP)
        for name in joints_beside_tip(described)
    ]
    findings = [f for name in described.joints for f in design_joint(described, name, through=stencils).findings]
    print_findings([*stale, *findings])
    count = len(described.joints)
    typer.echo(f"{machine}: a valid description of {count} joint{'s' if count > 1 else ''}")


@app.command()
def schema(
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
