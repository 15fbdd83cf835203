from pathlib import Path

import pytest

from layflat.description.tables import SOURCE_NAMES, split_provenance
from layflat.errors import MachineError
from layflat.identify.benches.loader import bench_tables, load_bench
from layflat.identify.benches.vessel import VesselBench
from layflat.machine.listing import list_values, to_toml
from layflat.machine.loader import BENCH_LIBRARY
from layflat.physics.flow import sonic_conductance

GOOD = BENCH_LIBRARY.text("blow-down-vessel")


def test_built_in_benches_are_sound_and_say_where_each_value_comes_from() -> None:
    import tomllib

    assert "blow-down-vessel" in BENCH_LIBRARY.names
    for name in BENCH_LIBRARY.names:
        assert load_bench(name).name == name
        plain = tomllib.loads(BENCH_LIBRARY.text(name))
        _, sources = split_provenance({key: value for key, value in plain.items() if isinstance(value, dict)}, name)
        assert all(source.source in SOURCE_NAMES[:4] and source.note for source in sources.values())


def test_the_built_in_vessel_is_consistent() -> None:
    rig = load_bench("blow-down-vessel")
    assert isinstance(rig, VesselBench)
    assert rig.space.volume == pytest.approx(3.14159 / 4 * rig.space.diameter**2 * 0.32, rel=0.01)
    assert rig.path.hole is not None
    assert rig.path.conductance == pytest.approx(sonic_conductance(3.14159 / 4 * rig.path.hole**2, 0.72), rel=0.01)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('"10 l"', "10", "space.volume: 10 is a bare number; give a volume"),
        ("volume =", "volumes =", "did you mean 'volume'?"),
        (
            'kind = "vessel"',
            'kind = "kettle"',
            "unknown kind of test bench 'kettle'; known kinds are friction rig, regulated joint, vessel",
        ),
        ('name = { value = "air"', 'name = { value = "nitrogen"', "no error"),
        ('value = "real"', 'value = "ideal"', "no error"),
        ("value = 0.45,", "value = 1.2,", "path.critical_ratio: 1.2 is out of range"),
        ("[ambient]", "[ambiance]", "did you mean 'ambient'?"),
        ('"8 bar"', '"8 kg"', "is not a pressure"),
    ],
)
def test_a_mistake_is_one_line(old: str, new: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    assert old in GOOD
    path.write_text(GOOD.replace(old, new, 1))
    if said == "no error":
        load_bench(path)
        return
    with pytest.raises(MachineError) as caught:
        load_bench(path)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)
    assert str(path) in str(caught.value)


@pytest.mark.parametrize(
    ("gas", "extra", "said"),
    [
        ('name = "helium"\nlaw = "ideal"', "", "ideal law is that of air"),
        ('name = "air"', 'compliance = "2 ml/bar"', "stretching wall"),
        ('name = "steam"', "", "'steam' is not known; give 'air', 'nitrogen'"),
    ],
)
def test_gas_and_wall_have_to_fit(gas: str, extra: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    head, _, rest = GOOD.partition("[gas]\n")
    _, _, rest = rest.partition("\n\n")
    path.write_text(f"{head}[gas]\n{gas}\n\n{rest}".replace("[space]\n", f"[space]\n{extra}\n"))
    with pytest.raises(MachineError, match=said):
        load_bench(path)


def test_a_file_that_is_not_there_is_one_line() -> None:
    with pytest.raises(MachineError, match=r"can't be read \(No such file or directory\); give a TOML file"):
        load_bench("nowhere.toml")


@pytest.mark.parametrize("name", BENCH_LIBRARY.names)
def test_benches_are_listed_and_printed_as_machines_are(name: str, tmp_path: Path) -> None:
    lines = list_values(*bench_tables(name))
    assert not {"kind", "name", "title"} & {line.path for line in lines}
    assert all(line.source for line in lines)
    path = tmp_path / "copy.toml"
    path.write_text(to_toml(*bench_tables(name)), encoding="utf-8")
    assert load_bench(path) == load_bench(name)
