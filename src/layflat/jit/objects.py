"""Machine code from LLVM's portable text: for any processor, as an object file; and its loading into this process."""

# mypy: disable-error-code="no-untyped-call"
# The compiler's own modules are untyped.

import ctypes
import re
from collections.abc import Callable
from functools import cache
from hashlib import sha256
from threading import Lock
from typing import Any, NamedTuple

from llvmlite import binding

from layflat.errors import CompilerError
from layflat.jit.ordering import order_instructions

OF_EVERY_TARGET = frozenset({"memcpy", "memset", "memmove", "floor", "floorf"})
"""Functions of C that LLVM may call where a processor has no such instruction; their results are exact."""

OF_C_LIBRARY = OF_EVERY_TARGET | {"acos", "asin", "atan", "atan2", "cos", "exp", "log", "log1p", "pow", "sin", "tan"}
"""Functions of C's library on a computer, whose last bits differ between libraries."""

CONSTANT_SECTIONS = re.compile(b"rodata|rdata|const|literal")
"""Names of sections with constants, of ELF, COFF and Mach-O."""


NARROW_ADDRESS = "p:32:32"  # in the layout of data of 32-bit targets
ADDRESS_IN_MEMORY = re.compile(r".*(?:store ptr|load ptr|alloca [^\n]*\bptr\b).*")


class Processor(NamedTuple):
    """Processor that machine code is made for, in LLVM's terms."""

    triple: str
    name: str
    features: str = ""
    relocation: str = "pic"

    @property
    def digest(self) -> str:
        """Digest of all this and of LLVM's version, for names of files."""
        return sha256(repr((self, binding.llvm_version_info)).encode()).hexdigest()[:8]


LAID_OUT_FOR = Processor("aarch64-unknown-none", "generic")


def _host_features() -> str:
    features: Any = binding.get_host_cpu_features()
    return str(features.flatten())


@cache
def host() -> Processor:
    """Return the processor of this computer."""
    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    return Processor(binding.get_process_triple(), binding.get_host_cpu_name(), _host_features())


class CompiledModule(NamedTuple):
    """Machine code of a module."""

    code: bytes  # object file
    assembly: str


def machine_code(
    text: str,
    names: tuple[str, ...],
    processor: Processor,
    *,
    ordered: bool = True,
    outside: frozenset[str] = OF_C_LIBRARY,
) -> bytes:
    """Return the object file of a module's functions.

    Args:
        text: LLVM's portable text (see `portable`).
        names: functions that are seen from outside.
        processor: the processor.
        ordered: whether instructions are put in an order in which a large processor waits less.
        outside: functions that it may call of other code.

    Raises:
        CompilerError: it calls another function.
    """
    machine = _target_machine(processor)
    return bytes(machine.emit_object(_checked(text, names, processor, machine, ordered, outside)))


def compiled_module(
    text: str, names: tuple[str, ...], processor: Processor, outside: frozenset[str] = OF_C_LIBRARY
) -> CompiledModule:
    """Return object file and assembly of a module's functions, whose instructions keep their order.

    Args:
        text: LLVM's portable text (see `portable`).
        names: functions that are seen from outside.
        processor: the processor.
        outside: functions that it may call of other code.

    Raises:
        CompilerError: it calls another function.
    """
    machine = _target_machine(processor)
    module = _checked(text, names, processor, machine, False, outside)
    copy = binding.parse_assembly(str(module))  # as the emission changes a module
    return CompiledModule(bytes(machine.emit_object(module)), str(machine.emit_assembly(copy)))


def _checked(
    text: str, names: tuple[str, ...], processor: Processor, machine: Any, ordered: bool, outside: frozenset[str]
) -> Any:
    """Return the optimised module; raise CompilerError if it calls a function that is not among `outside`."""
    module = _optimized(text, names, processor, machine, ordered)
    needed = {one.name for one in module.functions if one.is_declaration and not one.name.startswith("llvm.")}
    if needed - outside:
        raise CompilerError(f"code of {names[0]} needs {sorted(needed - outside)} from outside")
    return module


def _target_machine(processor: Processor) -> Any:
    """Return LLVM's code generator for a processor, with all optimisation."""
    if processor != host():
        binding.initialize_all_targets()
        binding.initialize_all_asmprinters()
    return binding.Target.from_triple(processor.triple).create_target_machine(
        cpu=processor.name, features=processor.features, opt=3, reloc=processor.relocation, codemodel="default"
    )


def in_registers(text: str, names: tuple[str, ...]) -> str:
    """Return a module whose functions are inlined into those that are named, with no address left in memory.

    Args:
        text: LLVM's portable text (see `portable`).
        names: functions that are seen from outside.

    Raises:
        CompilerError: an address stays in memory.
    """
    module = _parsed(text, names)
    _keep_addresses_in_registers(module)
    return without_target(str(module))


def without_target(text: str) -> str:
    """Return LLVM's text without the lines that name a target."""
    return "\n".join(line for line in text.split("\n") if not line.startswith(("target triple", "target datalayout")))


