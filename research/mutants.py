"""Mutation test of the laws: `python -m research.mutants --count 300 --seed 1 --out build/mutants.json`.

A mutant is the source with one small mistake, made by cosmic-ray. Of all mutants of `physics` and `control` some are
drawn, and the laws' own tests are run with each, the quickest first: those of the same name without compiler, then all
without, then those of the same name and of the whole plant compiled. A mutant that no test sees has survived; all that
did are told, with their difference.
"""

import argparse
import ast
import json
import os
import shutil
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import SimpleQueue
from tempfile import TemporaryDirectory

import numpy as np
from cosmic_ray.ast import ast_nodes, get_ast_from_path
from cosmic_ray.mutating import mutate_and_test
from cosmic_ray.plugins import get_operator, operator_names
from cosmic_ray.work_item import MutationSpec, TestOutcome

ROOT = Path(__file__).parents[1]
COPIED_PATHS = ("src", "tests", "pyproject.toml", "Makefile", "docs", "firmware", "benchmarks", "research")
MUTATED_ROOMS = ("physics", "control")
EQUIVALENT_OPERATORS = ("core/RemoveDecorator",)  # no effect: without the compiler decorators do nothing
BITWISE_OPERATORS = ("BitAnd", "BitOr", "BitXor", "LShift", "RShift")  # no float has them: anything sees such a mistake
INTERPRETED_ENVIRONMENT, COMPILED_ENVIRONMENT = "NUMBA_DISABLE_JIT=1", "LAYFLAT_CACHE_DIR=cache"
END_TO_END_TESTS = (
    "tests/physics/test_plant.py",
    "tests/sim/test_stepped_plant.py",
    "tests/rig/test_laws_of_ones_own.py",
)
TEST_TIMEOUT = 900.0  # of a group of tests with one mutant, s


def mutants(root: Path) -> Iterator[MutationSpec]:
    """Return every mutant of a copy of the project, except of annotations, docstrings and decorators."""
    for path in sorted(one for name in MUTATED_ROOMS for one in (root / "src/layflat" / name).rglob("*.py")):
        says = _beside_the_law(path)
        for name in operator_names():
            operator = get_operator(name)
            if name in EQUIVALENT_OPERATORS or name.endswith(BITWISE_OPERATORS) or operator.arguments():
                continue
            made = operator()
            places = (where for node in ast_nodes(get_ast_from_path(path)) for where in made.mutation_positions(node))
            for occurrence, (start, end) in enumerate(places):
                if not any(first <= start and end <= last for first, last in says):
                    yield MutationSpec(str(path.relative_to(root)), name, occurrence, start, end)


def _beside_the_law(path: Path) -> list[tuple[tuple[int, int], tuple[int, int]]]:
    nodes = list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))
    said = [getattr(node, key) for node in nodes for key in ("annotation", "returns") if getattr(node, key, None)]
    said += [one for node in nodes for one in getattr(node, "decorator_list", ())]
    return [((one.lineno, one.col_offset), (one.end_lineno, one.end_col_offset)) for one in said]


def drawn(every: list[MutationSpec], count: int, seed: int) -> list[MutationSpec]:
    """Return mutants at so many random places, at most one of each place."""
    rng, places = np.random.default_rng(seed), dict[object, list[MutationSpec]]()
    for mutant in every:
        places.setdefault((mutant.module_path, mutant.start_pos, mutant.end_pos), []).append(mutant)
    chosen = rng.permutation(len(places))[:count]
    return [own[rng.integers(len(own))] for own in (list(places.values())[i] for i in chosen)]


def tests_of(module: Path) -> list[tuple[str, list[str]]]:
    """Return groups of tests with their environment, those first that detect a mistake in a module soonest."""
    inner = module.relative_to("src/layflat")
    own = [f"tests/{inner.parent}/test_{inner.stem}.py", f"tests/{inner.parent}"]
    near = next(one for one in own if (ROOT / one).exists())
    every = [*(f"tests/{name}" for name in MUTATED_ROOMS), "tests/machine/test_parameters.py"]
    return [
        (INTERPRETED_ENVIRONMENT, [near]),
        *([(INTERPRETED_ENVIRONMENT, every)] if near not in every else []),
        (COMPILED_ENVIRONMENT, [near, *END_TO_END_TESTS]),
    ]


def tried(mutant: MutationSpec, copy: Path) -> dict[str, object]:
    """Run the tests with a mutant in a copy of the project."""
    spec = MutationSpec(
        str(copy / mutant.module_path), mutant.operator_name, mutant.occurrence, mutant.start_pos, mutant.end_pos
    )
    outcome, diff = TestOutcome.SURVIVED, ""
    for how, group in tests_of(mutant.module_path):
        tests = f"{sys.executable} -m pytest -x -q -p no:cacheprovider {' '.join(group)}"
        result = mutate_and_test([spec], f'sh -c "cd {copy} && PYTHONPATH=src {how} {tests}"', TEST_TIMEOUT)
        outcome, diff = result.test_outcome or TestOutcome.INCOMPETENT, result.diff or ""
        if outcome is not TestOutcome.SURVIVED:
            break
    place = f"{mutant.module_path}:{mutant.start_pos[0]}"
    return {"where": place, "what": mutant.operator_name, "outcome": outcome.value, "difference": diff}


def main() -> None:
    """Draw mutants, test them, and report."""
    asked = argparse.ArgumentParser(prog="python -m research.mutants", description=__doc__)
    asked.add_argument("--count", type=int, default=300)
    asked.add_argument("--seed", type=int, default=1)
    asked.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    asked.add_argument("--out", type=Path, default=Path("build/mutants.json"))
    given = asked.parse_args()
    given.out.parent.mkdir(parents=True, exist_ok=True)
    with TemporaryDirectory() as folder, ThreadPoolExecutor(given.workers) as pool:
        copies: SimpleQueue[Path] = SimpleQueue()
        for number in range(given.workers):
            copy = Path(folder) / str(number)
            for name in COPIED_PATHS:
                copier = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
                copy.mkdir(exist_ok=True)
                copier(ROOT / name, copy / name)
            copies.put(copy)
        every = list(mutants(copy))
        chosen = drawn(every, given.count, given.seed)

        def one(mutant: MutationSpec) -> dict[str, object]:
            mine = copies.get()
            try:
                return tried(mutant, mine)
            finally:
                copies.put(mine)

        found = []
        for result in pool.map(one, chosen):
            found.append(result)
            seen = sum(row["outcome"] != TestOutcome.SURVIVED for row in found)
            sys.stderr.write(f"\r{seen} of {len(found)} mutants were seen, {len(chosen)} of {len(every)} are tried ")
            rows = {"seed": given.seed, "mutants": len(every), "tried": len(found), "seen": seen, "rows": found}
            given.out.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    survivors = [row for row in found if row["outcome"] == TestOutcome.SURVIVED]
    for row in survivors:
        sys.stdout.write(f"\n{row['where']}: {row['what']}\n{row['difference']}\n")
    sys.stdout.write(f"{seen} of {len(found)} mutants were seen ({seen / len(found):.1%}); wrote {given.out}\n")


if __name__ == "__main__":
    main()
