"""Output on a page is compared with what was printed: words exactly, numbers by tolerance."""

import pytest

from tests.docs.comparing import find_difference

SAME = [
    ("a: 1.00 s", "a: 1.01 s"),
    ("a: 0.002", "a: 0.001"),
    ("a: 50", "a: 51"),
    ("wrote /tmp/here/a.nc", "wrote /somewhere/else/a.nc"),
    ("at 12:31 on 2026-01-02", "at 9:05:11 on 2025-12-31"),
    ("a ... s", "a took 3 s"),
    ("a\n...\nd", "a\nb\nc\nd"),
    ("...", ""),
    (" a ┃ b\n━━━╇━━━\n 1 │ 2", " a   ┃ b\n━━━━━╇━━━━━\n\n 1   │ 2"),
]

DIFFERENT = [
    ("a: 1.0", "b: 1.0", 1),
    ("a: 1.00", "a: 1.03", 1),
    ("a: 3", "a: 4", 1),
    ("a: 1", "a: one", 1),
    ("a\nb", "a", 2),
    ("a\n...\nb\nc", "a\nb", 4),
    ("wrote build/a.nc", "wrote build/b.nc", 1),
    (" a ┃ b\n━━━╇━━━\n 1 │ x", " a ┃ b\n━━━╇━━━\n 1 │ y", 3),
]


@pytest.mark.parametrize(("shown", "printed"), SAME)
def test_same(shown: str, printed: str) -> None:
    assert find_difference(shown, printed) is None


@pytest.mark.parametrize(("shown", "printed", "line"), DIFFERENT)
def test_different(shown: str, printed: str, line: int) -> None:
    difference = find_difference(shown, printed)
    assert difference is not None
    assert difference[0] == line
