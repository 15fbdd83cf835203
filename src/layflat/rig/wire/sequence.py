"""Numbers of transactions: 16 bits that go round, so that "later" means less than half a round ahead."""

from __future__ import annotations

ROUND = 1 << 16


def following(number: int) -> int:
    """The number after this one."""
    return (number + 1) % ROUND


def is_later(number: int, last: int | None) -> bool:
    """Whether a number is neither the last one heard nor an older one; any number does at first."""
    return last is None or 0 < (number - last) % ROUND < ROUND // 2
