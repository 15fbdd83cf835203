"""Instruction scheduling of kernels, such that a processor waits less for results.

The compiler leaves instructions in the order of the laws: chains, in which every number waits for the one before. A
processor looks a few hundred instructions ahead, which is a fraction of a step of the plant. So long blocks are put
into the order in which an ideal processor would begin their instructions (list scheduling): first those that can begin
earliest, and of those the one with the longest path to the end of the block; but none far ahead of the oldest waiting
instruction, since there are not enough registers to keep its result.

No instruction changes, hence no bit of a result. The work is done on LLVM's text, as llvmlite can't move instructions.
"""

import itertools
import re
from collections.abc import Iterator, Sequence
from typing import NamedTuple

MIN_BLOCK_LENGTH, MAX_BLOCK_LENGTH, MAX_VECTOR_BITS = 200, 800, 512
"""Lengths of blocks that are scheduled, instructions: a step of two joints has 400, the code of a cycle up to 150.

A step of four joints in space has more. It gains for one arm, but for many side by side, in vectors of more than
`MAX_VECTOR_BITS`, so many results have to be kept that it took a sixth longer in this order.
"""

LOOKAHEAD_INSTRUCTIONS = 150  # instructions ahead of the oldest one that waits
ISSUE_BITS = 1024  # bits of instructions that begin in a cycle: four registers of AVX2

LATENCY_CYCLES = {"fadd": 3, "fsub": 3, "fmul": 3, "fdiv": 13, "sqrt": 20}
"""Latencies on common processors, cycles; of all other instructions one."""

PURE_OPERATIONS = {
    "add",
    "sub",
    "mul",
    "and",
    "or",
    "xor",
    "shl",
    "lshr",
    "ashr",
    "icmp",
    "fcmp",
    "fadd",
    "fsub",
    "fmul",
    "fdiv",
}
PURE_OPERATIONS |= {
    "fneg",
    "select",
    "shufflevector",
    "extractelement",
    "insertelement",
    "getelementptr",
    "sext",
    "zext",
    "trunc",
}
PURE_OPERATIONS |= {"bitcast", "sitofp", "fptosi", "uitofp", "fpext", "fptrunc"}
"""Instructions that neither read nor write memory. All others but loads may write it, and stay in order."""

_NAME_PATTERN = r'%(?:"[^"]+"|[\w.$-]+)'
_VALUE_NAME = re.compile(_NAME_PATTERN)
_ASSIGNED_INSTRUCTION = re.compile(rf"  ({_NAME_PATTERN}) = (?:tail )?(\w+)")
_INTRINSIC_CALL = re.compile(r"@llvm\.(fabs|sqrt|floor|minnum|maxnum|minimum|maximum|copysign)\.")
_LOAD_INSTRUCTION = re.compile(r" = load (?!atomic|volatile)")
_VECTOR_SIZE = re.compile(r"<(\d+) x (double|float)>")
_NUMBER_OR_LONG = r'(\d+(?![\w.$-])|[\w.$-]{200,}|"[^"]{200,}")'
_UNREADABLE_NAME, _UNREADABLE_LABEL = re.compile(f"(%){_NUMBER_OR_LONG}"), re.compile(f"^(){_NUMBER_OR_LONG}(?=:)")
_BLOCK_LABEL = re.compile(r'(?:"[^"]+"|[\w.$-]+):')
_BLOCK_TERMINATOR = re.compile(r"  (?:br|switch|ret|unreachable|indirectbr|resume)\b")


class Instruction(NamedTuple):
    """Instruction: text, name of its result, latency and issue time (cycles), and access to memory."""

    text: str
    name: str
    latency: int
    takes: float
    reads: bool
    writes: bool


def order_instructions(module: str) -> str:
    """Return LLVM's text of a module, its long blocks scheduled and values renamed; without such blocks unchanged."""
    lines = module.split("\n")
    blocks = [(first, last) for first, last in _instruction_blocks(lines) if _is_worth_ordering(lines[first:last])]
    lines = _rename_unreadable(module) if blocks else [module]
    for first, last in blocks:
        lines[first:last] = _schedule(lines[first:last])
    return "\n".join(lines)


