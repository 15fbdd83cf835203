"""Machines in WebAssembly beside those of tests/export/matrix.py, in `make export-check`, and how fast it all is."""

import os
import time
from pathlib import Path

import numpy as np
import pytest

from layflat.export.web.folder import write_folder
from layflat.export.web.module import WebMachine
from layflat.machine import load
from layflat.motion.scenario import Scenario
from layflat.sim.run import prepare_run
from tests.export.web.engines import run_text
from tests.export.web.traces import check_trace, node_trace

pytestmark = pytest.mark.skipif("LAYFLAT_EXPORT_CHECK" not in os.environ, reason="takes long: in make export-check")

SPEED = """
import { load } from "./index.js";
const begun = performance.now();
const machine = await load(), plant = machine.plant(), controller = machine.controller("paper");
const instantiated = performance.now() - begun;
controller.wake(plant.sample());
let best = 0;
for (let run = 0; run < 40; run++) {
  controller.demand.angle.set([0.35, -0.5].map((angle) => (run % 2 ? -angle : angle)));
  const start = performance.now();
  for (let k = 0; k < 2000; k++) { plant.drive(controller.step(plant.sample())); plant.advance(); }
  best = Math.max(best, 2000 * machine.cycle / (performance.now() - start) * 1000);
}
console.log(JSON.stringify({ instantiated, rate: best }));
"""


@pytest.mark.parametrize("target", ["wasm", "wasm-plain"])
@pytest.mark.parametrize("name", ["paper-arm-switching", "single-joint-lift"])
def test_every_machine_and_law_is_the_host_to_the_bit(name: str, target: str, tmp_path: Path) -> None:
    machine = load(name)
    list(write_folder(machine, tmp_path / "out", target=target, precision="double"))
    for law in WebMachine(machine).laws:
        trace = node_trace(tmp_path / "out", tmp_path, machine, law)
        check_trace(trace, machine, law, interpreted=20)
        assert np.ptp(trace["angle"]) > 0.3  # it moves


def test_it_is_nearly_as_fast_as_the_hosts_loop(tmp_path: Path) -> None:
    """Side by side, as the computer may have other work; runs of 10 s each, with their controller."""
    machine = load("paper-arm")
    list(write_folder(machine, tmp_path / "out", target="wasm", precision="double"))
    demand = {"large": 0.35, "small": -0.5}
    case = prepare_run(machine, Scenario(demand=demand, start=0.0, duration=10.0))
    case.run()
    rates, native = [], 0.0
    for _ in range(3):
        rates.append(run_text(tmp_path / "out", SPEED))
        for _ in range(40):
            begun = time.perf_counter()
            case.run()
            native = max(native, 10.0 / (time.perf_counter() - begun))
    best = max(one["rate"] for one in rates)
    print(f"wasm {best:.0f} s/s, native {native:.0f} s/s, start {min(one['instantiated'] for one in rates):.1f} ms")  # noqa: T201
    assert best > 0.45 * native
    assert min(one["instantiated"] for one in rates) < 500.0  # ms
