"""Laws of an FMU as a file of C: loops over the joints, and a function for each law, which plant and control share.

The compiler of the FMU's own sources makes about a third of the machine code of it that numba's code of the same laws
becomes, in which each joint has its own.
"""

from layflat.export.c_source.entry import entry_lines
from layflat.export.c_source.program import Program
from layflat.export.c_source.text import program_text
from layflat.export.fmu.model import FmuModel, prototype
from layflat.export.header import Api

STRUCT_PREFIX = "law"  # of the structs' names


def law_source(model: FmuModel) -> str:
    """Return the file of C with the functions that model.h declares.

    Raises:
        KindError: a construct of a law has no counterpart in C.
    """
    program = Program(Api(STRUCT_PREFIX, "double", ()), "double")
    functions = {
        entry.name: entry_lines(program, entry, [prototype(entry, "_row")], rows=True) for entry in model.entries
    }
    heads = ["#include <math.h>", "#include <stdbool.h>", "#include <stdint.h>"]
    return "\n".join([*heads, *program_text(program, functions), ""])
