"""Parameter studies: many samples of what varies, in one or several scenarios, as one table.

A reader's way: description.py (the file), study.py, sampling.py, chunk.py, run.py, folder.py, summary.py.
"""

from layflat.study.folder import table
from layflat.study.run import run
from layflat.study.study import Study, read

__all__ = ["Study", "read", "run", "table"]