def _parsed(text: str, names: tuple[str, ...]) -> Any:
    """Return a module, with all but its named functions internal."""
    module = binding.parse_assembly(text)
    for one in (*module.functions, *module.global_variables):
        if not one.is_declaration and one.name not in names:
            one.linkage = "internal"
    return module


def _optimized(text: str, names: tuple[str, ...], processor: Processor, machine: Any, ordered: bool) -> Any:
    """Return the module, optimised for a processor, with all but its named functions internal.

    Raise CompilerError if a processor of 32-bit addresses would keep one in memory.
    """
    module = _parsed(text, names)
    if NARROW_ADDRESS in str(machine.target_data):
        _keep_addresses_in_registers(module)
    module.triple, module.data_layout = processor.triple, str(machine.target_data)
    options = binding.create_pipeline_tuning_options(speed_level=3)
    options.loop_vectorization, options.slp_vectorization = ordered, False
    builder = binding.create_pass_builder(machine, options)
    for _ in range(2):
        builder.getModulePassManager().run(module, builder)
    if ordered:
        module = binding.parse_assembly(order_instructions(str(module)))
    cleaner = binding.create_new_module_pass_manager()
    cleaner.add_global_dead_code_eliminate_pass()
    cleaner.add_strip_dead_prototype_pass()
    cleaner.run(module, builder)
    module.verify()
    return module


def _keep_addresses_in_registers(module: Any) -> None:
    """Optimise a module until no address is in memory, where its size and the places behind it depend on the target.

    The compiler of laws has laid memory out, and folded places in it into numbers of bytes, for addresses of 64 bits.

    Raises:
        CompilerError: an address stays in memory.
    """
    _simplify(module)
    left = ADDRESS_IN_MEMORY.search(str(module))
    if left:
        raise CompilerError(f"code for 32 bits would keep an address in memory: {left[0].strip()}")


def _simplify(module: Any) -> None:
    """Optimise a module without loops unrolled or vectorised, for addresses of 64 bits."""
    machine = _target_machine(LAID_OUT_FOR)
    module.triple, module.data_layout = LAID_OUT_FOR.triple, str(machine.target_data)
    options = binding.create_pipeline_tuning_options(speed_level=2)
    options.loop_vectorization, options.slp_vectorization, options.loop_unrolling = False, False, False
    builder = binding.create_pass_builder(machine, options)
    builder.getModulePassManager().run(module, builder)


def code_size(code: bytes) -> int:
    """Return the size of an object file's instructions and constants, bytes."""
    sections = binding.ObjectFileRef.from_data(code).sections()
    return sum(one.size() for one in sections if one.is_text() or CONSTANT_SECTIONS.search(one.name() or b""))


_libraries: list[Any] = []  # loaded code, which stays as long as the process
_linking = Lock()  # one library is linked at a time


@cache
def _linker() -> Any:
    """Return the linker of this process, which places all sections of an object file side by side.

    Apart, as by LLVM's older loader in a large process, they can be too far for distances of 32 bits.
    """
    machine = binding.Target.from_default_triple().create_target_machine()
    return binding.create_lljit_compiler(machine, use_jit_link=True, suppress_errors=True)


ELF_START = b"\x7fELF\2\1\1" + bytes(9) + b"\1\0"  # of 64 bits, least byte first, an object file
MACH_O_START = b"\xcf\xfa\xed\xfe"  # likewise
OBJECT_STARTS = {
    r"x86_64-.*-linux-": ELF_START + b"\x3e\0",
    r"aarch64-.*-linux-": ELF_START + b"\xb7\0",
    r"x86_64-.*-windows-": b"\x64\x86",
    r"x86_64-apple-": MACH_O_START + b"\7\0\0\1",
    r"arm64-apple-": MACH_O_START + b"\x0c\0\0\1",
}
"""First bytes of object files, their format and processor, by a pattern of LLVM's triple."""


def object_start(triple: str) -> bytes:
    """Return the first bytes of a processor's object files; b"" if they are not known."""
    return next((start for pattern, start in OBJECT_STARTS.items() if re.match(pattern, triple)), b"")


def load(code: bytes, name: str, arguments: tuple[Any, ...] = (ctypes.c_void_p,)) -> Callable[..., None]:
    """Load an object file into this process; return its function.

    Args:
        code: the object file.
        name: name of the function.
        arguments: types of its arguments for `ctypes`; default: the address of words.

    Raises:
        CompilerError: it is no object file of this processor with such a function.
    """
    if not code.startswith(object_start(host().triple)):  # LLVM would end the process
        raise CompilerError(f"machine code of {name} is of another processor or system")
    builder = binding.JITLibraryBuilder().add_object_img(code).add_current_process().export_symbol(name)
    with _linking:
        try:
            library = builder.link(_linker(), f"{name} {len(_libraries)}")
        except RuntimeError as error:
            raise CompilerError(f"machine code of {name} can't be loaded ({error})") from None
        _libraries.append(library)
    return ctypes.CFUNCTYPE(None, *arguments)(library[name])
