"""Parameter studies: many samples of varied values, in one or several scenarios, as one table.

Read in this order: description.py (the file), study.py, varied.py, sampling.py, runs.py, folder.py, results.py. The
built-in studies are in builtin/.
"""

from layflat.study.folder import study_table
from layflat.study.runs import is_finished, run_study
from layflat.study.study import Study, read_study, study_names

__all__ = ["Study", "is_finished", "read_study", "run_study", "study_names", "study_table"]
