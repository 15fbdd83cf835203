"""An arm in space on the command line: places of its tip, planned motions, figures."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.commands import layflat, refused

WHERE = "x=600 mm, y=100 mm, z=300 mm @ 0.1 s"


@pytest.mark.compiled
def test_the_tip_goes_where_it_is_told_to(tmp_path: Path) -> None:
    done = layflat("simulate", "picking-arm", "--tip", WHERE, "--duration", "1 s", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    rows = [line.split("│") for line in done.stdout.splitlines() if "│" in line]
    settled_in_two, settled_in_five, error = (float(text) for text in rows[-1][1:])
    assert settled_in_five <= settled_in_two < 0.8
    assert error < 2.0
    written = sorted(path.name for path in (tmp_path / "build/simulate").iterdir())
    assert written == ["picking-arm.nc", "picking-arm.png"]


@pytest.mark.compiled
def test_a_planned_motion_of_an_arm_in_space_is_followed(tmp_path: Path) -> None:
    text = (
        'name = "along"\ntitle = "a line"\nstart = ["0 deg", "20 deg", "-20 deg", "0 deg"]\n'
        '[[segment]]\nkind = "line"\n'
        'to = ["600 mm", "150 mm", "350 mm"]\nspeed = "0.3 m/s"\ntime_optimal = true\n'
    )
    (tmp_path / "along.toml").write_text(text, encoding="utf-8")
    done = layflat("motion", "plan", "along.toml", "picking-arm", "--out", "out", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "out" / "along-motion.png").stat().st_size > 50_000
    run = layflat("simulate", "picking-arm", "--demand", "out/along-demand.csv", cwd=tmp_path)
    assert run.returncode == 0, run.stderr
    told = run.stdout.partition("tip: ")[2].split()
    assert float(told[0]) < 5.0
    assert "from its path" in run.stdout


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("picking-arm", "--tip", "x=2 m"), "--tip: x = 2000.0 mm, y = 0.0 mm, z = "),
        (("picking-arm", "--tip", "600 mm"), "--tip: '600 mm' has 1 values; give 3: x, y, z"),
        (("picking-arm", "--tip", "wrist=1 deg"), "--tip: unknown axis 'wrist'; axes are x, y, z"),
        (("paper-arm", "--tip", "z=1 m"), "--tip: unknown axis 'z'; axes are x, y"),
        (("paper-arm", "--tip", "x=40 deg"), "--tip: '40 deg' is not a length"),
        (("paper-arm", "--tip", "x=0.5 m", "--move", "1 deg"), "--tip: cannot be combined with --move"),
        (("paper-arm", "--tip", "x=0.5 m", "--demand", "x.csv"), "--demand: cannot be combined with --tip"),
        (("paper-arm", "--tip", "x=0.5 m @ 9 s"), "--tip: 9 s is after the end; the run ends"),
    ],
)
def test_mistakes_give_one_line(words: tuple[str, ...], expected: str, tmp_path: Path) -> None:
    line = refused("simulate", *words, cwd=tmp_path)
    assert line.startswith(f"layflat: {expected}")
    assert list(tmp_path.iterdir()) == []
