"""Commands that reproduce the paper's results, and compare controllers beyond them."""

from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Annotated

import typer

from layflat.cli.bars import steps_bar
from layflat.cli.common import WIDTH, Out, print_table
from layflat.cli.completers import complete_name
from layflat.cli.groups import app
from layflat.errors import StoppedError

if TYPE_CHECKING:
    from layflat.experiments import Reproduction


@app.register("reproduce", "", "--machine mine.toml --out build/mine", "--cloud")
def reproduce_paper(
    machine: Annotated[
        str,
        typer.Option(
            "--machine", "-m", metavar="NAME|FILE", help="the arm under test", autocompletion=complete_name("machine")
        ),
    ] = "paper-arm",
    out: Out = Path("build/reproduce"),
    cloud: Annotated[
        bool, typer.Option("--cloud", help="with every member of the machine's cloud, too: tells spreads (minutes)")
    ] = False,
    questions: Annotated[
        bool, typer.Option("--questions", help="run the studies of the paper's open questions, too (minutes)")
    ] = False,
) -> int:
    """Reproduce the paper: its experiments and claims.

    Performs the experiments, evaluates the claims, writes report.html and claims.json.

    With --cloud it does so with every machine that the paper allows, and writes cloud.json: what each number spreads
    over.

    Claims that need what the machine lacks are listed as not evaluated, with the reason. Ctrl-C ends it; what was
    evaluated until then is kept. The report shows the open questions whose studies are done below the folder.
    """
    from layflat.parallel import generate_in_process  # noqa: PLC0415

    # Started before the imports, which take as long there.
    with generate_in_process("layflat.experiments.report:evaluate_other_claims", machine) as others:
        from layflat.experiments import load_bench, reproduce, write_claims, write_report  # noqa: PLC0415
        from layflat.experiments.questions import QUESTION_MODULES, read_answers, run_question  # noqa: PLC0415
        from layflat.experiments.report import COLUMNS, claim_rows, draw_figures  # noqa: PLC0415
        from layflat.experiments.reproduction import CLAIM_IDS  # noqa: PLC0415
        from layflat.files import check_folder  # noqa: PLC0415
        from layflat.machine.listing import list_values  # noqa: PLC0415
        from layflat.machine.loader import tables  # noqa: PLC0415

        on = load_bench(machine)
        check_folder(out, "claims.json", "report.html", *(["cloud.json"] if cloud else []), costly=True)
        for number, name in enumerate(QUESTION_MODULES if questions else (), 1):
            with steps_bar(f"question {number} of {len(QUESTION_MODULES)}, {name}") as advance:
                run_question(name, out / "questions" / name, advance)
        with steps_bar("claims", len(CLAIM_IDS)) as advance:
            result = reproduce(on, progress=advance, others=others, draw=draw_figures)
    write_claims(result, out / "claims.json")
    every = list_values(*tables(machine))
    assumed = [line for line in every if line.source in {"assumed", "calibrated", "identified", "given"}]
    answered = read_answers(out / "questions")
    report = write_report(result, assumed, out / "report.html", answered)
    print_table(list(COLUMNS), claim_rows(result.claims))
    typer.echo(f"{result.summary}; wrote {report}")
    for one in answered:
        typer.echo(f"\n{one.title}\n{fill(one.finding, WIDTH)}")
    if cloud and not result.was_interrupted:
        _reproduce_cloud(machine, result, out)
    if result.was_interrupted:
        raise StoppedError(f"{len(result.evaluated)} of {len(CLAIM_IDS)} claims", out)
    return 0 if result.agrees else 1


def _reproduce_cloud(machine: str, nominal: "Reproduction", out: Path) -> None:
    """Repeat the experiments with every member of a cloud, and write `cloud.json` to `out`.

    Print the 5 to 95 % range of each quantity beside its value of `nominal`. After Ctrl-C report the members so far,
    and raise StoppedError.
    """
    from layflat.experiments.spread import evaluate_machines, quantity_ranges, range_rows, write_ranges  # noqa: PLC0415
    from layflat.machine.exchanged import member_names  # noqa: PLC0415

    names, claims = member_names(machine), []
    try:
        with steps_bar("members of the cloud", len(names)) as advance:
            for one in evaluate_machines(names):
                claims.append(one)
                advance(len(claims))
    except KeyboardInterrupt:
        if not claims:
            raise StoppedError(f"0 of {len(names)} members", out) from None
    distributions = quantity_ranges(claims)
    print_table(
        ["claim", "quantity", "simulated", "5 to 95 % of the cloud", "unit", "agree"],
        range_rows(nominal, distributions),
    )
    typer.echo(
        f"{len(claims)} of {len(names)} members; wrote {write_ranges(distributions, len(claims), out / 'cloud.json')}"
    )
    if len(claims) < len(names):
        raise StoppedError(f"{len(claims)} of {len(names)} members", out)


@app.register("beyond", "", "mine.toml --quick")
def compare_controllers(
    machine: Annotated[
        str, typer.Argument(metavar="[NAME|FILE]", help="the arm", autocompletion=complete_name("machine"))
    ] = "paper-arm-fast",
    quick: Annotated[bool, typer.Option("--quick", help="with an eighth of the runs")] = False,
    out: Out = Path("build/beyond"),
) -> None:
    """Compare a machine's controller with the tracking law.

    Both are compared with the best that is possible, too. Steps, belts, unknown payloads and plants that differ from
    what the controllers believe; the law without each of its parts; rest, stiffness, and openings found offline as a
    bound. Writes beyond.html and beyond.json.
    """
    from layflat.experiments.beyond.comparison import QUICK_EFFORT, Effort, prepare_comparison  # noqa: PLC0415
    from layflat.experiments.beyond.report import COLUMNS, result_numbers, settling_rows, write_numbers, write_page  # noqa: PLC0415
    from layflat.files import check_folder  # noqa: PLC0415

    comparison_run = prepare_comparison(machine, QUICK_EFFORT if quick else Effort())
    check_folder(out, "beyond.html", "beyond.json", costly=True)
    stages = comparison_run.stages()
    with steps_bar("comparing", len(stages)) as advance:
        for done, (what, work) in enumerate(stages):
            advance(done, now=what)
            work()
    page, numbers_file = (
        write_page(comparison_run, out / "beyond.html"),
        write_numbers(comparison_run, out / "beyond.json"),
    )
    print_table(
        list(COLUMNS),
        settling_rows(comparison_run.settling),
        f"{comparison_run.machine.name}: steps of 40 deg, tip within 2 mm for good",
    )
    others = [
        [name, "-" if value is None else f"{value:.4g}"] for name, value in result_numbers(comparison_run).items()
    ]
    print_table(["name in beyond.json", "value"], others)
    typer.echo(f"wrote {page}\nwrote {numbers_file}")
