"""The ensemble on a CUDA device: in the simulator, through the device's compilers, and where there is a device."""

import os
import re
import subprocess
import sys
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numba
import numpy as np
import pytest
import xarray

from layflat.errors import InputError
from layflat.machine import load
from layflat.sim import Scenario
from layflat.sim.ensemble import ensemble

config: Any = numba.config

SIMULATED = """
import sys

import numpy as np

from layflat.sim import Scenario
from layflat.sim.ensemble import cuda, ensemble

cuda.BLOCK_THREADS, cuda.MAX_CHUNK = 2, 1  # so that even few runs are several chunks
done = []
cases = [Scenario(demand=[("0 s", -0.1), ("0.03 s", 0.1)], duration="0.1 s", seed=2),
         Scenario(demand=0.05, duration="0.1 s", load=[("0.05 s", "2 N m")], noise=False)]
many = ensemble(sys.argv[1], cases, {"scenario": [0, 1, 0], "arm.payload": [0.5, 1.0, 1.5]}, step="1 ms",
                traces=["angle", "pressure_a", "voltage"], every=3, device=sys.argv[2], progress=done.append)
assert sum(done) == 3, done
many.to_netcdf(sys.argv[3], engine="h5netcdf")
"""

FOUND = """
from layflat.sim import Scenario
from layflat.sim.ensemble import cuda, ensemble

ensemble("paper-small-joint", Scenario(duration="0.1 s"), runs=1, device="cuda")
print(sum(cuda._kernel(cuda.run_each, cuda.run_lanes, ()).stats.cache_hits.values()))
"""

BY_COMPILER = pytest.mark.skipif(find_spec("numba_cuda") is None, reason="needs the compilers of layflat[gpu]")


def simulated(name: str, device: str, folder: Path, **environment: str) -> xarray.Dataset:
    """Three runs of a machine, made by a Python of their own."""
    out = folder / f"{device}.nc"
    subprocess.run(
        [sys.executable, "-c", SIMULATED, name, device, str(out)], env={**os.environ, **environment}, check=True
    )
    with xarray.open_dataset(out, engine="h5netcdf") as data:
        return data.load()


@pytest.mark.parametrize("name", ["paper-arm", "paper-small-joint"])
def test_in_the_simulator_a_thread_is_a_lane(name: str, tmp_path: Path) -> None:
    here = simulated(name, "cpu", tmp_path)
    there = simulated(name, "cuda", tmp_path, NUMBA_ENABLE_CUDASIM="1", NUMBA_DISABLE_JIT="1")
    assert float(abs(here.angle).max()) > 0.05
    xarray.testing.assert_allclose(there, here, rtol=1e-9, atol=0.0)
    for trace in ("angle", "pressure_a", "voltage"):
        assert np.array_equal(there[trace], here[trace])


@BY_COMPILER
@pytest.mark.parametrize("name", ["paper-arm", "paper-small-joint", "earlier-actuator", "picking-arm"])
@pytest.mark.parametrize("precision", ["double", "single"])
def test_the_loop_becomes_machine_code_of_a_device(name: str, precision: str, monkeypatch: pytest.MonkeyPatch) -> None:
    cubin, ptx = assembled(name, precision, monkeypatch)
    assert len(cubin) > 10_000
    assert re.search(r"^\s*call", ptx, re.MULTILINE) is None, "not every law is inlined"


def assembled(name: str, precision: str, monkeypatch: pytest.MonkeyPatch) -> tuple[bytes, str]:
    """Machine code and assembly of the kernel for a machine. No device is needed, but one has to be named."""
    nvjitlink = pytest.importorskip("cuda.bindings.nvjitlink")
    compiler: Any = import_module("numba.cuda")
    from layflat.jit.device import device_kernel
    from layflat.physics.step import STEP
    from layflat.sim.ensemble import cuda as ours
    from layflat.sim.ensemble.block import allocate_results, make_block
    from layflat.sim.ensemble.cases import prepare_cases
    from layflat.sim.ensemble.parallel import NUMBER_TYPES
    from layflat.sim.run import make_timing

    monkeypatch.setattr("numba.cuda.dispatcher.get_current_device", lambda: SimpleNamespace(compute_capability=(8, 0)))
    machine = load(name)
    opening = None if all(joint.gains for joint in machine.joint.values()) else 0.0
    scenario, vary = Scenario(duration="0.1 s", opening=opening), {"seed": np.arange(3.0)}
    prepared = prepare_cases(machine, [scenario], vary, None, number=NUMBER_TYPES[precision])
    block = make_block(prepared, np.arange(3), (1e-3, 1e-3), allocate_results(prepared, np.array([0]), 1))
    timing = make_timing(prepared.cycle, STEP, 1, prepared.machine)
    types = tuple(map(numba.typeof, ours.kernel_arguments(prepared, block, timing)))
    device_kernel(ours.run_each)
    ptx, _ = compiler.compile_ptx(ours.run_each, types, cc=(8, 0))
    linker = nvjitlink.create(1, ["-arch=sm_80"])
    nvjitlink.add_data(linker, nvjitlink.InputType.PTX, ptx.encode(), len(ptx), "kernel.ptx")
    nvjitlink.complete(linker)
    cubin = bytearray(nvjitlink.get_linked_cubin_size(linker))
    nvjitlink.get_linked_cubin(linker, cubin)
    return bytes(cubin), ptx


