"""Real logs as recordings, and where to find them.

Lives here: readers of the files that others publish, what is known to be wrong with them, and what calibrates a log.
May not: estimate, draw, or download without being asked.
"""

from .registry import DATASETS, LOADERS, check, load_recording, prepare, report
from .sources import data_folders

__all__ = ["DATASETS", "LOADERS", "check", "data_folders", "load_recording", "prepare", "report"]