def _rename_unreadable(module: str) -> list[str]:
    """Return the lines of a module with short, named values in place of numbered ones and names too long for LLVM.

    Numbered values would have to stay in order.
    """
    letters = next(name for name in ("n" * count for count in itertools.count(1)) if f"%{name}" not in module)
    short: dict[str, str] = {}

    def renamed(match: re.Match[str]) -> str:
        return match[1] + short.setdefault(match[2], f"{letters}{len(short)}")

    return [
        _UNREADABLE_NAME.sub(renamed, line)
        if line.startswith(("  ", "define"))
        else _UNREADABLE_LABEL.sub(renamed, line)
        for line in module.split("\n")
    ]


def _instruction_blocks(lines: Sequence[str]) -> Iterator[tuple[int, int]]:
    """Yield the indices of two lines of each block: the first instruction that is no phi, and the one that leaves."""
    first = 0
    for i, line in enumerate(lines):
        if _BLOCK_LABEL.match(line) or line.startswith("define") or " = phi " in line:
            first = i + 1
        elif _BLOCK_TERMINATOR.match(line):
            yield first, i


def _is_worth_ordering(lines: Sequence[str]) -> bool:
    """Return whether a block is worth scheduling: long, and not both longer than usual and of wide vectors.

    Limits are `MIN_BLOCK_LENGTH`, `MAX_BLOCK_LENGTH` and `MAX_VECTOR_BITS`, each inclusive.
    """
    return len(lines) >= MIN_BLOCK_LENGTH and (
        len(lines) <= MAX_BLOCK_LENGTH or max(map(_vector_bits, lines)) <= MAX_VECTOR_BITS
    )


def _vector_bits(line: str) -> int:
    """Return the size of the first vector of floats in a line; 64 where there is none."""
    size = _VECTOR_SIZE.search(line)
    return int(size[1]) * (64 if size[2] == "double" else 32) if size else 64


def _parse_instruction(line: str) -> Instruction:
    """Return a line of LLVM text as an instruction; operations not known as pure or loads count as writes."""
    match = _ASSIGNED_INSTRUCTION.match(line)
    name, operation = match.groups() if match else ("", "")
    intrinsic = _INTRINSIC_CALL.search(line) if operation == "call" else None
    latency = LATENCY_CYCLES.get(intrinsic[1] if intrinsic else operation, 1)
    pure, reads = bool(intrinsic) or operation in PURE_OPERATIONS, _LOAD_INSTRUCTION.search(line) is not None
    return Instruction(line, name, latency, max(_vector_bits(line), 256) / ISSUE_BITS, reads, not pure and not reads)


def _dependencies(instructions: Sequence[Instruction]) -> list[set[int]]:
    """Return, for each instruction of a block, the indices of those that have to precede it."""
    places = {each.name: i for i, each in enumerate(instructions) if each.name}
    needs: list[set[int]] = []
    written, read = set[int](), set[int]()
    for i, each in enumerate(instructions):
        needed = {places[name] for name in _VALUE_NAME.findall(each.text) if name in places} - {i}
        if each.reads:
            needed |= written
            read.add(i)
        elif each.writes:
            needed |= written | read
            written, read = {i}, set()
        needs.append(needed)
    return needs


def _schedule(lines: Sequence[str]) -> list[str]:
    """Return the lines of a block in the order of list scheduling.

    Among the next `LOOKAHEAD_INSTRUCTIONS` the one that can begin first is next, then the one with the longest path.
    """
    instructions = [_parse_instruction(line) for line in lines]
    needs = _dependencies(instructions)
    users: list[list[int]] = [[] for _ in lines]
    for i, before in enumerate(needs):
        for j in before:
            users[j].append(i)
    paths = [0.0] * len(lines)  # longest latency to the end of the block, cycles
    for i in reversed(range(len(lines))):
        paths[i] = instructions[i].latency + max((paths[user] for user in users[i]), default=0.0)
    missing = [len(before) for before in needs]
    ready = {i for i, count in enumerate(missing) if not count}
    begins, now, waits, order = [0.0] * len(lines), 0.0, 0, list[int]()
    done = [False] * len(lines)
    while ready:
        while done[waits]:
            waits += 1
        near = [i for i in ready if i < waits + LOOKAHEAD_INSTRUCTIONS]
        best = min(near, key=lambda i: (max(begins[i], now), -paths[i], i))
        ready.remove(best)
        order.append(best)
        done[best] = True
        start = max(begins[best], now)
        now = start + instructions[best].takes
        for user in users[best]:
            begins[user] = max(begins[user], start + instructions[best].latency)
            missing[user] -= 1
            if not missing[user]:
                ready.add(user)
    return [lines[i] for i in order]
