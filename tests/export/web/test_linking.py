"""Objects of WebAssembly become modules without a linker."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.errors import CompilerError
from layflat.export.targets import EXPORT_TARGETS
from layflat.export.web.binary import (
    ByteReader,
    SectionId,
    join_sections,
    name_bytes,
    read_sections,
    signed_number,
    unsigned_number,
)
from layflat.export.web.linking import STACK_BYTES, finish_module
from layflat.jit.objects import machine_code
from tests.export.web.engines import run_text

# Tables of constants, a place on the stack that is handed on, and calls: all that an object may refer to.
PROGRAM = """
@first = private constant [3 x double] [double 1.5, double 2.5, double 3.5]
@second = private constant [2 x i32] [i32 70, i32 80]

define internal void @fill(ptr %place, double %x) noinline {
  %sum = fadd double %x, 1.0
  store volatile double %sum, ptr %place
  ret void
}

define double @pick(i32 %i, double %x) {
  %place = alloca double
  call void @fill(ptr %place, double %x)
  %y = load volatile double, ptr %place
  %at = getelementptr [3 x double], ptr @first, i32 0, i32 %i
  %z = load double, ptr %at
  %result = fadd double %y, %z
  ret double %result
}

define i32 @other(i32 %i) {
  %at = getelementptr [2 x i32], ptr @second, i32 0, i32 %i
  %z = load i32, ptr %at
  ret i32 %z
}

define void @copy(ptr %from, ptr %to, i32 %size) {
  call void @llvm.memcpy.p0.p0.i32(ptr %to, ptr %from, i32 %size, i1 false)
  ret void
}

declare void @llvm.memcpy.p0.p0.i32(ptr, ptr, i32, i1)
"""
NAMES = ("pick", "other", "copy")
RUN = """
import { readFile } from "node:fs/promises";
const code = await readFile(new URL("./module.wasm", import.meta.url));
const { instance, module } = await WebAssembly.instantiate(code, {});
const { pick, another, copy, memory, __heap_base } = instance.exports;
const base = __heap_base.value;
const bytes = new Uint8Array(memory.buffer);
bytes.set([1, 2, 3], base);
copy(base, base + 100, 3);
console.log(JSON.stringify({
  picked: [0, 1, 2].map((i) => pick(i, 10)), others: [another(0), another(1)],
  copied: [...bytes.slice(base + 100, base + 104)], base, size: bytes.length,
  imports: WebAssembly.Module.imports(module),
}));
"""


def object_of(text: str, *names: str, target: str = "wasm") -> bytes:
    return machine_code(text, names, EXPORT_TARGETS[target].processor, ordered=False)


@pytest.mark.parametrize("target", ["wasm", "wasm-plain"])
def test_a_module_has_its_data_its_stack_and_its_functions(target: str, tmp_path: Path) -> None:
    code = object_of(PROGRAM, *NAMES, target=target)
    (tmp_path / "module.wasm").write_bytes(finish_module(code, {"pick": "pick", "other": "another", "copy": "copy"}))
    result = run_text(tmp_path, RUN)
    assert result["picked"] == [12.5, 13.5, 14.5]
    assert result["others"] == [70, 80]
    assert result["copied"] == [1, 2, 3, 0]
    assert result["imports"] == []
    assert result["base"] % 16 == 0
    assert STACK_BYTES < result["base"] < result["size"]


def test_what_an_object_lacks_is_named() -> None:
    code = object_of(PROGRAM, *NAMES)
    with pytest.raises(CompilerError, match="lacks pack"):
        finish_module(code, {"pack": "pack"})
    outside = (
        "declare double @sin(double)\ndefine double @f(double %x) {\n%y = call double @sin(double %x)\nret double %y\n}"
    )
    with pytest.raises(CompilerError, match="needs sin from outside"):
        finish_module(object_of(outside, "f"), {"f": "f"})
    with pytest.raises(CompilerError, match="none of WebAssembly"):
        finish_module(b"\x7fELF" + bytes(60), {})
    sections = {one.identifier: one.content for one in read_sections(code) if one.identifier != SectionId.CUSTOM}
    with pytest.raises(CompilerError, match="no symbols"):
        finish_module(join_sections(sections), {"pick": "pick"})


@given(st.integers(0, 2**32 - 1))
def test_numbers_are_read_as_they_are_written(value: int) -> None:
    reader = ByteReader(unsigned_number(value) + name_bytes("é"))
    assert (reader.number(), reader.name(), reader.at_end) == (value, "é", True)


@given(st.integers(-(2**31), 2**31 - 1))
def test_signed_numbers_end_in_their_sign(value: int) -> None:
    """The definition: seven bits a byte from the lowest on, the last of which repeat the sign."""
    data = signed_number(value)
    bits = sum((byte & 0x7F) << 7 * i for i, byte in enumerate(data))
    assert (bits - value) % (1 << 7 * len(data)) == 0
    assert bool(data[-1] & 0x40) == (value < 0)
    assert [byte >> 7 for byte in data] == [1] * (len(data) - 1) + [0]
