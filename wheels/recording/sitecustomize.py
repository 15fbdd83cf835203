"""Record the kernels that a Python process compiles, as object files for all processors of `LAYFLAT_RECORD_TARGETS`.

Python imports this module by itself in each process whose `PYTHONPATH` holds its folder, those that commands start
included. Kernels that are in the folder `LAYFLAT_RECORD` already are loaded from there, as from a wheel.
"""

import json
import os
from pathlib import Path
from typing import Any

from layflat import registers
from layflat.jit import functions, stored
from layflat.jit.cache import source_digest
from layflat.jit.objects import Processor, machine_code

FOLDER = Path(os.environ["LAYFLAT_RECORD"])
TARGETS = {level: Processor(*words) for level, words in json.loads(os.environ["LAYFLAT_RECORD_TARGETS"]).items()}


def record(kernel: functions.PortableKernel, args: tuple[Any, ...], text: str) -> None:
    """Write the object files of a kernel, and the digest of its sources."""
    name, entry = kernel.code_name(args), kernel.py_func.__name__
    for level, processor in TARGETS.items():
        stored.write_code(FOLDER / level / name, machine_code(text, (entry,), processor))
    source = FOLDER / stored.SOURCES_FOLDER / stored.source_name(kernel.file)
    source.write_text(source_digest(kernel.file), encoding="utf-8")


stored.PREBUILT_FOLDER = FOLDER
registers.set_register_bytes(int(os.environ["LAYFLAT_RECORD_LANES"]))
functions.COMPILATION_OBSERVERS.append(record)
