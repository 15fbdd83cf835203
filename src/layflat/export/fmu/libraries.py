"""Libraries of an FMU, linked by zig for all systems, or by the C compiler of this computer for its own."""

import os
import platform
import subprocess
import sys
from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from shutil import which

from layflat.errors import CompilerError, MissingExtraError

SOURCE_FOLDER = Path(__file__).parent / "source"

FMI_SOURCES = {"2.0": ("fmi2",), "3.0": ("fmi3", "fmi3_absent")}  # C files of a version of FMI alone

C_FLAGS = ("-std=c11", "-ffp-contract=off", "-fvisibility=hidden", "-fPIC")

NO_UNWINDING = ("-fno-unwind-tables", "-fno-asynchronous-unwind-tables")  # no exception ever passes an FMU

WINDOWS_C_LIBRARY = tuple(f"-lapi-ms-win-crt-{part}-l1-1-0" for part in ("heap", "math", "stdio", "string"))
WINDOWS_LINKED = ("-nostdlib", "-rtlib=none", "-Wl,--entry,DllMainCRTStartup", *WINDOWS_C_LIBRARY)
"""Options by which zig links a library of Windows with the system's C library alone; see source/windows/runtime.c."""

LAW_FLAGS = ("-fno-math-errno",)  # roots are instructions

INLINE_THRESHOLD = ("-mllvm", "-inline-threshold=25")
"""Options of zig by which short laws alone are inlined: half of its limit for small code, by which a cycle of the
picking arm takes no longer. With fast code, -O2, it takes a fifth less, and the code is half as large again."""

PROCESSOR_FLAGS = {"x86_64": ("-mcpu=x86_64_v2",)}  # of zig; as in `targets.EXPORT_TARGETS`

C_COMPILERS = ("cc", "gcc", "clang")


@dataclass(frozen=True)
class System:
    """System that a library is linked for."""

    title: str
    target: str  # a key of `targets.EXPORT_TARGETS`
    triple: str  # of zig
    folder: str  # in binaries/, by FMI 3.0
    folder_2: str  # likewise by FMI 2.0; empty: it has none
    suffix: str

    def folder_of(self, version: str) -> str:
        """Return its folder in binaries/ by a version of FMI; empty: it has none."""
        return self.folder if version == "3.0" else self.folder_2


LINKED_SYSTEMS = (
    System("Linux x86-64", "linux-x86-64", "x86_64-linux-gnu.2.17", "x86_64-linux", "linux64", ".so"),
    System("Linux ARM64", "linux-aarch64", "aarch64-linux-gnu.2.17", "aarch64-linux", "", ".so"),
    System("Windows x86-64", "windows-x86-64", "x86_64-windows-gnu", "x86_64-windows", "win64", ".dll"),
    System("macOS x86-64", "macos-x86-64", "x86_64-macos", "x86_64-darwin", "darwin64", ".dylib"),
    System("macOS ARM64", "macos-aarch64", "aarch64-macos", "aarch64-darwin", "darwin64", ".dylib"),
)
"""Systems of an FMU; FMI 2.0 has one folder for both processors of macOS, and a library with code for both."""


@dataclass(frozen=True)
class Linker:
    """Compiler that links libraries, and the systems that it links them for."""

    title: str
    command: tuple[str, ...]
    systems: tuple[System, ...]
    cross: bool  # whether the command has to be told the system

    def compiler(self, system: System) -> list[str]:
        """Return the start of a command that compiles and links for a system: small code for several, fast for one."""
        if not self.cross:
            return [*self.command, "-O2"]
        processor = PROCESSOR_FLAGS.get(system.triple.split("-")[0], ())
        return [*self.command, "-Os", "-target", system.triple, *processor]


def host_system() -> System | None:
    """Return the system of this computer; None: FMUs don't run on it."""
    name = {"linux": "linux", "win32": "windows", "darwin": "darwin"}.get(sys.platform, sys.platform)
    machine = {"amd64": "x86_64", "arm64": "aarch64"}.get(platform.machine().lower(), platform.machine().lower())
    return next((system for system in LINKED_SYSTEMS if system.folder == f"{machine}-{name}"), None)


