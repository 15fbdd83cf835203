"""The order of a kernel's instructions, such that a processor waits less for what it computes.

The compiler leaves instructions about as laws stand in a kernel: chains, in which every number waits for the one
before. A processor looks a few hundred instructions ahead for what else it could do, which is a fraction of a step of
the plant. So long blocks are put into the order in which an ideal processor would begin their instructions (list
scheduling): first what can begin first, and of those what the longest way to the end of the block hangs on; but nothing
far ahead of where the block stands, since the processor would not have the registers to keep it.

No instruction changes, hence no bit of a result. All is done on LLVM's text, as llvmlite can't move instructions.
"""

import itertools
import re
from collections.abc import Iterator, Sequence
from typing import NamedTuple

LONG, LONGEST, WIDE = 200, 800, 512
"""Instructions of blocks that are worth it: a step of two joints has 400, what is done once a cycle up to 150.

A step of four joints in space has more. For one arm that is as well, but for many side by side, in vectors of more than
`WIDE` bits, it has so much to keep that it took a sixth longer in order than as it stood.
"""

AHEAD = 150  # instructions, of the first that waits
AT_ONCE = 1024  # bits that are begun in a cycle: four registers of AVX2

LATENCY = {"fadd": 3, "fsub": 3, "fmul": 3, "fdiv": 13, "sqrt": 20}
"""Cycles until a result is there, on common processors; of all else one."""

PURE = {"add", "sub", "mul", "and", "or", "xor", "shl", "lshr", "ashr", "icmp", "fcmp", "fadd", "fsub", "fmul", "fdiv"}
PURE |= {"fneg", "select", "shufflevector", "extractelement", "insertelement", "getelementptr", "sext", "zext", "trunc"}
PURE |= {"bitcast", "sitofp", "fptosi", "uitofp", "fpext", "fptrunc"}
"""What neither reads nor writes memory. All else may write it, but for loads, and stays in order."""

_NAME = r'%(?:"[^"]+"|[\w.$-]+)'
_NAMES = re.compile(_NAME)
_INSTRUCTION = re.compile(rf"  ({_NAME}) = (?:tail )?(\w+)")
_INTRINSIC = re.compile(r"@llvm\.(fabs|sqrt|floor|minnum|maxnum|minimum|maximum|copysign)\.")
_LOAD = re.compile(r" = load (?!atomic|volatile)")
_SIZE = re.compile(r"<(\d+) x (double|float)>")
_NUMBER_OR_LONG = r'(\d+(?![\w.$-])|[\w.$-]{200,}|"[^"]{200,}")'
_UNREADABLE, _UNREADABLE_LABEL = re.compile(f"(%){_NUMBER_OR_LONG}"), re.compile(f"^(){_NUMBER_OR_LONG}(?=:)")
_LABEL = re.compile(r'(?:"[^"]+"|[\w.$-]+):')
_LEAVES = re.compile(r"  (?:br|switch|ret|unreachable|indirectbr|resume)\b")


class Instruction(NamedTuple):
    """One instruction: its text, the name of what it makes, its latency and how long it keeps others from beginning."""

    text: str
    name: str
    latency: int
    takes: float
    reads: bool
    writes: bool


def ordered(module: str) -> str:
    """Return LLVM's text of a module with the instructions of its long blocks in order; where it has none, as it is."""
    lines = module.split("\n")
    blocks = [(first, last) for first, last in _blocks(lines) if _is_worth_it(lines[first:last])]
    lines = _named(module) if blocks else [module]
    for first, last in blocks:
        lines[first:last] = _scheduled(lines[first:last])
    return "\n".join(lines)


def _named(module: str) -> list[str]:
    # Lines in which nothing has a number for a name, which would have to stand in order, nor a name that is too long to
    # be read again.
    letters = next(name for name in ("n" * count for count in itertools.count(1)) if f"%{name}" not in module)
    short: dict[str, str] = {}

    def renamed(found: re.Match[str]) -> str:
        return found[1] + short.setdefault(found[2], f"{letters}{len(short)}")

    return [
        _UNREADABLE.sub(renamed, line) if line.startswith(("  ", "define")) else _UNREADABLE_LABEL.sub(renamed, line)
        for line in module.split("\n")
    ]


def _blocks(lines: Sequence[str]) -> Iterator[tuple[int, int]]:
    # From the first instruction that is no phi up to the one that leaves the block.
    first = 0
    for i, line in enumerate(lines):
        if _LABEL.match(line) or line.startswith("define") or " = phi " in line:
            first = i + 1
        elif _LEAVES.match(line):
            yield first, i


def _is_worth_it(lines: Sequence[str]) -> bool:
    return len(lines) >= LONG and (len(lines) <= LONGEST or max(map(_bits, lines)) <= WIDE)


def _bits(line: str) -> int:
    size = _SIZE.search(line)
    return int(size[1]) * (64 if size[2] == "double" else 32) if size else 64


def _instruction(line: str) -> Instruction:
    found = _INSTRUCTION.match(line)
    name, operation = found.groups() if found else ("", "")
    intrinsic = _INTRINSIC.search(line) if operation == "call" else None
    latency = LATENCY.get(intrinsic[1] if intrinsic else operation, 1)
    pure, reads = bool(intrinsic) or operation in PURE, _LOAD.search(line) is not None
    return Instruction(line, name, latency, max(_bits(line), 256) / AT_ONCE, reads, not pure and not reads)


def _needs(instructions: Sequence[Instruction]) -> list[set[int]]:
    # For each instruction those of the same block that it has to come after.
    places = {each.name: i for i, each in enumerate(instructions) if each.name}
    needs: list[set[int]] = []
    written, read = set[int](), set[int]()
    for i, each in enumerate(instructions):
        found = {places[name] for name in _NAMES.findall(each.text) if name in places} - {i}
        if each.reads:
            found |= written
            read.add(i)
        elif each.writes:
            found |= written | read
            written, read = {i}, set()
        needs.append(found)
    return needs


def _scheduled(lines: Sequence[str]) -> list[str]:
    instructions = [_instruction(line) for line in lines]
    needs = _needs(instructions)
    users: list[list[int]] = [[] for _ in lines]
    for i, before in enumerate(needs):
        for j in before:
            users[j].append(i)
    ways = [0.0] * len(lines)  # to the end of the block, cycles
    for i in reversed(range(len(lines))):
        ways[i] = instructions[i].latency + max((ways[user] for user in users[i]), default=0.0)
    missing = [len(before) for before in needs]
    ready = {i for i, count in enumerate(missing) if not count}
    begins, now, waits, order = [0.0] * len(lines), 0.0, 0, list[int]()
    done = [False] * len(lines)
    while ready:
        while done[waits]:
            waits += 1
        near = [i for i in ready if i < waits + AHEAD]
        best = min(near, key=lambda i: (max(begins[i], now), -ways[i], i))
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
