"""Every public name has an example in its docstring, and it does what it shows."""

import time
from pathlib import Path

import pytest

import layflat
from tests.docstrings import example_of, run_example

MAX_SECONDS = 1.0  # of an example whose kernels are compiled


@pytest.mark.compiled
@pytest.mark.parametrize("name", layflat.__all__)
def test_the_example_of_a_public_name_does_what_it_shows(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    example = example_of(getattr(layflat, name))
    assert example.examples, f"layflat.{name} has no example"
    assert "import layflat as lf" in example.examples[0].source
    assert run_example(example) == ""
    start = time.process_time()
    assert run_example(example_of(getattr(layflat, name))) == ""
    assert time.process_time() - start < 3.0 * MAX_SECONDS
