"""Calls out of order, wrong values, states, and many instances: a status and a message, never a crash."""

import ctypes
import gc
import os
from math import inf, nan
from pathlib import Path

import numpy as np
import pytest

from tests.export.fmu.importer import ERROR, OK, Fmu, Instance
from tests.export.fmu.runs import CYCLE, RECORDED, REPORT, SEED, follow, names_of, rows_of, run_of

pytestmark = pytest.mark.compiled

PARTS = ("both", "plant", "controller")


def refused(instance: Instance, status: int, text: str) -> bool:
    return status == ERROR and text in instance.messages.pop() and not instance.messages


@pytest.mark.parametrize("value", [nan, inf, -inf])
def test_inputs_that_are_no_numbers(fmus: dict[str, Fmu], value: float) -> None:
    instance = Instance(fmus["both"]).begin()
    before = instance.get(["large.demand", "payload"])
    assert refused(instance, instance.set({"payload": 3.0, "large.demand": value}), "is not a number")
    assert instance.get(["large.demand", "payload"]) == before  # nothing of a call with a wrong value counts
    assert instance.step(0.0, CYCLE) == OK


@pytest.mark.parametrize("size", [0.0, -CYCLE, 1.5e-4, 0.4e-4, CYCLE * (1 + 1e-4), nan, inf, 1e300])
def test_steps_that_are_no_whole_number_of_plant_steps(fmus: dict[str, Fmu], size: float) -> None:
    for part in PARTS:
        instance = Instance(fmus[part]).begin()
        assert refused(instance, instance.step(0.0, size), "not a ")
        assert instance.step(0.0, CYCLE) == OK


@pytest.mark.parametrize("time", [CYCLE, -CYCLE, 1e-5, nan])
def test_steps_that_begin_elsewhere(fmus: dict[str, Fmu], time: float) -> None:
    instance = Instance(fmus["both"]).begin()
    assert refused(instance, instance.step(time, CYCLE), "")


def test_calls_out_of_order(fmus: dict[str, Fmu]) -> None:
    for part in PARTS:
        instance = Instance(fmus[part])
        for call in ("ExitInitializationMode", "Terminate"):
            assert refused(instance, instance.call(call), "out of order")
        assert refused(instance, instance.step(0.0, CYCLE), "out of order: the instance is instantiated")
        assert instance.initialize() == OK
        assert refused(instance, instance.step(0.0, CYCLE), "in initialization")
        assert instance.call("ExitInitializationMode") == OK
        assert refused(instance, instance.call("ExitInitializationMode"), "in its steps")
        assert instance.call("Terminate") == OK
        assert refused(instance, instance.step(0.0, CYCLE), "terminated")
        assert instance.call("Reset") == OK
        instance.begin()


def test_start_values_count_before_the_steps_alone(fmus: dict[str, Fmu]) -> None:
    instance = Instance(fmus["plant"])
    assert instance.set({"large.start": 0.25}) == OK
    assert instance.get(["large.angle"]) == [0.25]
    instance.begin()
    assert refused(instance, instance.set({"large.start": 0.0}), "can't be set now")
    assert refused(instance, instance.set({"large.angle": 0.0}), "can't be set now")


def test_parameters_that_make_no_machine(fmus: dict[str, Fmu]) -> None:
    instance = Instance(fmus["both"])
    assert refused(instance, instance.set({"plant.large.brake_torque": nan}), "is not a number")
    assert instance.set({"plant.large.hose_a.chamber.dead_volume": inf}) == OK
    instance.initialize()
    assert refused(instance, instance.call("ExitInitializationMode"), "can't rest with these parameters")


def test_a_machine_that_diverges(fmus: dict[str, Fmu]) -> None:
    instance = Instance(fmus["plant"]).begin()
    assert instance.set({"large.load": 1e300}) == OK
    assert refused(instance, instance.step(0.0, 0.1), "joint 1 diverged")
    assert refused(instance, instance.step(0.0, CYCLE), "failed")
    assert instance.call("Reset") == OK
    assert instance.begin().step(0.0, CYCLE) == OK


def test_unknown_references_missing_arrays_and_instances(fmus: dict[str, Fmu]) -> None:
    for part, fmu in fmus.items():
        instance, number = Instance(fmu), (ctypes.c_double * 1)()
        fmu.references["nothing"] = 10**6
        assert refused(instance, instance.set({"nothing": 1.0}), "no value reference")
        size = [ctypes.c_size_t(1)] * instance.third
        get = "GetFloat64" if instance.third else "GetReal"
        assert refused(instance, instance.call(get, None, ctypes.c_size_t(1), number, *size), "missing")
        instance.free()
        assert instance.call(get, None, ctypes.c_size_t(0), number, *size) == ERROR, part
        assert instance.step(0.0, CYCLE) == ERROR
        assert instance.call("Terminate") == ERROR
        instance.free()  # of nothing


def test_arrays_of_another_length(fmus: dict[str, Fmu]) -> None:
    instance = Instance(fmus["both"])
    if not instance.third:
        pytest.skip("FMI 2.0 has no length of values")
    reference, numbers = (ctypes.c_uint * 1)(0), (ctypes.c_double * 2)()
    status = instance.call("GetFloat64", reference, ctypes.c_size_t(1), numbers, ctypes.c_size_t(2))
    assert refused(instance, status, "an array of 2 values")


