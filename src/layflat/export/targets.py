"""Targets of an export: processors and systems for which machine code is made, each one line of a table."""

from typing import NamedTuple

from layflat.jit.objects import Processor


class Target(NamedTuple):
    """Target of machine code."""

    processor: Processor
    title: str
    object_suffix: str = ".o"
    precisions: tuple[str, ...] = ("double", "single")
    plant: bool = True  # whether the plant is exported, too: microcontrollers get the control law alone


LINUX_SUFFIX, WINDOWS_SUFFIX = "unknown-linux-gnu", "pc-windows-gnu"

EXPORT_TARGETS: dict[str, Target] = {
    "linux-x86-64": Target(
        Processor(f"x86_64-{LINUX_SUFFIX}", "x86-64-v2"), "Linux on x86-64 (v2: from about 2009 on)"
    ),
    "linux-x86-64-v3": Target(Processor(f"x86_64-{LINUX_SUFFIX}", "x86-64-v3"), "Linux on x86-64 with AVX2"),
    "linux-x86-64-v4": Target(Processor(f"x86_64-{LINUX_SUFFIX}", "x86-64-v4"), "Linux on x86-64 with AVX-512"),
    "linux-aarch64": Target(Processor(f"aarch64-{LINUX_SUFFIX}", "cortex-a53"), "Linux on 64-bit ARM"),
    "windows-x86-64": Target(Processor(f"x86_64-{WINDOWS_SUFFIX}", "x86-64-v2"), "Windows on x86-64", ".obj"),
    "macos-aarch64": Target(Processor("arm64-apple-macosx12.0", "apple-m1"), "macOS on Apple silicon"),
    "macos-x86-64": Target(Processor("x86_64-apple-macosx12.0", "x86-64-v2"), "macOS on x86-64"),
    "cortex-m7": Target(
        Processor("thumbv7em-unknown-none-eabihf", "cortex-m7", relocation="static"),
        "ARM Cortex-M7 with hardware for double precision",
        plant=False,
    ),
    "cortex-m4f": Target(
        Processor("thumbv7em-unknown-none-eabihf", "cortex-m4", relocation="static"),
        "ARM Cortex-M4F; double precision is emulated",
        plant=False,
    ),
    "cortex-m4": Target(
        Processor("thumbv7em-unknown-none-eabi", "cortex-m4", "+soft-float,-vfp2,-vfp3,-vfp4", "static"),
        "ARM Cortex-M4 without hardware for numbers",
        plant=False,
    ),
    "cortex-m33": Target(
        Processor("thumbv8m.main-unknown-none-eabihf", "cortex-m33", relocation="static"), "ARM Cortex-M33", plant=False
    ),
    "riscv32": Target(
        Processor("riscv32-unknown-none-elf", "generic-rv32", "+m,+a,+f,+d,+c", "static"),
        "32-bit RISC-V with hardware for double precision",
        plant=False,
    ),
    "wasm": Target(
        Processor("wasm32-unknown-unknown", "generic", "+bulk-memory,+simd128", "static"), "WebAssembly with SIMD"
    ),
    "wasm-plain": Target(
        Processor("wasm32-unknown-unknown", "generic", "+bulk-memory", "static"), "WebAssembly without SIMD"
    ),
}
