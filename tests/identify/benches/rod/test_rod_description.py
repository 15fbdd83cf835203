from pathlib import Path

import pytest

from layflat.errors import MachineError
from layflat.identify.benches.loader import load_bench
from layflat.identify.benches.rod.description import RodBench
from layflat.machine.loader import BENCH_LIBRARY

TEXT = BENCH_LIBRARY.text("friction-rig")


def broken(tmp_path: Path, old: str, new: str) -> str:
    assert old in TEXT
    path = tmp_path / "mine.toml"
    path.write_text(TEXT.replace(old, new), encoding="utf-8")
    with pytest.raises(MachineError) as caught:
        load_bench(path)
    return str(caught.value)


def test_the_built_in_rig_is_in_si() -> None:
    rig = load_bench("friction-rig")
    assert isinstance(rig, RodBench)
    assert rig.piston.area == pytest.approx(3.14e-4)
    assert rig.friction.slope == pytest.approx(0.5e-5)


def test_every_value_says_where_it_comes_from() -> None:
    values = [line for line in TEXT.splitlines() if " = " in line and not line.startswith(("kind", "name", "title"))]
    assert values
    assert all("source =" in line and "note =" in line for line in values)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('"314 mm^2"', '"314 mm"', "is not an area"),
        ("[0.4, 0.3, 0.3]", "[0.4, 0.3]", "as many as deflections"),
        ("[0.4, 0.3, 0.3]", "[0.4, 0.3, 0.2]", "add up to 1"),
        ("value = [0, 0, 0,", "value = [-1.5, 0, 0,", "friction.profile"),
        (
            'profile_to = { value = "40 mm"',
            'profile_to = { value = "-40 mm"',
            "profile_to be greater than profile_from",
        ),
        ("film_fraction = { value = 0.5", "film_fraction = { value = 1.5", "film_fraction"),
        ('kind = "friction rig"', 'kind = "fiction rig"', 'did you mean "friction rig"?'),
        ('slope = { value = "0.5', 'slop = { value = "0.5', "unknown key"),
    ],
)
def test_a_mistake_gives_one_line(tmp_path: Path, old: str, new: str, said: str) -> None:
    line = broken(tmp_path, old, new)
    assert said in line
    assert "mine.toml" in line
    assert "\n" not in line
