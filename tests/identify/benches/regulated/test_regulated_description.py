import tomllib
from pathlib import Path

import pytest

from layflat.description.tables import split_provenance
from layflat.errors import MachineError
from layflat.identify.benches.loader import load_bench
from layflat.machine.loader import BENCH_LIBRARY

TEXT = BENCH_LIBRARY.text("regulated-elbow")


def changed(folder: Path, before: str, after: str) -> Path:
    assert before in TEXT
    path = folder / "elbow.toml"
    path.write_text(TEXT.replace(before, after), encoding="utf-8")
    return path


def test_every_value_of_the_built_in_elbow_says_where_it_comes_from() -> None:
    plain, sources = split_provenance(tomllib.loads(TEXT), "elbow")
    keys = {f"{part}.{key}" for part, table in plain.items() if isinstance(table, dict) for key in table}
    assert {path for path, source in sources.items() if source.source == "assumed" and source.note} == keys


@pytest.mark.parametrize(
    ("before", "after", "told"),
    [
        ('value = "20 ml"', 'value = "5 ml"', "chamber.volume"),
        ('value = "-60 deg"', 'value = "-50 deg"', "stops lie inside"),
        ('"0.1 N m s/rad"', '"0.1 N m"', "load.damping"),
        ("static_ratio = { value = 1.2", "static_ratio = { value = 0.9", "friction.static_ratio"),
        ("critical_ratio =", "critical =", "critical_ratio"),
        ("value = 0.3,", "value = 1.3,", "critical_ratio"),
    ],
)
def test_what_is_wrong_is_told_in_one_line(tmp_path: Path, before: str, after: str, told: str) -> None:
    with pytest.raises(MachineError) as error:
        load_bench(changed(tmp_path, before, after))
    assert told in str(error.value)
    assert "\n" not in str(error.value)


def test_a_file_without_the_newer_values_has_coulomb_friction(tmp_path: Path) -> None:
    newer = ("mismatch", "change", "static_ratio")
    path = tmp_path / "elbow.toml"
    path.write_text("\n".join(line for line in TEXT.splitlines() if not line.startswith(newer)), encoding="utf-8")
    described = load_bench(path)
    assert described.valve.mismatch == 0.0
    assert described.friction.lower_end == described.friction.upper_end
    assert described.friction.static_ratio == 1.0
