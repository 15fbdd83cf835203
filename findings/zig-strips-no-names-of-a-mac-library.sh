#!/usr/bin/env bash
# zig's option -s leaves the names of all functions in a library of macOS, and does not say so.
#
# For Linux and Windows `zig cc -s` takes them out. Its own linker of Mach-O takes `-s`, `-Wl,-s` and `-Wl,--strip-all`,
# too, but only `-Wl,-x`, which it does not list, discards local names. With a few hundred static functions they are a
# twentieth of a compressed library.
#
#   options of zig cc -shared   static function in the symbol table of aarch64-macos
#   -s                          there
#   -Wl,-s                      there
#   -Wl,-x                      gone
# Run on 2026-11-29 with ziglang 0.17.1, Python 3.11, x86-64. Exits with 1 if the behaviour has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q ziglang==0.17.1
cat > "$folder/library.c" <<'C'
static __attribute__((noinline)) int local_function(int x) { volatile int y = x; return y * 3; }
int seen(int x) { return local_function(x) + 1; }
C
for option in -s -Wl,-s -Wl,-x; do
    "$folder/venv/bin/python" -m ziglang cc -target aarch64-macos -Os -shared "$option" "$folder/library.c" \
        -o "$folder/library.dylib"
    if grep -q local_function "$folder/library.dylib"; then echo "$option there"; else echo "$option gone"; fi
done | tee "$folder/printed"
diff "$folder/printed" - <<'EXPECTED'
-s there
-Wl,-s there
-Wl,-x gone
EXPECTED
