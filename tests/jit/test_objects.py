"""Object files in this process."""

import subprocess
import sys

import pytest

from layflat.export.targets import EXPORT_TARGETS
from layflat.jit import objects
from wheels.prebuilt import PROCESSORS

NOTHING = "define void @nothing() {\n  ret void\n}\n"

FAR_HOLE = """
import ctypes, mmap
from layflat.jit import objects

TEXT = '''
@table = internal global [1048576 x i32] zeroinitializer
define void @place(ptr %words) {
  %before = load i64, ptr %words
  %item = getelementptr [1048576 x i32], ptr @table, i64 0, i64 %before
  store i32 7, ptr %item
  %address = ptrtoint ptr %item to i64
  store i64 %address, ptr %words
  ret void
}
'''
code = objects.machine_code(TEXT, ("place",), objects.host())
system = ctypes.CDLL(None)
system.mmap.restype = ctypes.c_void_p
system.mmap.argtypes = [ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int, ctypes.c_int, ctypes.c_int, ctypes.c_long]


def reserve(size):
    return system.mmap(None, size, 0, mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS, -1, 0)


filled = [reserve(8 << 20) for _ in range(64)]
hole, block = reserve(1 << 20), reserve(1 << 28)  # the next free place is far below the hole
system.munmap(ctypes.c_void_p(hole), ctypes.c_size_t(1 << 20))
function, words = objects.load(code, "place"), (ctypes.c_int64 * 1)(0)
function(ctypes.addressof(words))
print(abs(words[0] - ctypes.cast(function, ctypes.c_void_p).value))
"""
"""Program that prints the distance of a function from its numbers, loaded where no free place holds both but one."""


@pytest.mark.skipif(sys.platform != "linux", reason="memory is laid out by Linux")
def test_parts_of_an_object_file_lie_side_by_side() -> None:
    """Distances between them have 32 bits; nothing else keeps free places of a large process from being farther."""
    done = subprocess.run([sys.executable, "-c", FAR_HOLE], capture_output=True, text=True, check=True)
    assert int(done.stdout) < 1 << 24


COMPUTERS = {name: one.processor for name, one in EXPORT_TARGETS.items() if name.startswith(("linux", "win", "mac"))}


@pytest.mark.parametrize("name", [*PROCESSORS, *COMPUTERS])
def test_the_start_of_object_files_is_what_llvm_writes(name: str) -> None:
    processor = (PROCESSORS | COMPUTERS)[name]
    start = objects.object_start(processor.triple)
    assert start
    assert objects.machine_code(NOTHING, ("nothing",), processor).startswith(start)
