"""The command line as a person uses it: exit status and what is printed; real processes where start or end count."""

import json
import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from layflat.machine.exchanged import member_names
from layflat.physics.step import STEP
from layflat.sim.dataset import open_run
from tests.cli.commands import LAYFLAT, layflat, refused

LEFT = 1 << 14


def limited() -> None:
    """Let no file grow beyond 16 KiB, as on a disk with little space left."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (LEFT, LEFT))


@pytest.mark.parametrize(
    "words",
    [
        ("simulate", "paper-small-joint", "--duration", "1 s"),
        ("joint", "sweep", "paper-small-joint"),
        ("joint", "design", "paper-small-joint"),
        ("joint", "size", "--torque", "12 N m", "--stroke", "110 deg", "--supply", "5 bar"),
        ("tune", "paper-small-joint", "--generations", "1"),
        ("excite", "paper-arm"),
    ],
    ids=lambda words: " ".join(words[:2]),
)
def test_a_full_disk(words: tuple[str, ...], tmp_path: Path) -> None:
    """One line, exit status 2, and no file that is half written."""
    command = [*LAYFLAT, *words, "--out", str(tmp_path / "out")]
    # Python keeps compiled modules that were cut off, and every later import of them fails.
    env = os.environ | {"PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run(
        command, capture_output=True, text=True, check=False, timeout=300, preexec_fn=limited, env=env
    )
    assert done.returncode == 2, done.stderr
    assert "(File too large); free some space, or give another folder" in done.stderr.splitlines()[-1]
    assert "Traceback" not in done.stderr
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "words", [("machine", "show", "paper-arm", "--toml"), ("machine", "list"), ("--help",), ("machine", "schema")]
)
def test_standard_output_on_a_full_disk(words: tuple[str, ...]) -> None:
    command = [*LAYFLAT, *words]
    with Path("/dev/full").open("w", encoding="utf-8") as full:
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False, timeout=300)
    assert done.returncode == 2
    assert done.stderr == "layflat: standard output: No space left on device\n"


def test_ctrl_c_in_a_long_run(tmp_path: Path) -> None:
    """The compiled loop lets no signal through; the command ends all the same."""
    code = "from layflat.cli import main; main()"
    words = ["simulate", "paper-small-joint", "--duration", "20000 s", "--out", str(tmp_path)]
    started = subprocess.Popen([sys.executable, "-c", code, *words], stderr=subprocess.PIPE, text=True)
    time.sleep(6.0)
    assert started.poll() is None
    os.kill(started.pid, signal.SIGINT)
    told = started.communicate(timeout=60)[1]
    assert started.returncode == 130
    assert told.splitlines() == ["layflat: stopped before there was anything to keep"]
    assert list(tmp_path.iterdir()) == []


def test_the_version() -> None:
    import layflat as package

    done = subprocess.run([*LAYFLAT, "--version"], capture_output=True, text=True, check=False, timeout=300)
    assert (done.returncode, done.stdout) == (0, f"layflat {package.__version__}\n")


def test_without_a_command_the_help_is_shown() -> None:
    done = layflat("rig")
    assert done.returncode == 2
    assert done.stderr.startswith("Usage: layflat rig ")
    assert "  serve " in done.stderr


def test_a_command_imports_no_other() -> None:
    code = (
        "import sys; from layflat.cli import app\n"
        "app(['machine', 'schema', '--help'], standalone_mode=False)\n"
        "print(sorted(name for name in sys.modules if name.startswith('layflat.')))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip().splitlines()[-1] == str(
        [
            "layflat._version",
            "layflat.cli",
            "layflat.cli.common",
            "layflat.cli.completers",
            "layflat.cli.describe",
            "layflat.cli.groups",
            "layflat.cli.lazy",
            "layflat.cli.moved",
            "layflat.errors",
            "layflat.lazy",
            "layflat.outputs",
        ]
    )


def test_help_names_every_command() -> None:
    done = layflat("--help")
    assert done.returncode == 0
    headings = ("Describe and design", "Simulate", "Control", "Measure", "Run a rig", "Pack in a cell", "Research")
    for word in (*headings, "machine", "joint", "arm", "simulate", "study", "tune", "motion", "identify", "reproduce"):
        assert word in done.stdout


def test_help_does_not_load_what_is_heavy() -> None:
    code = (
        "import sys; from layflat import cli\n"
        "try: cli.app(['--help'], standalone_mode=False)\n"
        "except SystemExit: pass\n"
        "print(sorted({'numba', 'numpy', 'xarray', 'matplotlib', 'pint', 'pydantic'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip().splitlines()[-1] == "[]"


def test_a_check_loads_neither_compiler_nor_scipy() -> None:
    heavy = ("numba", "llvmlite", "scipy", "pint", "xarray", "matplotlib", "rich")
    code = (
        "import sys; from layflat import cli\n"
        "cli.app(['machine', 'check', 'paper-arm'], standalone_mode=False)\n"
        f"print({{*{heavy}}} & {{*sys.modules}})"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == ["paper-arm: a valid description of 2 joints", "set()"]


def test_tables_fit_100_columns() -> None:
    for words in (("machine", "list"), ("machine", "show", "paper-arm"), ("machine", "check", "rig-polyester")):
        done = layflat(*words)
        assert done.returncode == 0
        assert max(map(len, done.stdout.splitlines())) <= 100


def test_machines_lists_the_members_of_the_cloud() -> None:
    last = len(member_names("paper-arm")) - 1
    words = " ".join(layflat("machine", "list").stdout.split())
    for name in ("paper-arm", "paper-small-joint", "earlier-actuator"):
        assert f"{name}@0 to {name}@{last}" in words


def test_show_toml_can_be_started_from(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(layflat("machine", "show", "paper-small-joint", "--toml").stdout, encoding="utf-8")
    assert layflat("machine", "check", str(path)).returncode == 0


def test_a_test_bench_is_checked_and_not_simulated(tmp_path: Path) -> None:
    assert layflat("machine", "check", "friction-rig").stdout == "friction-rig: a valid description of a test bench\n"
    line = refused("simulate", "friction-rig", cwd=tmp_path)
    assert line == "layflat: friction-rig: is a test bench, not a machine; `layflat identify` takes it"


def test_simulate_writes_data_and_figure(tmp_path: Path) -> None:
    done = layflat(
        "simulate", "paper-arm", "--move", "large=20 deg", "--move", "small=10 deg @ 1 s", "--duration", "2 s",
        "--payload", "2 kg @ 0.5 s", "--step", "0.3 ms", "--out", str(tmp_path / "out"),
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "steps of 0.2941 ms: 0.3 ms does not divide a control cycle" in done.stdout
    assert "settling (s)" in done.stdout
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["paper-arm.nc", "paper-arm.png"]


def test_a_disturbance_begins_at_its_time_and_not_before(tmp_path: Path) -> None:
    done = layflat(
        "simulate", "paper-small-joint", "--supply", "0 bar @ 0.2 s", "--brake", "0.5 @ 0.1 s", "--duration", "0.3 s",
        "--out", str(tmp_path),
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    run = open_run(tmp_path / "paper-small-joint.nc")
    assert float(run["supply"][0]) == pytest.approx(5.01325e5)
    assert float(run["supply"][-1]) == pytest.approx(1.01325e5)
    assert run.attrs["step"] == pytest.approx(STEP), "the default is that of the library"


def test_a_diverging_run_says_so_and_keeps_its_data(tmp_path: Path) -> None:
    text = 'extends = "paper-arm"\nname = "wild"\n[joint.small.stops]\nstop_stiffness = "1e9 N m/rad"\n'
    (tmp_path / "wild.toml").write_text(text, encoding="utf-8")
    line = refused("simulate", "wild.toml", "--opening", "0, 1", "--brake", "0", "--out", "out", cwd=tmp_path)
    assert "diverged at t = " in line
    assert "in joint '" in line
    assert (tmp_path / "out" / "wild.nc").exists()


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("machine", "show", "papr-arm"), "papr-arm: no such machine; did you mean 'paper-arm'?"),
        (("machine", "show", "nowhere.toml"), "nowhere.toml: can't be read (No such file or directory)"),
        (("simulate", "paper-arm", "--move", "40"), "--move: '40' is a bare number; give an angle such as"),
        (("simulate", "paper-arm", "--move", "61 deg"), "--move: 61 deg is outside the working stroke"),
        (("simulate", "paper-arm", "--move", "wrist=1 deg"), "--move: unknown joint 'wrist'; joints are large, small"),
        (("simulate", "paper-arm", "--move", "1 deg, 2 deg, 3 deg"), "--move: '1 deg, 2 deg, 3 deg' has 3 values"),
        (("simulate", "paper-arm", "--move", "1 deg @ 2"), "--move: '2' is a bare number; give a time such as"),
        (("simulate", "paper-arm", "--supply", "-2 bar"), "--supply: -200000 Pa is out of range"),
        (("simulate", "paper-arm", "--duration", "1 m"), "--duration: '1 m' is not a time"),
        (
            ("simulate", "paper-arm", "--move", "1 deg @ 99 s"),
            "--move: 99 s is after the end; the run ends at 3 s: give",
        ),
        (("simulate", "paper-arm", "--payload", "2 kg @ 3 s"), "--payload: 3 s is after the end; the run ends"),
        (("simulate", "paper-arm", "--move", "1 deg", "--demand", "x.csv"), "--demand: cannot be combined with --move"),
        (
            ("simulate", "paper-arm", "--duration", "1 s", "--demand", "x.csv", "--opening", "0"),
            "--demand: cannot be combined with --opening and --duration; give one or the other",
        ),
        (("simulate", "paper-arm", "--move", "1 deg", "--opening", "0"), "--opening: cannot be combined with --move"),
        (("simulate", "paper-arm", "--opening", "2, 0"), "--opening: 2 is out of range; give a share from -1 to 1"),
        (("simulate", "paper-arm", "--opening", "nan"), "--opening: "),
        (("simulate", "paper-arm", "--seed", "-1"), "'--seed': Input should be greater than or equal to 0"),
        (("simulate", "paper-arm", "--seed", str(10**30)), "'--seed': Input should be less than"),
        (("joint", "sweep", "paper-arm", "--stroke", "1000 deg"), "--stroke: "),
        (
            ("joint", "sweep", "paper-arm", "--stroke", "150 deg"),
            "--stroke: 150 deg is out of range; give up to 140 deg",
        ),
        (("joint", "sweep", "paper-arm", "--stroke", "-10 deg"), "--stroke: "),
        (("joint", "sweep", "paper-arm", "--pressure", "1e4 bar"), "--pressure: "),
        (
            ("joint", "sweep", "paper-arm", "--brake", "-1"),
            "--brake: -1 is out of range; give a fraction from 0 to 100",
        ),
        (("simulate", "rig-polyester"), "rig-polyester: has no valve or sensors"),
        (
            ("joint", "sweep", "paper-arm", "--pressure", "0 bar"),
            "--pressure: 0 bar is out of range; pressure must be positive",
        ),
        (("joint", "sweep", "paper-arm", "--joint", "wrist"), "--joint: unknown joint 'wrist'; give large or small"),
        (("joint", "size", "--torque", "0 N m", "--stroke", "120 deg", "--supply", "4 bar"), "--torque: 0 N m"),
        (
            ("joint", "size", "--torque", "25", "--stroke", "120 deg", "--supply", "4 bar"),
            "--torque: '25' is a bare number",
        ),
        (
            ("joint", "design", "paper-arm", "--joint", "small", "--table", "none.csv", "--pressure", "3 bar"),
            "none.csv",
        ),
        (("simulat",), "No such command 'simulat'. Did you mean 'simulate'? (see `layflat --help`)"),
        (("simulate",), "Missing argument 'NAME|FILE' (see `layflat simulate --help`)"),
        (("rig", "run"), "(see `layflat rig run --help`)"),
        (("rig", "ruin"), "Did you mean 'run'? (see `layflat rig --help`)"),
    ],
)
def test_a_mistake_gives_one_line(words: tuple[str, ...], expected: str, tmp_path: Path) -> None:
    assert expected in refused(*words, cwd=tmp_path)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "words", [("machine", "show", "papr-arm"), ("simulate", "paper-arm", "--move", "40"), ("simulat",)]
)
def test_a_mistake_in_a_process_gives_one_line_and_its_status(words: tuple[str, ...], tmp_path: Path) -> None:
    done = subprocess.run([*LAYFLAT, *words], capture_output=True, text=True, cwd=tmp_path, check=False, timeout=300)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == f"{refused(*words, cwd=tmp_path)}\n"


@pytest.mark.parametrize(
    "words",
    [
        ("simulate", "paper-arm", "--duration", "0.1 s"),
        ("joint", "sweep", "paper-arm"),
        ("joint", "design", "paper-arm"),
        ("joint", "size", "--torque", "25 N m", "--stroke", "120 deg", "--supply", "4 bar"),
        ("reproduce",),
    ],
    ids=lambda words: " ".join(words[:2]),
)
def test_a_folder_that_can_not_be_written(words: tuple[str, ...], tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way", encoding="utf-8")
    assert "can't write here" in refused(*words, "--out", str(tmp_path / "file" / "out"))
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_a_broken_file_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text('extends = "paper-arm"\n[supply]\npressure_gauge = 4\n', encoding="utf-8")
    line = refused("simulate", "mine.toml", "--out", "out", cwd=tmp_path)
    assert line == 'layflat: mine.toml: supply.pressure_gauge: 4 is a bare number; give a pressure such as "4 bar"'
    assert not (tmp_path / "out").exists()


def test_a_machine_that_cannot_run_is_refused_by_the_check(tmp_path: Path) -> None:
    losses = 'kind = "bouc-wen"\nreference_pressure_gauge = "3 bar"\npressure_free = 0.3\ndeflection = "1 deg"\n'
    text = f'extends = "paper-arm"\nname = "mixed"\nomits = ["joint.small.losses"]\n[joint.small.losses]\n{losses}'
    (tmp_path / "mixed.toml").write_text(text, encoding="utf-8")
    line = refused("machine", "check", "mixed.toml", cwd=tmp_path)
    assert line.startswith("layflat: mixed.toml: joint.small: has losses or a tube of another kind")


def test_design_and_size_write_drawings(tmp_path: Path) -> None:
    assert layflat("joint", "design", "paper-arm", "--joint", "small", "--out", str(tmp_path)).returncode == 0
    assert (tmp_path / "paper-arm-small-cam.dxf").exists()
    sized = layflat(
        "joint",
        "size",
        "--torque",
        "12 N m",
        "--stroke",
        "110 deg",
        "--supply",
        "5 bar",
        "--name",
        "wrist",
        "--out",
        str(tmp_path),
    )
    assert sized.returncode == 0, sized.stderr
    assert layflat("machine", "check", str(tmp_path / "wrist.toml")).returncode == 0


def test_schema_is_written_for_editors(tmp_path: Path) -> None:
    assert layflat("machine", "schema", "--out", str(tmp_path / "schema.json")).returncode == 0
    assert json.loads((tmp_path / "schema.json").read_text(encoding="utf-8"))["title"] == "layflat machine"


def test_sigterm_ends_a_command_and_leaves_nothing_hidden(tmp_path: Path) -> None:
    code = """
import os, signal
from layflat.files import whole_file
from layflat.motion import demand_file
def write(*args):
    with whole_file(args[-1]):
        os.kill(os.getpid(), signal.SIGTERM)
        signal.pause()
demand_file.write_demand = write
from layflat.cli import main
main()
"""
    words = [sys.executable, "-c", code, "excite", "paper-small-joint", "-o", "demand.csv"]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 143, done.stderr
    assert done.stderr == "layflat: stopped before there was anything to keep\n"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_ctrl_c_is_one_line_also_where_a_library_makes_an_error_of_it(
    number: int, status: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object) -> None:
        try:
            os.kill(os.getpid(), number)
            time.sleep(10.0)
        except KeyboardInterrupt:
            raise ValueError("error calling a function: KeyboardInterrupt") from None

    monkeypatch.setattr("layflat.machine.load", interrupted)
    done = layflat("simulate", "paper-arm")
    assert done.returncode == status
    assert done.stderr == "layflat: stopped before there was anything to keep\n"
