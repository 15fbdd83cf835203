"""Every numbered example runs as it stands."""

import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = sorted((Path(__file__).parents[1] / "examples").glob("[0-9]*.py"))  # the others read measured data


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_example(path: Path, tmp_path: Path) -> None:
    subprocess.run([sys.executable, str(path)], check=True, cwd=tmp_path, timeout=300)
    assert list((tmp_path / "build" / "examples").glob(f"{path.stem[:2]}*"))


def test_the_readmes_example_runs(tmp_path: Path) -> None:
    readme = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")
    code = readme.split("```python\n")[1].split("```")[0]
    assert len([line for line in code.splitlines() if line.strip()]) <= 15
    quiet = "import matplotlib; matplotlib.use('agg')\n" + code
    subprocess.run([sys.executable, "-c", quiet], check=True, cwd=tmp_path, timeout=300)


@pytest.mark.parametrize("path", sorted((Path(__file__).parents[1] / "examples").glob("*.toml")), ids=lambda p: p.stem)
def test_example_studies_are_sound(path: Path) -> None:
    from layflat.study import read

    assert read(path).rows > 1
