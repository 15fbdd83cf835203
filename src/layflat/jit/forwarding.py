"""Forwarding of constants in code that is to be small: laws get the address of a constant, not that of a copy.

A caller puts the numbers of a tuple that a law gets into memory of its own (see `arguments`). Often it has just read
them from a tuple that it got itself, or from a struct that nobody writes during the call: then the law gets the address
there. LLVM does so for a block that is copied as a whole, but these are copied number by number.
"""

import re
from collections import defaultdict
from collections.abc import Iterator
from typing import NamedTuple

from layflat.jit.objects import simplified

TUPLE_NAME = "tuple"  # of the memory into which a caller puts a tuple for a law

VALUE_PATTERN = r'%(?:[\w.$-]+|"[^"]*")'
CONSTANT_PATTERN = re.compile(rf"ptr (?=[^,]*\bnoalias\b)(?=[^,]*\breadonly\b)[^,%]*({VALUE_PATTERN})")
COPY_PATTERN = re.compile(rf'(%"?{TUPLE_NAME}[^ ]*) = alloca ')
PLACE_PATTERN = re.compile(rf"({VALUE_PATTERN}) = getelementptr [\w ]*i8, ptr ({VALUE_PATTERN}), i64 (-?\d+)")
LOAD_PATTERN = re.compile(rf"({VALUE_PATTERN}) = load (.+?), ptr ({VALUE_PATTERN})")
STORE_PATTERN = re.compile(rf"  store (.+) (\S+), ptr ({VALUE_PATTERN})")


class Place(NamedTuple):
    """Place in memory."""

    start: str  # address from which it is counted
    offset: int  # bytes


def forward_constants(text: str, name: str) -> str:
    """Return a simplified module in which laws get addresses of constants in place of copies.

    Args:
        text: LLVM's portable text (see `portable`).
        name: function that is seen from outside; what its arguments that are `noalias` and `readonly` point to is
            constant.
    """
    before, text = "", simplified(text, (name,))
    while text != before:
        before = text
        functions = re.split(r"^(?=define )", text, flags=re.MULTILINE)
        text = simplified("".join(map(_forward, functions)), (name,))
    return text


def _forward(function: str) -> str:
    """Return a function's text with addresses of constants in place of those of their copies."""
    head, _, body = function.partition("\n")
    constants = {match[1] for match in CONSTANT_PATTERN.finditer(head)} if head.startswith("define") else set()
    if not constants:
        return function
    lines = body.split("\n")
    places = {match[1]: Place(match[2], int(match[3])) for match in map(PLACE_PATTERN.search, lines) if match}
    origins = dict(_origins(lines, places, constants))
    kept = []
    for line in lines:
        made, stored = COPY_PATTERN.search(line), STORE_PATTERN.match(line)
        if made and made[1] in origins:
            start, offset = origins[made[1]]
            kept.append(f"  {made[1]} = getelementptr i8, ptr {start}, i64 {offset}")
        elif not (stored and _place(stored[3], places).start in origins) and not _ends_life(line, origins):
            kept.append(line)
    return "\n".join([head, *kept])


def _origins(lines: list[str], places: dict[str, Place], constants: set[str]) -> Iterator[tuple[str, Place]]:
    """Yield each copy of constants, with the place where these lie.

    Args:
        lines: instructions of a function.
        places: places by their addresses, where these are counted from others.
        constants: addresses of constants.
    """
    copies = {match[1] for match in map(COPY_PATTERN.search, lines) if match}
    loads = {match[1]: (match[2], _place(match[3], places)) for match in map(LOAD_PATTERN.search, lines) if match}
    found = defaultdict[str, set[Place | None]](set)
    for line in lines:
        stored, addresses = STORE_PATTERN.match(line), set(re.findall(VALUE_PATTERN, line))
        if stored and _place(stored[3], places).start in copies:
            copy, offset = _place(stored[3], places)
            kind, (start, there) = loads.get(stored[2], ("", Place("", 0)))
            is_constant = start in constants and kind == stored[1]
            found[copy].add(Place(start, there - offset) if is_constant else None)
            addresses.discard(stored[3])
        for copy in {_place(address, places).start for address in addresses} & copies:
            if not (COPY_PATTERN.search(line) or PLACE_PATTERN.search(line) or _is_passed(line)):
                found[copy].add(None)
    for copy, origins in found.items():
        origin = origins.pop()
        if origin is not None and not origins:
            yield copy, origin


def _is_passed(line: str) -> bool:
    """Return whether an instruction calls a law, or marks where memory is used."""
    return " call " in line and ("@llvm." not in line or "@llvm.lifetime." in line)


def _ends_life(line: str, copies: dict[str, Place]) -> bool:
    return "@llvm.lifetime." in line and any(value in copies for value in re.findall(VALUE_PATTERN, line))


def _place(address: str, places: dict[str, Place]) -> Place:
    """Return the place of an address, counted from one that is not counted from another."""
    offset = 0
    while address in places:
        address, more = places[address]
        offset += more
    return Place(address, offset)
