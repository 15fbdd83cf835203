"""FMUs of all kinds of machines repeat a run of 2 s; and laws that can't be exported say so."""

import json
import os
import re
from pathlib import Path

import numpy as np
import pytest

import layflat as lf
from layflat.errors import KindError
from layflat.export.fmu import libraries, writer
from layflat.machine import Machine, load
from layflat.sim.kernel import JointRecord
from tests.export.fmu.importer import OK, Fmu, Instance
from tests.test_outside_kinds import COMPILED, DESCRIBED, PAGE, own_sources

pytestmark = pytest.mark.compiled

OUTSIDE = "kinds of docs/kinds.md"
MACHINES = ("paper-arm", "paper-arm-tracking", "picking-arm", OUTSIDE)
ALL_SYSTEMS_LIMIT = 200_000  # of an FMU for Linux, Windows and macOS, bytes


def outside_machine(folder: Path, names: list[str]) -> Machine:
    for block in re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL):
        (folder / block.split("\n")[0].removeprefix("# ")).write_text(block, encoding="utf-8")
    head = (
        f'extends = "paper-small-joint-fast"\nname = "outside"\nkinds = {json.dumps([f"{name}.py" for name in names])}'
    )
    (folder / "outside.toml").write_text("\n\n".join([head, *(DESCRIBED[name] for name in names)]), encoding="utf-8")
    return load(folder / "outside.toml")


@pytest.mark.parametrize("name", MACHINES)
def test_a_run_of_any_machine_is_repeated(
    name: str, compiler: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if not os.environ.get("LAYFLAT_EXPORT_CHECK"):
        pytest.skip("compiles for minutes: set LAYFLAT_EXPORT_CHECK=1")
    monkeypatch.setattr(libraries, "find_spec", lambda _: None)
    system = libraries.host_system()
    assert system is not None
    with own_sources():
        machine = outside_machine(tmp_path, COMPILED) if name == OUTSIDE else load(name)
        run = lf.rollout(machine, [("0.1 s", "5 deg")], seed=3, duration="2 s")
        files = writer.write_fmus(machine, tmp_path / "fmus", target="fmu", precision="double")
        first = next(iter(files))
    instance = Instance(Fmu(first, tmp_path / "unpacked", (system.folder_2, system.folder)))
    instance.set_noise(3, True)
    instance.begin()
    signals, joints = [one for one in JointRecord._fields if one != "voltage"], list(machine.joints)
    outputs = [f"{joint}.{one}" for one in signals for joint in joints]
    for k in range(run.sizes["time"] - 1):
        demand = run["demand"].values[k].tolist()
        assert instance.set({f"{joint}.demand": q for joint, q in zip(joints, demand, strict=True)}) == OK
        assert instance.step(k * machine.cycle, machine.cycle) == OK, instance.messages
        rows = np.reshape(instance.get(outputs), (len(signals), len(joints)))
        assert np.array_equal(rows, [run[one].values[k + 1] for one in signals])


def test_fmus_of_three_systems_are_small(tmp_path: Path) -> None:
    pytest.importorskip("ziglang", reason="needs ziglang: pip install 'layflat[export]'")
    files = list(writer.write_fmus(load("paper-arm"), tmp_path / "fmus", target="fmu", precision="double"))
    for path in files[:-1]:
        assert path.stat().st_size < ALL_SYSTEMS_LIMIT
        folders = [system.folder_2 if "fmi2" in path.name else system.folder for system in libraries.LINKED_SYSTEMS]
        assert all(f"binaries/{folder}/".encode() in path.read_bytes() for folder in folders if folder)


def test_a_law_in_plain_python_is_refused(tmp_path: Path, compiler: str) -> None:
    with own_sources():
        machine = outside_machine(tmp_path, ["plain_relay"])
        with pytest.raises(KindError, match="is plain Python; it can't run in C; decorate its functions"):
            list(writer.write_fmus(machine, tmp_path / "fmus", target="fmu", precision="double"))