def has_device() -> bool:
    """Whether there is a real device, and what it needs."""
    if find_spec("numba_cuda") is None or config.ENABLE_CUDASIM or config.DISABLE_JIT:
        return False
    return bool(import_module("numba.cuda").is_available())


@pytest.mark.gpu
@pytest.mark.skipif(not has_device(), reason="needs a CUDA device")
@pytest.mark.parametrize("name", ["paper-arm", "paper-small-joint"])
def test_on_a_device(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    from layflat.sim.ensemble import cuda

    monkeypatch.setattr(cuda, "MAX_CHUNK", 2**20)
    case = Scenario(demand=[("0 s", -0.3), ("0.2 s", 0.3)], duration="1.5 s")
    vary = {"arm.payload": np.linspace(0.0, 2.0, 1000), "seed": np.arange(1000.0)}
    here, there = (ensemble(name, case, vary, traces=["angle"], every=5, device=device) for device in ("cpu", "cuda"))
    assert float(np.degrees(abs(there.angle - here.angle)).max()) < 1e-6
    assert np.array_equal(there.settling, here.settling)
    for metric in ("overshoot", "steady_error", "tip_error", "air_used"):
        assert np.allclose(there[metric], here[metric], rtol=1e-6, atol=1e-9)


@pytest.mark.gpu
@pytest.mark.skipif(not has_device(), reason="needs a CUDA device")
@pytest.mark.parametrize("name", ["paper-arm", "picking-arm"])
def test_on_a_device_in_single_precision(name: str) -> None:
    n = len(load(name).joints)
    sway = Scenario(opening=[("0 s", (0.05,) * n), ("0.7 s", (-0.05,) * n)], duration="1.5 s", noise=False)
    many: dict[str, Any] = {"vary": {"arm.payload": np.linspace(0.1, 1.0, 500)}, "traces": ["angle"], "every": 5}
    here = ensemble(name, sway, **many)
    there = ensemble(name, sway, device="cuda", precision="single", **many)
    assert float(np.degrees(np.sqrt(np.mean((there.angle - here.angle) ** 2)))) < 0.01


@pytest.mark.gpu
@pytest.mark.skipif(not has_device(), reason="needs a CUDA device")
def test_a_second_start_finds_the_machine_code(tmp_path: Path) -> None:
    words = [sys.executable, "-c", FOUND]
    env = {**os.environ, "LAYFLAT_CACHE_DIR": str(tmp_path)}
    found = [subprocess.run(words, env=env, check=True, capture_output=True, text=True).stdout for _ in range(2)]
    assert found == ["0\n", "1\n"]


@pytest.mark.gpu
@pytest.mark.skipif(not has_device(), reason="needs a CUDA device")
def test_runs_that_no_device_has_room_for(monkeypatch: pytest.MonkeyPatch) -> None:
    from layflat.sim.ensemble import cuda

    monkeypatch.setattr(cuda, "MEMORY_PARTS", 2**50)
    with pytest.raises(InputError, match=r"device: a run takes .* MiB, and only 0 MiB of the CUDA device are left"):
        ensemble("paper-arm", Scenario(duration="1 s"), runs=1, device="cuda")


@pytest.mark.skipif(has_device(), reason="there is a device")
def test_no_device_is_one_line() -> None:
    with pytest.raises(
        InputError, match=r"^device: (needs numba-cuda, not installed; install|no CUDA device can be used \()"
    ) as caught:
        ensemble("paper-arm", Scenario(duration="0.01 s"), runs=1, device="cuda")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("error", "expected"),
    [
        (
            AttributeError("module 'numpy' has no attribute 'row_stack'"),
            ("are incomplete or incompatible (", "numpy ", "row_stack"),
        ),
        (
            ImportError("cannot import name 'x' from 'cuda.bindings'"),
            ("are incomplete or incompatible (", "cuda.bindings"),
        ),
        (RuntimeError("CUDA_ERROR_NO_DEVICE"), ("no CUDA device can be used (CUDA_ERROR_NO_DEVICE); see nvidia-smi",)),
    ],
)
def test_a_broken_package_is_not_taken_for_a_missing_device(error: Exception, expected: tuple[str, ...]) -> None:
    """numba-cuda 0.30.4 asks NumPy for row_stack, which NumPy 2.5 does not have."""
    from layflat.sim.ensemble.cuda import _explain_device_error

    line = str(_explain_device_error(error))
    assert all(word in line for word in expected), line
    assert ("pip install 'layflat[gpu]'" in line) == (not isinstance(error, RuntimeError))


def test_the_simulator_alone_is_not_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    from layflat.sim.ensemble import cuda

    cuda.check_device.cache_clear()  # a device that worked is not tried again
    monkeypatch.setattr(config, "ENABLE_CUDASIM", 1)
    with pytest.raises(InputError, match="NUMBA_DISABLE_JIT=1"):
        ensemble("paper-arm", Scenario(duration="0.01 s"), runs=1, device="cuda")


def test_a_device_that_fails_on_the_way_is_one_line() -> None:
    from layflat.sim.ensemble import cuda

    error = cuda.cuda.cudadrv.driver.CudaAPIError(2, "out of memory")
    with (
        pytest.raises(InputError, match=r"^device: the CUDA device failed \(\[2\] out of memory\); see nvidia-smi"),
        cuda._translate_device_errors(),
    ):
        raise error


def test_another_device_says_which_there_are() -> None:
    with pytest.raises(InputError, match='\'tpu\' is not a device; use "cpu" or "cuda"'):
        ensemble("paper-arm", Scenario(duration="0.01 s"), runs=1, device="tpu")
