"""Parameter studies: many samples of what varies, in one or several scenarios, as one table.

A reader's way: description.py (the file), study.py, varied.py, sampling.py, runs.py, folder.py, and then
results.py. Studies that come with layflat stand in builtin/.
"""

from layflat.study.folder import table
from layflat.study.runs import finished, run
from layflat.study.study import Study, names, read

__all__ = ["Study", "finished", "names", "read", "run", "table"]