def test_instances_that_are_not_made(fmus: dict[str, Fmu]) -> None:
    for options, text in (
        ({"name": ""}, "no name"),
        ({"token": "{another}"}, "token"),
        ({"kind": 0}, "model exchange"),
    ):
        instance = Instance(fmus["both"], **options)
        assert instance.pointer is None
        assert text in instance.messages.pop()


def test_a_missing_logger(fmus: dict[str, Fmu]) -> None:
    instance = Instance(fmus["both"], logger=False)
    assert instance.step(0.0, CYCLE) == ERROR


def test_a_restored_state_goes_on_bit_for_bit(fmus: dict[str, Fmu]) -> None:
    run, signals = run_of(True), (*RECORDED, *REPORT)
    instance = Instance(fmus["both"])
    instance.set_noise(SEED, True)
    instance.begin()
    half = (run.sizes["time"] - 1) // 2
    follow(instance, run.isel(time=slice(0, half + 1)), ("demand",), ())
    state = instance.keep()
    content = instance.serialize(state)
    expected = rows_of(run, signals)[half:]
    assert np.array_equal(follow(instance, run, ("demand",), signals, half), expected)
    assert instance.restore(state) == OK
    assert np.array_equal(follow(instance, run, ("demand",), signals, half), expected)
    instance.release(state)
    other = Instance(fmus["both"], "two").begin()
    status, copy = other.deserialize(content)
    assert status == OK
    assert other.serialize(copy) == content
    assert other.restore(copy) == OK
    assert np.array_equal(follow(other, run, ("demand",), signals, half), expected)
    other.release(copy)


def test_states_that_are_none(fmus: dict[str, Fmu]) -> None:
    instance, other = Instance(fmus["both"]).begin(), Instance(fmus["plant"]).begin()
    state = instance.keep()
    content = instance.serialize(state)
    name = "FMUState" if instance.third else "FMUstate"
    buffer = ctypes.create_string_buffer(8)
    status = instance.call(f"Serialize{name}", state, buffer, ctypes.c_size_t(8))
    assert refused(instance, status, "the buffer has 8 bytes")
    assert refused(instance, instance.restore(ctypes.c_void_p()), "missing")
    for wrong in (content[:-1], content[:100] + bytes([content[100] ^ 1]) + content[101:], bytes(len(content)), b""):
        status, none = instance.deserialize(wrong)
        assert refused(instance, status, "")
        assert not none
    assert other.deserialize(content)[0] == ERROR
    instance.release(state)


def test_two_instances_side_by_side(fmus: dict[str, Fmu]) -> None:
    run, signals = run_of(True), ("angle", "measured_pressure", "voltage")
    one, two = Instance(fmus["both"], "one"), Instance(fmus["both"], "two")
    for instance in (one, two):
        instance.set_noise(SEED, True)
        instance.begin()
    rows: dict[str, list[list[list[float]]]] = {"one": [], "two": []}
    for k in range(60):
        for name, instance in (("one", one), ("two", two)):
            demand = run["demand"].values[k] if name == "one" else -run["demand"].values[k]
            assert instance.set(dict(zip(names_of("demand"), demand.tolist(), strict=True))) == OK
            assert instance.step(k * CYCLE, CYCLE) == OK
            rows[name].append([instance.get(names_of(signal)) for signal in signals])
    assert np.array_equal(rows["one"], rows_of(run, signals)[:60])
    assert rows["one"] != rows["two"]


def test_libraries_with_global_names_keep_apart(fmus: dict[str, Fmu], fmu_folder: Path, tmp_path: Path) -> None:
    """An importer may load libraries so that their names are global; each still calls its own functions."""
    if not hasattr(os, "RTLD_GLOBAL"):
        pytest.skip("this system has no global names of libraries")
    end = fmus["both"].file.parent.name
    paths = [fmu_folder / f"paper-arm{part}-fmi{3 if fmus['both'].third else 2}.fmu" for part in ("-plant", "")]
    plant, both = (Fmu(path, tmp_path / path.stem, (end, end), ctypes.RTLD_GLOBAL) for path in paths)
    run = run_of(False)
    instances = Instance(plant), Instance(both)
    for instance in instances:
        instance.set_noise(0, False)
        instance.begin()
    assert np.array_equal(follow(instances[0], run, ("voltage",), ("angle",)), rows_of(run, ("angle",)))
    assert np.array_equal(follow(instances[1], run, ("demand",), ("angle",)), rows_of(run, ("angle",)))


def test_a_thousand_instances_leave_no_memory(fmus: dict[str, Fmu]) -> None:
    statm = Path("/proc/self/statm")
    if not statm.exists():
        pytest.skip("this system does not report the memory of a process in /proc")

    def live() -> None:
        instance = Instance(fmus["both"]).begin()
        state = instance.keep()
        status, copy = instance.deserialize(instance.serialize(state))
        assert status == OK
        instance.release(copy)
        assert instance.step(0.0, CYCLE) == OK
        instance.release(state)
        instance.free()

    def resident() -> int:
        gc.collect()  # an importer refers to itself by its callbacks
        return int(statm.read_text().split()[1]) * os.sysconf("SC_PAGESIZE")

    def growth() -> int:
        before = resident()
        for _ in range(1000):
            live()
        return resident() - before

    # What Python and its libraries allocate comes at once; a leak of instances comes every time.
    assert min(growth() for _ in range(3)) < 100_000
