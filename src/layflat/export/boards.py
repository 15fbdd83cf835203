"""Boards of microcontrollers for which the examples are written; QEMU has them, so that they run on any computer."""

from collections.abc import Iterator
from typing import Any, NamedTuple

from layflat.export.templates import fill_template


class Memory(NamedTuple):
    """Part of a board's memory."""

    start: int
    size: int  # bytes


class ExampleBoard(NamedTuple):
    """Board of a microcontroller: its compiler, memory, and QEMU's name."""

    name: str  # of QEMU's machine
    template: str  # of the files that start the processor
    compiler: str
    options: str  # of the compiler, for the processor
    flash: Memory
    ram: Memory
    emulator: str  # command that runs the example
    emulated: bool = False  # whether double precision is emulated, by libgcc
    device: str = "board_mps2.c"  # the four functions of its firmware
    uart_interrupt: int = 0  # number of the first UART's first interrupt

    @property
    def tools(self) -> tuple[str, str]:
        """Compiler and emulator."""
        return self.compiler, self.emulator.split()[0]

    def texts(self, values: dict[str, Any]) -> Iterator[tuple[str, str]]:
        """Yield name and content of the files that build the example and start the processor.

        Args:
            values: values of all templates.
        """
        board = {**values, **self.values(values["precision"]), "firmware": False}
        yield "Makefile", fill_template("Makefile.board", **board)
        for name in ("startup.c", "board.ld") if self.template == "cortex" else ():
            yield name, fill_template(name, **board)
        if board["sums"]:
            yield "sums.c", fill_template("sums.c")

    def values(self, precision: str) -> dict[str, Any]:
        """Return the values of the templates that are the board's, with code in a precision."""
        packages = COMPILER_PACKAGES[self.compiler]
        return {**self._asdict(), "sums": self.has_sums(precision), "packages": packages}

    def has_sums(self, precision: str) -> bool:
        """Return whether its code in a precision needs sums.c."""
        return self.emulated and precision == "double"

    def with_exact_sums(self, code: bytes) -> bytes:
        """Return an object file that calls the sums of sums.c in place of libgcc's, where it calls any."""
        for name in (b"dadd", b"dsub") if self.emulated else ():
            code = code.replace(b"__aeabi_%b\0" % name, b"layflat_%b\0" % name)  # as long, so that all else stays
        return code


MEMORY_SIZE = 4 << 20  # of flash and of RAM of each board, bytes

ARM_COMPILER, ARM_QEMU = "arm-none-eabi-gcc", "qemu-system-arm -M {} -nographic -semihosting -kernel"
RISCV_COMPILER = "riscv64-unknown-elf-gcc"
COMPILER_PACKAGES = {
    ARM_COMPILER: "gcc-arm-none-eabi and libnewlib-arm-none-eabi",
    RISCV_COMPILER: "gcc-riscv64-unknown-elf and picolibc-riscv64-unknown-elf",
}
"""Debian's packages with the compilers of boards, and their libraries."""


def _cortex(
    name: str, options: str, flash: int = 0, ram: int = 0x20000000, uart_interrupt: int = 0
) -> ExampleBoard:  # fmt: skip
    return ExampleBoard(
        name, "cortex", ARM_COMPILER, f"-mthumb {options}", Memory(flash, MEMORY_SIZE), Memory(ram, MEMORY_SIZE),
        ARM_QEMU.format(name), emulated="fpv5-d16" not in options, uart_interrupt=uart_interrupt,
    )  # fmt: skip


EXAMPLE_BOARDS: dict[str, ExampleBoard] = {
    "cortex-m7": _cortex("mps2-an500", "-mcpu=cortex-m7 -mfloat-abi=hard -mfpu=fpv5-d16"),
    "cortex-m4f": _cortex("mps2-an386", "-mcpu=cortex-m4 -mfloat-abi=hard -mfpu=fpv4-sp-d16"),
    "cortex-m4": _cortex("mps2-an386", "-mcpu=cortex-m4 -mfloat-abi=soft"),
    "cortex-m33": _cortex(
        "mps2-an505", "-mcpu=cortex-m33 -mfloat-abi=hard -mfpu=fpv5-sp-d16", 0x10000000, 0x38000000, uart_interrupt=32
    ),
    "riscv32": ExampleBoard(
        "virt",
        "riscv",
        RISCV_COMPILER,
        "-march=rv32imafdc -mabi=ilp32d --specs=picolibc.specs",
        Memory(0x80000000, MEMORY_SIZE),
        Memory(0x80400000, MEMORY_SIZE),
        "qemu-system-riscv32 -M virt -bios none -display none -serial none -monitor none "
        "-chardev stdio,id=output -semihosting-config enable=on,chardev=output -kernel",
        device="board_virt.c",
    ),
}
"""Board of the example, by target."""
