"""Study files to start from."""

from pathlib import Path

SMALL = """
name = "small"
machine = "paper-small-joint"
sampling = "grid"
metrics = ["settling", "air_used"]

[scenario]
duration = "0.2 s"
demand = [["0 s", "-10 deg"], ["0.05 s", "10 deg"]]

[vary."joint.small.brake.torque"]
low = "0 N m"
high = "4 N m"
points = 6

[vary."scenario.payload"]
values = ["0 kg", "1 kg", "2 kg", "3 kg"]
"""
"""24 runs, on a grid."""

SOBOL = SMALL.replace('"grid"', '"sobol"').replace("[scenario]", "runs = 8\n\n[scenario]", 1)


def written(folder: Path, text: str = SMALL) -> Path:
    path = folder / "study.toml"
    path.write_text(text, encoding="utf-8")
    return path


def without(text: str, table: str) -> str:
    """A study file less one of its tables."""
    head, _, rest = text.partition(f"[{table}]")
    return head + ("[" + rest.split("\n[", 1)[1] if "\n[" in rest else "")
