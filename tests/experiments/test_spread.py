"""What the paper's experiments come to over members."""

import json
from pathlib import Path

import numpy as np
import pytest

from layflat.experiments.bench import load_bench
from layflat.experiments.claim import Claim, ClaimQuantity
from layflat.experiments.reproduction import reproduce
from layflat.experiments.spread import evaluate_machines, quantity_ranges, write_ranges
from research.cloud.made import write
from research.cloud.open import built_in_shares


def claim(value: float, *, agrees: bool) -> Claim:
    return Claim("a", "here", "so", "if", (ClaimQuantity("time", value, "s"), ClaimQuantity("share", 0.5)), agrees)


def test_spreads_are_percentiles_and_tell_how_many_agree(tmp_path: Path) -> None:
    found = [[claim(float(i), agrees=i < 75)] for i in range(100)] + [[claim(np.inf, agrees=False)]]
    time, share = quantity_ranges(found)
    assert (time.claim, time.quantity, time.unit) == ("a", "time", "s")
    assert (time.low, time.median, time.high) == (5.0, 50.0, 95.0)
    assert time.agreeing == pytest.approx(75 / 101)
    assert (share.low, share.high) == (0.5, 0.5)
    told = json.loads(write_ranges(quantity_ranges(found[-1:]), 1, tmp_path / "cloud.json").read_text())
    assert told["members"] == 1
    assert told["quantities"][0]["high"] is None


@pytest.mark.compiled
def test_members_are_judged_as_machines_are(tmp_path: Path) -> None:
    file = tmp_path / "two.cloud.json"
    write(file, [built_in_shares(), np.clip(1.05 * built_in_shares(), 0.0, 1.0)], "make it")
    names = [f"paper-arm@{file}:{number}" for number in (0, 1)]
    found = list(evaluate_machines(names))
    pairs = zip(found[1], reproduce(load_bench(names[1])).claims, strict=True)
    assert all(one == same for one, same in pairs if one.id != "control-cycle"), "which is timed"
    assert found[0] != found[1]
