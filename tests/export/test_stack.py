"""The stack that machine code takes, by the lines of its assembly."""

import pytest

from layflat.errors import CompilerError
from layflat.export.stack import stack_bytes

RISCV = "riscv32-unknown-none-elf"


@pytest.mark.parametrize(
    ("triple", "assembly", "size"),
    [
        (RISCV, "\taddi\tsp, sp, -256\n\tlui\ta7, 3\n\taddi\ta7, a7, 960\n\tsub\tsp, sp, a7\n", 256 + 3 * 4096 + 960),
        (RISCV, "\tlui\ta0, 2\n\tsub\tsp, sp, a0\n", 2 * 4096),
        (RISCV, "\tlui\ta0, 2\n\taddi\ta0, a0, -16\n\tsub\tsp, sp, a0\n", 2 * 4096 - 16),
        ("thumbv7em-unknown-none-eabihf", "\tpush\t{r4, r5, r6, lr}\n\tvpush\t{d8, d9}\n\tsub\tsp, #40\n", 72),
        ("aarch64-unknown-linux-gnu", "\tstp\tx29, x30, [sp, #-32]!\n\tsub\tsp, sp, #1, lsl #12\n", 32 + 4096),
        ("x86_64-unknown-linux-gnu", "\tpushq\t%rbx\n\tsubq\t$4000, %rsp\n", 8 + 8 + 4000),
    ],
)
def test_instructions_that_lower_the_stack_pointer_count(triple: str, assembly: str, size: int) -> None:
    assert stack_bytes(assembly, triple) == size


@pytest.mark.parametrize("triple", [RISCV, "thumbv7em-unknown-none-eabihf"])
def test_a_number_that_is_not_known_is_refused(triple: str) -> None:
    with pytest.raises(CompilerError, match="takes an unknown part of the stack"):
        stack_bytes("\tsub\tsp, sp, a0\n", triple)
