"""Compute digests, and compare them: see the package's docstring."""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
import traceback
from collections.abc import Callable
from functools import partial
from pathlib import Path

# Sums of other libraries must not depend on how many cores there are.
os.environ.update({f"{library}_NUM_THREADS": "1" for library in ("OMP", "OPENBLAS", "MKL")})

import numpy as np

import benchmarks.digests as package
from benchmarks.digests import compare, rigs, runs, tasks
from layflat.files import whole_file

ITEMS: dict[str, Callable[[], runs.Arrays]] = {
    **{f"rollout {name}": partial(runs.rollouts, name) for name in runs.MOVING},
    **{f"ensemble {name}": partial(runs.ensembles, name) for name in runs.MOVING},
    "sweeps": runs.sweeps,
    "stepped plant": runs.stepped,
    "mujoco": runs.in_mujoco,
    "rig": rigs.healthy,
    "rig with faults": rigs.faulty,
    "studies": tasks.studies,
    "identification": tasks.identification,
    "tuning": tasks.tuning,
    "design": tasks.designs,
    "packing": tasks.packing,
    "packing without camera": tasks.packing_blind,
}


def computed(only: list[str], known: dict[str, np.ndarray]) -> compare.Content:
    """Digests by item, and the arrays put into `known`."""
    chosen = [name for name in ITEMS if not only or any(name.startswith(one) for one in only)]
    items: dict[str, compare.Content] = {}
    for number, name in enumerate(chosen, start=1):
        begin = time.perf_counter()
        try:
            arrays = {key: compare.array(values) for key, values in ITEMS[name]().items()}
            digests = {key: compare.digest(values) for key, values in arrays.items()}
            known.update({f"{name}/{key}": values for key, values in arrays.items()})
            items[name] = {"digest": compare.overall(digests), "arrays": digests}
        except tasks.NotPossibleError as error:
            items[name] = {"skipped": " ".join(str(error).split())}
        except Exception as error:  # one item does not hide the others
            traceback.print_exc()
            items[name] = {"error": " ".join(f"{type(error).__name__}: {error}".split())}
        found = next(f"{key} {value}" for key, value in items[name].items() if key != "arrays")
        print(f"{number:2d}/{len(chosen)} {name:38s} {found}  {time.perf_counter() - begin:.1f} s", flush=True)
    digests = {name: item["digest"] for name, item in items.items() if "digest" in item}
    return {"revision": compare.revision(), "digest": compare.overall(digests), "items": items}


def main() -> int:
    """Compute, write, compare; exit status 1 where an item failed or differs."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.digests", description=package.__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    parser.add_argument("--out", type=Path, default=Path("build/digests.json"), help="JSON; the arrays go beside it")
    parser.add_argument("--only", action="append", default=[], metavar="NAME", help=f"of {', '.join(ITEMS)}")
    parser.add_argument("--against", metavar="REVISION|FILE.json", help="compare with a commit, or with stored digests")
    given = parser.parse_args()
    if not any(name.startswith(one) for name in ITEMS for one in given.only or [""]):
        parser.error(f"--only: no item {given.only[0]!r}; give one of {', '.join(ITEMS)}")
    arrays: dict[str, np.ndarray] = {}
    content = computed(given.only, arrays)
    with whole_file(given.out) as temporary:
        temporary.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    with whole_file(given.out.with_suffix(".npz")) as temporary, temporary.open("wb") as file:
        np.savez_compressed(file, allow_pickle=False, **arrays)
    print(f"{content['digest']} of revision {content['revision']}, in {given.out}")
    if given.against is None:
        return int(any("error" in item for item in content["items"].values()))
    stored = given.against.endswith(".json")
    other, theirs = (
        compare.stored(Path(given.against)) if stored else compare.of_revision(given.against, given.only)
    )  # fmt: skip
    if given.only:
        other["items"] = {name: item for name, item in other["items"].items() if name in content["items"]}
    found = compare.differences(content, other, arrays, theirs)
    print(f"\nagainst revision {other['revision']}")
    for name, (same, text) in found.items():
        print(f"{'  ' if same else '! '}{name:38s} {text}")
    wrong = sum(not same for same, _ in found.values())
    print(f"{wrong} of {len(found)} items differ" if wrong else f"all {len(found)} items are the same")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
