"""Every example of the gallery runs as it stands, and ends with a picture whose axes have units."""

import ast
import runpy
import subprocess
import sys
from pathlib import Path
from typing import Any

import matplotlib as mpl
import pytest

FOLDER = Path(__file__).parents[1] / "examples"
EXAMPLES = sorted(FOLDER.glob("*/*.py"))


def example_id(path: Path) -> str:
    return str(path.relative_to(FOLDER).with_suffix(""))


@pytest.fixture
def pyplot(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Matplotlib without a screen, and without figures."""
    mpl.use("agg")
    import matplotlib.pyplot as plt

    plt.close("all")
    monkeypatch.setattr(plt, "show", lambda: None)
    yield plt
    plt.close("all")


def unlabelled(figure: Any) -> list[str]:
    """Titles of the axes, or their numbers, that have no label with a unit, of their own or of the axes they share."""
    missing = []
    for number, axes in enumerate(figure.axes):
        for shared, label in (("x", "get_xlabel"), ("y", "get_ylabel")):
            siblings = getattr(axes, f"get_shared_{shared}_axes")().get_siblings(axes)
            bar = hasattr(axes, "_colorbar") and not getattr(axes, f"get_{shared}ticks")().size
            if not bar and not any(getattr(one, label)().endswith(")") for one in siblings):
                missing.append(f"{shared} of {axes.get_title() or number}")
    return missing


@pytest.mark.compiled
@pytest.mark.parametrize("path", EXAMPLES, ids=example_id)
def test_example(path: Path, pyplot: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("LAYFLAT_GENERATIONS", "3")  # of what learns for minutes
    runpy.run_path(str(path), run_name="__main__")
    assert 1 <= len(capsys.readouterr().out.splitlines()) <= 12
    assert len(pyplot.get_fignums()) == 1
    figure = pyplot.gcf()
    figure.canvas.draw()
    assert unlabelled(figure) == []
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("path", EXAMPLES, ids=example_id)
def test_an_example_is_a_page(path: Path) -> None:
    """It has a heading, says what it shows, takes from layflat only what stands at the top, and ends with a picture."""
    text = path.read_text(encoding="utf-8")
    tree = ast.parse(text)
    heading, line, empty, first = (ast.get_docstring(tree) or "").splitlines()[:4]
    assert (line, empty) == ("=" * len(heading), "")
    assert first.startswith("This example shows ")
    modules = [node.module or "" for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    modules += [name.name for node in ast.walk(tree) if isinstance(node, ast.Import) for name in node.names]
    assert [name for name in modules if name.startswith("layflat")] == ["layflat"]
    assert text.count("\n# %%\n") >= 2
    assert ast.unparse(tree.body[-1]) == "plt.show()"


def test_there_is_a_gallery() -> None:
    assert len(EXAMPLES) >= 16
    assert all((path.parent / "GALLERY_HEADER.rst").exists() for path in EXAMPLES)


def test_the_readmes_example_runs(tmp_path: Path) -> None:
    readme = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")
    code = readme.split("```python\n")[1].split("```")[0]
    assert len([line for line in code.splitlines() if line.strip()]) <= 15
    quiet = "import matplotlib; matplotlib.use('agg')\n" + code
    subprocess.run([sys.executable, "-c", quiet], check=True, cwd=tmp_path, timeout=300)


@pytest.mark.parametrize("path", sorted((Path(__file__).parents[1] / "examples").glob("*.toml")), ids=lambda p: p.stem)
def test_example_studies_are_sound(path: Path) -> None:
    from layflat.study import read_study

    assert read_study(path).rows > 1
