#!/usr/bin/env bash
# ezdxf 1.4.5 writes the classes of a drawing in the order of a set, so that the same program writes different files.
#
# A DXF file has dates and random identifiers; `ezdxf.options.write_fixed_meta_data_for_testing` fixes them, so that the
# same drawing gives the same bytes. In one process it does. In the next one it does not: the section CLASSES lists the
# types in use as Python's set of strings has them, in an order that depends on the hash seed of the process. Whoever
# compares files of two runs, by a checksum in CI or in a build that must be reproducible, finds them different without
# a difference in the drawing. Adding the types in order before the file is written makes it the same.
# Run on 2026-11-29, Python 3.11. Exits with 1 if the behaviour has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q ezdxf==1.4.5
cd "$folder"
cat > draw.py <<'PYTHON'
import hashlib
import io
import sys

import ezdxf

ezdxf.options.write_fixed_meta_data_for_testing = True
document = ezdxf.new("R2010")
document.modelspace().add_circle((0, 0), 1.0)
if "sorted" in sys.argv:
    for name in sorted(document.entitydb.dxf_types_in_use()):
        document.classes.add_class(name)
stream = io.StringIO()
document.write(stream)
print(hashlib.sha256(stream.getvalue().encode()).hexdigest())
PYTHON
count() { for seed in 1 2 3 4 5 6 7 8; do PYTHONHASHSEED=$seed venv/bin/python draw.py "$@"; done | sort -u | wc -l; }
set_order=$(count)
sorted_order=$(count sorted)
echo "different files of one circle by 8 processes: $set_order as ezdxf writes them, $sorted_order with the classes in order"
[ "$set_order" -gt 1 ] && [ "$sorted_order" -eq 1 ]
