#!/usr/bin/env bash
# zig cc takes -Oz for -Os, and -O1 for -O2, and does not say so: both give the same object files.
#
# Its modes of building have one for size and one for speed, to which it rounds Clang's levels. So the smallest code has
# to be asked for in the source, by `#pragma clang attribute push(__attribute__((minsize)), apply_to = function)`. In a
# file with 300 short functions of floating-point numbers this took 4 % off.
#
#   quotient of an integer and 7, x86-64    code
#   -Os, -Oz                                a product
#   -Os with the attribute minsize          the instruction idiv, as Clang's own -Oz
# Run on 2026-11-29 with ziglang 0.17.1, Python 3.11, x86-64. Exits with 1 if the behaviour has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q ziglang==0.17.1 2> /dev/null
cat > "$folder/seventh.c" <<'C'
SMALL int seventh(int x) { return x / 7; }
void twice(float *x, int n) { for (int i = 0; i < n; i++) x[i] *= 2; } /* Clang's -O1 makes no vectors of it */
C
for option in -Os -Oz -O1 -O2 "-Os -DSMALL=__attribute__((minsize))"; do
    # shellcheck disable=SC2086
    (cd "$folder" && venv/bin/python -m ziglang cc -target x86_64-linux-gnu -DSMALL= $option -Wno-macro-redefined -g0 \
        -S seventh.c -o seventh.s)
    if grep -q idiv "$folder/seventh.s"; then echo "$option idiv"; else echo "$option product"; fi
done | tee "$folder/printed"
diff "$folder/printed" - <<'EXPECTED'
-Os product
-Oz product
-O1 product
-O2 product
-Os -DSMALL=__attribute__((minsize)) idiv
EXPECTED
for pair in "-Os -Oz" "-O1 -O2"; do
    for option in $pair; do
        (cd "$folder" && venv/bin/python -m ziglang cc -target x86_64-linux-gnu -DSMALL= "$option" -g0 -c seventh.c \
            -o "seventh$option.o" 2> /dev/null)
    done
    # shellcheck disable=SC2086
    set -- $pair
    cmp "$folder/seventh$1.o" "$folder/seventh$2.o"
done
