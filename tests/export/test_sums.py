"""Sums in emulated double precision: libgcc's with those that it rounds wrongly done anew, against this computer's."""

import shutil
import subprocess
from pathlib import Path

import numpy as np

from layflat.export.boards import EXAMPLE_BOARDS
from layflat.export.templates import fill_template
from tests.export.builds import needing, run

PROGRAM = """
#include <stdint.h>
#include <stdio.h>
#include <string.h>
extern __attribute__((pcs("aapcs"))) double layflat_dadd(double a, double b);
extern __attribute__((pcs("aapcs"))) double layflat_dsub(double a, double b);
static const uint64_t pairs[][2] = { %s };
static void print(double x) {
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    printf("%%08lx%%08lx\\n", (unsigned long)(bits >> 32), (unsigned long)(bits & 0xFFFFFFFFu));
}
int main(void) {
    for (unsigned i = 0; i < sizeof pairs / sizeof *pairs; i++) {
        double x[2];
        memcpy(x, pairs[i], sizeof x);
        print(layflat_dadd(x[0], x[1]));
        print(layflat_dsub(x[0], x[1]));
    }
    return 0;
}
"""
KNOWN = [(0xBDB0C81566517EF3, 0x3FC0000000000000), (0xC1F0000000000000, 0x3FE46E2DB1D809CF)]  # wrong by libgcc 12


def operands() -> list[tuple[int, int]]:
    """Return bits of numbers whose exponents differ by any number, mostly 33, and special ones."""
    random, pairs = np.random.default_rng(0), [*KNOWN]
    for _ in range(3000):
        gap = 33 if random.random() < 0.6 else int(random.integers(0, 70))
        signs, fractions = random.integers(0, 2, 2), random.integers(0, 1 << 52, 2)
        kept = random.integers(0, 53, 2)
        first, second = (int(f) >> int(k) << int(k) for f, k in zip(fractions, kept, strict=True))
        e = int(random.integers(80, 2000))
        pair = (int(signs[0]) << 63 | e << 52 | first, int(signs[1]) << 63 | (e - gap) << 52 | second)
        pairs.append(pair if random.random() < 0.5 else pair[::-1])
    zero, tiny, huge, infinite = 0, 1, 0x7FEFFFFFFFFFFFFF, 0x7FF0000000000000
    special = (zero, tiny, huge, infinite, 34 << 52, 33 << 52, 0x3FF0000000000000)
    return pairs + [(a, b) for a in special for b in special]


def test_sums_are_those_of_this_computer(tmp_path: Path) -> None:
    board, pairs = EXAMPLE_BOARDS["cortex-m4f"], operands()
    compiler, emulator = map(needing, board.tools)
    for name in ("startup.c", "board.ld", "sums.c"):
        (tmp_path / name).write_text(fill_template(name, title="sums", firmware=False, **board._asdict()))
    table = ", ".join(f"{{ UINT64_C({a}), UINT64_C({b}) }}" for a, b in pairs)
    (tmp_path / "main.c").write_text(PROGRAM % table)
    strict = ["-std=c99", "-O2", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror"]
    run([compiler, *board.options.split(), *strict, "-c", "sums.c"], tmp_path)
    linked = ["-nostartfiles", "--specs=rdimon.specs", "-Wl,-z,noexecstack", "-T", "board.ld", "-o", "sums.elf"]
    run([compiler, *board.options.split(), "-O2", "main.c", "sums.o", "startup.c", *linked], tmp_path)
    assert shutil.which(emulator)
    done = subprocess.run(
        [*board.emulator.split(), "sums.elf"], cwd=tmp_path, capture_output=True, text=True, timeout=300, check=True
    )
    results = np.array([int(line, 16) for line in done.stdout.split()], np.uint64).view(np.float64).reshape(-1, 2)
    a, b = np.array(pairs, np.uint64).view(np.float64).T
    with np.errstate(all="ignore"):
        expected = np.column_stack([a + b, a - b])
    invalid = np.isnan(expected)
    assert np.array_equal(np.isnan(results), invalid)
    assert np.array_equal(results[~invalid].view(np.uint64), expected[~invalid].view(np.uint64))