def find_linker() -> Linker:
    """Return zig where it is installed, else the C compiler of this computer.

    Raises:
        MissingExtraError: neither is there.
    """
    if find_spec("ziglang") is not None:
        return Linker("zig", (sys.executable, "-m", "ziglang", "cc"), LINKED_SYSTEMS, cross=True)
    compiler, system = next(filter(None, map(which, C_COMPILERS)), None), host_system()
    if compiler is None or system is None:
        raise MissingExtraError("export", ["ziglang or a C compiler"], where="target fmu")
    return Linker(Path(compiler).name, (compiler,), (system,), cross=False)


def link_libraries(
    linker: Linker, version: str, header: str, objects: Mapping[System, Mapping[str, bytes]], folder: Path
) -> dict[System, bytes]:
    """Return the libraries of an FMU, for the systems that its version of FMI has.

    Args:
        linker: compiler and systems.
        version: a key of `FMI_SOURCES`.
        header: content of model.h.
        objects: object files of the laws for each system, by name.
        folder: for files on the way, which stay.

    Raises:
        CompilerError: the compiler fails.
    """
    systems = [system for system in linker.systems if system.folder_of(version)]
    of_others = [name for other, names in FMI_SOURCES.items() if other != version for name in names]
    sources = [path for path in sorted(SOURCE_FOLDER.glob("*.c")) if path.stem not in of_others]
    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        linked = pool.map(lambda system: _link(linker, system, sources, header, objects[system], folder), systems)
    return dict(zip(systems, linked, strict=True))


def compile_laws(linker: Linker, text: str, folder: Path) -> dict[System, bytes]:
    """Return the object files of laws in C for all systems.

    Args:
        linker: compiler and systems.
        text: file of C.
        folder: for files on the way, which stay.

    Raises:
        CompilerError: the compiler fails.
    """
    (folder / "law.c").write_text(text, encoding="utf-8")

    def compiled(system: System) -> bytes:
        code = folder / f"law-{system.folder}.o"
        unwinding = () if system.suffix == ".dll" else NO_UNWINDING
        words = [
            *linker.compiler(system),
            *C_FLAGS,
            *unwinding,
            *LAW_FLAGS,
            *(INLINE_THRESHOLD if linker.cross else ()),
            "-c",
            folder / "law.c",
            "-o",
            code,
        ]
        _run(words, folder, f"{linker.title} can't compile the FMU's laws for {system.title}")
        return code.read_bytes()

    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        return dict(zip(linker.systems, pool.map(compiled, linker.systems), strict=True))


def _run(words: Iterable[str | Path], folder: Path, failed: str) -> None:
    """Run a compiler in a folder; raise CompilerError with its first error after the words `failed`."""
    done = subprocess.run([*map(str, words)], cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        lines = [line for line in done.stderr.splitlines() if "error" in line] or done.stderr.splitlines()
        raise CompilerError(f"{failed} ({lines[0].strip() if lines else f'status {done.returncode}'})")


def _link(
    linker: Linker, system: System, sources: list[Path], header: str, objects: Mapping[str, bytes], folder: Path
) -> bytes:
    folder = folder / system.folder
    folder.mkdir(parents=True)
    (folder / "model.h").write_text(header, encoding="utf-8")
    for name, code in objects.items():
        (folder / f"{name}.o").write_bytes(code)
    library, laws = folder / f"library{system.suffix}", [f"{name}.o" for name in objects]
    command, failed = linker.compiler(system), f"{linker.title} can't link the FMU's library for {system.title}"
    compiled = [*command, *C_FLAGS, f"-I{folder}", f"-I{SOURCE_FOLDER}"]

    if linker.cross and system.suffix == ".dll":
        sources = [*sources, SOURCE_FOLDER / "windows" / "runtime.c"]
        for source in sources:
            _run([*compiled, "-c", source, "-o", f"source-{source.stem}.o"], folder, failed)
        _run([*command, "-shared", "-s", *laws, *(f"source-{source.stem}.o" for source in sources), *WINDOWS_LINKED,
              "-o", library], folder, failed)  # fmt: skip
    else:
        end = ("-lm",) if system.suffix == ".so" else ("-Wl,-x",)  # on macOS zig's -s leaves names of functions
        _run([*compiled, *NO_UNWINDING, "-shared", "-s", *sources, *laws, *end, "-o", library], folder, failed)
    return library.read_bytes()
