"""Machine code for 32 bits of functions whose memory was laid out for addresses of 64 bits."""

import pytest

from layflat.errors import CompilerError
from layflat.export.targets import EXPORT_TARGETS
from layflat.jit.objects import machine_code

STRAIGHT = """
define void @f(ptr %a, ptr %b) {
  store double 1.0, ptr %b
  ret void
}"""
THROUGH_MEMORY = """
define void @f(ptr %a, ptr %b) {
  %both = alloca {ptr, ptr}
  store ptr %a, ptr %both
  %second = getelementptr i8, ptr %both, i64 8
  store ptr %b, ptr %second
  %used = load ptr, ptr %second
  store double 1.0, ptr %used
  ret void
}"""
CHOSEN = """
define void @f(ptr %a, ptr %b, i64 %i) {
  %both = alloca [2 x ptr]
  store ptr %a, ptr %both
  %second = getelementptr i8, ptr %both, i64 8
  store ptr %b, ptr %second
  %chosen = getelementptr [2 x ptr], ptr %both, i64 0, i64 %i
  %used = load ptr, ptr %chosen
  store double 1.0, ptr %used
  ret void
}"""


@pytest.mark.parametrize("target", ["cortex-m7", "riscv32", "wasm", "linux-aarch64"])
def test_an_address_that_goes_through_memory_keeps_its_place(target: str) -> None:
    processor = EXPORT_TARGETS[target].processor
    codes = [machine_code(text, ("f",), processor, ordered=False) for text in (THROUGH_MEMORY, STRAIGHT)]
    assert codes[0] == codes[1]


@pytest.mark.parametrize("target", ["cortex-m7", "riscv32", "wasm"])
def test_an_address_that_stays_in_memory_is_refused_for_32_bits(target: str) -> None:
    with pytest.raises(CompilerError, match="keep an address in memory"):
        machine_code(CHOSEN, ("f",), EXPORT_TARGETS[target].processor, ordered=False)


def test_for_64_bits_it_may_stay() -> None:
    assert machine_code(CHOSEN, ("f",), EXPORT_TARGETS["linux-aarch64"].processor, ordered=False)
