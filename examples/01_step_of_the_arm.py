"""A step of the paper's arm: simulate, measure, look. Writes build/examples/01.png and 01.nc."""

from pathlib import Path

from layflat import rollout
from layflat.plot.runs import run_figure
from layflat.plot.style import save
from layflat.sim.dataset import save as save_run
from layflat.sim.metrics import air_used, moves_of

OUT = Path("build/examples")

run = rollout(
    "paper-arm",
    [("0 s", {"large": "-20 deg"}), ("0.5 s", {"large": "20 deg"}), ("2.5 s", {"large": "20 deg", "small": "30 deg"})],
    duration="4.5 s",
    payload=[("0 s", "1.5 kg"), ("2.5 s", "0.5 kg")],
)
for since, move in moves_of(run):
    print(f"{since:.2f} s  {move.joint:6s} settled in {move.settling:.2f} s")
print(f"air used: {air_used(run):.1f} normal litres")
save(run_figure(run), OUT / "01.png")
save_run(run, OUT / "01.nc")
