"""Control laws as readable C99: their syntax trees, translated function by function for the types of their arguments.

The way of a law: its source (`sources.py`) is read statement by statement (`statements.py`, `results.py`), its
expressions become values (`values.py`: known, computed, stored, or in parts) of types that follow those that the
compiler infers (`c_types.py`), by operations (`arithmetic.py`), functions for numbers side by side (`side_by_side.py`)
and calls (`calls.py`); names become constants or variables (`variables.py`, `storage.py`). A function is translated in
passes (`function.py`) until what one pass finds out about it, such as names that change in a loop, is what it began
with. The functions of a law and of all that it calls are a program (`program.py`), which is written with its constants
and structs in the order of the laws' modules (`text.py`, `lines.py`) into a folder (`folder.py`).
"""
