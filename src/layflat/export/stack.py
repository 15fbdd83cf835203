"""Stack that machine code needs, by the instructions of its assembly that lower the stack pointer.

Such instructions stand at the start of a function, and LLVM's portable code holds no allocation of a variable size. So
the sum over a module is an upper bound of what its functions take together: each would have to be called by another.
"""

import re
from collections.abc import Callable
from typing import NamedTuple

from layflat.errors import CompilerError

MAX_ALIGNMENT = 64  # bytes by which a realigned stack pointer is lowered at most

RETURN_ADDRESS = 8  # that a call pushes on x86-64, bytes


class _Pattern(NamedTuple):
    """Instruction that lowers the stack pointer, and the number of bytes."""

    text: str
    size: Callable[[re.Match[str]], int]


def _number(match: re.Match[str]) -> int:
    return int(match["n"])


def _aligned(_: re.Match[str]) -> int:
    return MAX_ALIGNMENT


def _register_bytes(match: re.Match[str]) -> int:
    """Return the size of a list of ARM registers, such as "r4-r7, lr" or "d8-d15"."""
    count = 0
    for part in match["list"].split(","):
        first, _, last = part.strip().partition("-")
        count += int(last[1:]) - int(first[1:]) + 1 if last else 1
    return count * (8 if match["list"].lstrip().startswith("d") else 4)


THUMB_PATTERNS = (
    _Pattern(r"(?:push(?:\.w)?|vpush|v?stmdb\s+sp!,)\s+\{(?P<list>[^}]*)\}", _register_bytes),
    _Pattern(r"sub(?:\.w|w)?\s+sp, (?:sp, )?#(?P<n>\d+)", _number),
    _Pattern(r"(?:str|strd)(?:\.w)?\s.*\[sp, #-(?P<n>\d+)\]!", _number),
    _Pattern(r"bfc\s+\w+, #0, #\d+", _aligned),
)
AARCH64_PATTERNS = (
    _Pattern(r"st[rp]\s.*\[sp, #-(?P<n>\d+)\]!", _number),
    _Pattern(r"sub\s+sp, sp, #(?P<n>\d+), lsl #12", lambda match: int(match["n"]) << 12),
    _Pattern(r"sub\s+sp, sp, #(?P<n>\d+)$", _number),
    _Pattern(r"and\s+sp, ", _aligned),
)
X86_64_PATTERNS = (
    _Pattern(r"pushq\s", lambda _: RETURN_ADDRESS),
    _Pattern(r"callq?\s", lambda _: RETURN_ADDRESS),
    _Pattern(r"subq\s+\$(?P<n>\d+), %rsp", _number),
    _Pattern(r"(?:addq\s+\$|leaq\s+)-(?P<n>\d+)(?:\(%rsp\))?, %rsp", _number),
    _Pattern(r"andq\s+\$-\d+, %rsp", _aligned),
    # Windows has a page of a large stack touched before it is used.
    _Pattern(r"movl\s+\$(?P<n>\d+), %eax\s+callq\s+__+chkstk\w*\s+subq\s+%rax, %rsp", _number),
)
RISCV_PATTERNS = (
    _Pattern(r"(?:c\.)?addi(?:16sp)?\s+sp, (?:sp, )?-(?P<n>\d+)", _number),
    _Pattern(r"andi\s+sp, sp, -\d+", _aligned),
    _Pattern(
        r"lui\s+(?P<r>\w+), (?P<high>\d+)(?:\s+addi\s+(?P=r), (?P=r), (?P<low>-?\d+))?\s+sub\s+sp, sp, (?P=r)",
        lambda match: (int(match["high"]) << 12) + int(match["low"] or 0),
    ),
)
STACK_PATTERNS = {
    "thumb": THUMB_PATTERNS,
    "aarch64": AARCH64_PATTERNS,
    "arm64": AARCH64_PATTERNS,
    "x86_64": X86_64_PATTERNS,
    "riscv32": RISCV_PATTERNS,
}
"""Instructions that lower the stack pointer, by the start of LLVM's triple."""

BY_REGISTER = re.compile(r"^\s*sub\S*\s+(?:sp, (?:sp, )?(?!sp\b)[a-z]\w*|%\w+, %rsp)", re.MULTILINE)
"""Instruction that lowers the stack pointer by a register, whose value no single line states."""


def stack_bytes(assembly: str, triple: str) -> int:
    """Return an upper bound of the stack that the functions of a module take, their callees outside excluded.

    Args:
        assembly: text of the module's assembly.
        triple: LLVM's name of the processor and system.

    Raises:
        CompilerError: the processor has no patterns, or an instruction lowers the stack pointer by an unknown number.
    """
    patterns = next((found for start, found in STACK_PATTERNS.items() if triple.startswith(start)), None)
    if patterns is None:
        raise CompilerError(f"no table of the instructions of {triple} that take stack")
    size = RETURN_ADDRESS if patterns is X86_64_PATTERNS else 0
    for pattern in sorted(patterns, key=lambda one: r"\s+sub" not in one.text):  # those of several lines first
        compiled = re.compile(rf"^\s*{pattern.text}", re.MULTILINE)
        size += sum(pattern.size(match) for match in compiled.finditer(assembly))
        if r"\s+sub" in pattern.text:
            assembly = compiled.sub("", assembly)
    unknown = BY_REGISTER.search(assembly)
    if unknown is not None:
        raise CompilerError(f"{unknown[0].strip()!r} takes an unknown part of the stack of {triple}")
    return size
