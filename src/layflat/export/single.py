"""Portable code in single precision, from code that computes in double precision on numbers stored in single.

Every operation then rounds to single precision. Laws that take lanes have a form in single precision of their own (see
`lanes`), which is the better one; this is for the others.
"""

import re
from itertools import count

import numpy as np

from layflat.errors import CompilerError
from layflat.lanes import epsilon
from layflat.physics.trig import ROUNDING_SCALE

# Constants of floating point in LLVM's text.
NUMBER_PATTERN = re.compile(r"(?<=[ ,(\[{<])(0x[0-9A-F]{16}|-?\d+\.\d+e[+-]\d+)")
CONVERSION_PATTERN = re.compile(
    r"\b(?:fpext|fptrunc)(?: [a-z]+)* (float|<\d+ x float>) ([^ ]+) to (float|<\d+ x float>)"
)
INTRINSIC_PATTERN = re.compile(r"@llvm\.[\w.]+")
DECLARATION_PATTERN = re.compile(r"declare .*?(@[\w.]+)\(")
DOUBLE_PATTERN = re.compile(r"\bdouble\b")
# Memory keeps its layout: each number takes half of its place.
PLACE_PATTERN = re.compile(r"= (?:alloca|getelementptr)\b")
VECTOR_LOAD_PATTERN = re.compile(r"^  (%\S+) = load <(\d+) x double>, ptr ([^,\n]+).*$", re.MULTILINE)
VECTOR_STORE_PATTERN = re.compile(r"^  store (<(\d+) x double> .+), ptr ([^,\n]+).*$", re.MULTILINE)
SEVERAL_IN_MEMORY_PATTERN = re.compile(r"^@.*\bdouble\b.*|^.*\b(?:load|store) [<\[{].*\bdouble\b.*", re.MULTILINE)
_DOUBLE_EPSILON, _SINGLE_EPSILON = epsilon(0.0), float(np.finfo(np.float32).eps)
PRECISION_CONSTANTS = {
    _DOUBLE_EPSILON: _SINGLE_EPSILON,
    ROUNDING_SCALE / _DOUBLE_EPSILON: ROUNDING_SCALE / _SINGLE_EPSILON,
    -ROUNDING_SCALE / _DOUBLE_EPSILON: -ROUNDING_SCALE / _SINGLE_EPSILON,
}
"""Constants of laws that depend on the precision, as the compiler may have folded them."""


def in_single_precision(text: str) -> str:
    """Return portable code with all its numbers in single precision.

    Args:
        text: LLVM's text of code that reads and writes single precision, and computes in double.

    Raises:
        CompilerError: it reads or writes a tuple of numbers of double precision at once, or a table of them.
    """
    numbers = count()
    text = VECTOR_LOAD_PATTERN.sub(lambda match: _loaded_one_by_one(match, f"one.{next(numbers)}"), text)
    text = VECTOR_STORE_PATTERN.sub(lambda match: _stored_one_by_one(match, f"one.{next(numbers)}"), text)
    several = SEVERAL_IN_MEMORY_PATTERN.search(text)
    if several:
        raise CompilerError(f"no single precision for numbers side by side in memory: {several[0].strip()}")
    lines, declared = [], set[str]()
    for line in text.split("\n"):
        single = _in_single(line) if ("double" in line or "f64" in line) and not PLACE_PATTERN.search(line) else line
        function = DECLARATION_PATTERN.match(single)
        if function is None or function[1] not in declared:
            lines.append(single)
        if function is not None:
            declared.add(function[1])
    return "\n".join(lines)


def _loaded_one_by_one(match: re.Match[str], name: str) -> str:
    """Return the loads of a vector's numbers, each from its own place; their names begin with a given one."""
    vector, width, address = match[1], int(match[2]), match[3]
    lines, before = [], "poison"
    for i in range(width):
        after = vector if i == width - 1 else f"%{name}.vector.{i}"
        lines += [
            f"  %{name}.place.{i} = getelementptr i8, ptr {address}, i64 {8 * i}",
            f"  %{name}.number.{i} = load double, ptr %{name}.place.{i}, align 8",
            f"  {after} = insertelement <{width} x double> {before}, double %{name}.number.{i}, i64 {i}",
        ]
        before = after
    return "\n".join(lines)


def _stored_one_by_one(match: re.Match[str], name: str) -> str:
    """Return the stores of a vector's numbers likewise."""
    vector, width, address = match[1], int(match[2]), match[3]
    return "\n".join(
        line
        for i in range(width)
        for line in (
            f"  %{name}.number.{i} = extractelement {vector}, i64 {i}",
            f"  %{name}.place.{i} = getelementptr i8, ptr {address}, i64 {8 * i}",
            f"  store double %{name}.number.{i}, ptr %{name}.place.{i}, align 8",
        )
    )


def _in_single(line: str) -> str:
    line = DOUBLE_PATTERN.sub("float", NUMBER_PATTERN.sub(_rounded, line))
    line = INTRINSIC_PATTERN.sub(lambda match: match[0].replace("f64", "f32"), line)
    return CONVERSION_PATTERN.sub(r"bitcast \1 \2 to \3", line)


def _rounded(match: re.Match[str]) -> str:
    """Return a constant rounded to single precision, in the form that LLVM takes for either."""
    digits = match[1]
    number = np.uint64(int(digits, 16)).view(np.float64) if digits.startswith("0x") else np.float64(digits)
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        rounded = np.float64(np.float32(PRECISION_CONSTANTS.get(float(number), number)))
    return f"0x{int(rounded.view(np.uint64)):016X}"
