#!/usr/bin/env bash
# llvmlite takes the three-part names of ARM targets that Rust and Clang use for a convention without floating point
# registers, and does not say so.
#
# `thumbv7em-none-eabihf` is a target's name in Rust, and Clang takes it. `Target.from_triple` of llvmlite 0.50.0 (LLVM
# 22) takes it too, but reads "none" as the vendor and "eabihf" as an unknown system: the object has no ABI attribute,
# and passes a double in r0 and r1. With four parts (`thumbv7em-unknown-none-eabihf`) it is passed in d0. Clang puts
# the parts in order first (`Triple::normalize`), which llvmlite does not offer. A loader that does not compare
# attributes runs such code with wrong numbers; GNU ld refuses it ("uses VFP register arguments").
#
#                                   attribute 28   x + x with x and result in
#   thumbv7em-none-eabihf           none           r0, r1
#   thumbv7em-unknown-none-eabihf   1              d0
#   armv7-linux-gnueabihf           none           r0, r1
#   armv7-unknown-linux-gnueabihf   1              d0
#   arm-none-linux-gnueabihf        1              d0
# Run on 2026-11-29, Python 3.11, x86-64. Exits with 1 if the behaviour has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q llvmlite==0.50.0
cat > "$folder/triples.py" <<'PYTHON'
import llvmlite.binding as llvm

llvm.initialize_all_targets()
llvm.initialize_all_asmprinters()
TEXT = """
define double @twice(double %x) {
  %y = fadd double %x, %x
  ret double %y
}
"""


def assembly(triple, cpu):
    machine = llvm.Target.from_triple(triple).create_target_machine(cpu=cpu)
    module = llvm.parse_assembly(TEXT)
    module.triple, module.data_layout = triple, str(machine.target_data)
    return machine.emit_assembly(module)


for triple, cpu in [
    ("thumbv7em-none-eabihf", "cortex-m7"),
    ("thumbv7em-unknown-none-eabihf", "cortex-m7"),
    ("armv7-linux-gnueabihf", "cortex-a9"),
    ("armv7-unknown-linux-gnueabihf", "cortex-a9"),
    ("arm-none-linux-gnueabihf", "cortex-a9"),
]:
    text = assembly(triple, cpu)
    hard = ".eabi_attribute\t28, 1" in text
    moved = "r0, r1" in text
    print(triple, "attribute 28" if hard else "no attribute", "r0, r1" if moved else "d0")
PYTHON
"$folder/venv/bin/python" "$folder/triples.py" | tee "$folder/printed"
diff "$folder/printed" - <<'EXPECTED'
thumbv7em-none-eabihf no attribute r0, r1
thumbv7em-unknown-none-eabihf attribute 28 d0
armv7-linux-gnueabihf no attribute r0, r1
armv7-unknown-linux-gnueabihf attribute 28 d0
arm-none-linux-gnueabihf attribute 28 d0
EXPECTED
